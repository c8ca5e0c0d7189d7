// How each agent of a frame is seen: how far away, how tall, and how much of it others hide.
//
// What an agent would cover alone is drawn, not estimated: agents whose projected bounds do not overlap cannot hide
// each other, so they are drawn together, and a crowd takes as many draws as bounds lie over one another at most (some
// tens), not one an agent. A silhouette predicted from other agents of like height would be off by pose and heading,
// which change it by more than the shares that are asked for here.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {

enum class AgentState : uint8_t {
  counted,   // whole within the picture, and enough of it visible
  occluded,  // whole within the picture, too little of it visible
  cut_off,   // a corner of its bounds lies outside the picture or before the near plane
  no_pixel   // whole within the picture, and too small to cover the middle of a pixel
};
// "counted", "occluded", "cut_off", "no_pixel".
const char* state_name(AgentState state);

struct AgentView {
  uint64_t tick = 0;
  uint32_t id = 0;       // agent index + 1
  size_t character = 0;  // into the cast
  double scale = 1;
  double distance = 0;          // metres, from the eye to the middle of its bounds
  double depth = 0;             // metres, of that middle along the view axis
  double pixels_per_metre = 0;  // at that depth; 0 behind the eye
  double height_px = 0;         // the character's height there, in pixels
  uint64_t alone_px = 0;        // that it would cover alone; 0 where it is cut off, which nobody counts
  uint64_t visible_px = 0;      // that carry its id
  AgentState state = AgentState::counted;
};

// Projected bounds, in pixels, row 0 on top: [left, right) x [top, bottom), all pixels that they touch.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
  bool whole = false;  // all corners in the picture and beyond the near plane; else the box means nothing
};
// Of the box around every pose of the character's bank, at the agent's place.
PixelBox projected_bounds(const scene::Frame& frame, const scene::FrameAgent& agent, const scene::PoseBank& bank);

// Boxes to groups within which none overlap, each in the first that has room; boxes that are not whole are left out.
// Elements are indices into `boxes`.
std::vector<std::vector<size_t>> disjoint_groups(const std::vector<PixelBox>& boxes);

// The agents of a frame, by ascending id. ids: of the frame as `representation` draws it (the reference, whose
// silhouettes count). least_visible: visible_px / alone_px below which an agent is occluded, 0..1. Throws Error.
std::vector<AgentView> view_agents(gl::Context& context, renderers::Renderer& renderer,
                                   renderers::Representation& representation, const scene::Frame& frame,
                                   const scene::Cast& cast, const ImageU32& ids, double least_visible);

}  // namespace crowdbench::bench
