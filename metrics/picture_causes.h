// Error by cause of two pictures of which only code values and ids are known, and depths where there are some: what can
// be told from pictures alone (metrics/causes.h). The causes that ask for another drawing are not available.
//
// Differs from what is told with a renderer (metrics/surface_causes.h): who stands before whom, and what is shading and
// what is texture, is concluded, not known.
//
// Wrong surfaces are told by depth. A flat impostor's are those of its card, which is recognised (AgentChange::card):
// what is painted on it is shading and texture. One that is put together of several cards has depths beside the body's
// nearly everywhere. Where a depth is within the body's (no farther off than twice AgentChange::thickness), a pixel
// shows another surface of it only if the reference shows the pixel's colour, but for its lightness, on the agent near
// by; else the pixel counts as shading or texture.
//
// What cannot be told apart: a grey repainting from a change of the light (it counts as shading); a repainting in
// colours that the agent has near by, under other depths, from a wrong surface; a shift by less than about 0.1 pixel
// from nothing, and a shift by about AgentChange::told_px or less from an outline that is wrong by itself, as an
// impostor's is of a stored view and pose; a shift of the colours alone, under ids that stayed, from another texture;
// an agent nearer and one drawn larger, without depths; an agent that is a frame late from a wrong outline, without
// that frame (PicturesWithIds::posed), and then its wrong surfaces from its texture, since that frame's depths are not
// given. An agent that moved by a fraction of a pixel and was recoloured shows colours of which nobody knows where
// between two samples they lie: that much of its place is counted as texture.
#pragma once
#include <optional>
#include <vector>

#include "metrics/causes.h"

namespace crowdbench::metrics {

inline constexpr double kSurfaceTolerance = 0.02;  // metres between depths of one agent that are of one surface

// Of one size; pointers may be null where it is said.
struct PicturesWithIds {
  const Image8& reference;
  const Image8& test;
  const ImageU32& reference_ids;
  const ImageU32& test_ids;
  const ImageF* reference_depth = nullptr;  // both or none: metres, +infinity where empty
  const ImageF* test_depth = nullptr;
  const Image8* posed = nullptr;  // both or none: the reference in the poses that the test may have, a frame late say
  const ImageU32* posed_ids = nullptr;
};

// What happened to an agent.
struct AgentChange {
  uint32_t id = 0;
  bool posed = false;     // it has the pose of PicturesWithIds::posed
  double dx = 0, dy = 0;  // pixels: its middle moved so far, right and down
  // Pixels: what differs of its outlines, where it was found to be, is as much as a shift by about this makes differ
  // (less where it is thin). A displacement of that size that explains less than half of it is not told from a wrong
  // outline. 0: the outlines are the same.
  double told_px = 0;
  // Its mean colour, over the pixels that show it in both pictures, changed by more than its lightness: what a blurred
  // texture, a wrong outline or other light do not change.
  bool recoloured = false;
  // Metres, with depths: how far it moved away, where all of its depths and its size changed as those of a body that
  // moved do, or where they did not change. Nothing: other depths without that, as a flat impostor's, whose plane is
  // behind most of the surface that it shows: that is no other place.
  std::optional<double> farther;
  // With depths: how much farther the surface that the test draws for it is than the reference's, at the same points of
  // the body, the median over its pixels; and from the nearest to the farthest of the reference's, 5 % of either end
  // left out. What is within `thickness` is another surface of the same body.
  std::optional<double> surface_farther;  // metres
  double thickness = 0;                   // metres; 0 without depths
  // With depths: those of the test lie in one plane, the reference's do not. They say where a flat impostor stands and
  // not which surface a pixel shows, so that none of its pixels counts as a wrong surface.
  bool card = false;
  std::vector<uint32_t> changed_places_with;  // that it stood before, and which stand before it now
};

struct PictureCauses {
  CauseErrors errors;
  std::vector<AgentChange> changes;  // by ascending id: every agent of the two pictures
};

// Throws Error when sizes differ.
PictureCauses causes_of_pictures(const PicturesWithIds& pictures);

}  // namespace crowdbench::metrics
