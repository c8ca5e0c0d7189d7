// Switch distance: where a texel of an impostor covers a given number of pixels, derived from the lens and measured
// from pictures of the impostor as it is drawn.
//
// A texel covers s metres of its plane, scaled by the agent. In a picture of H rows with the vertical field of view
// fov, a pixel at eye-space depth d covers p(d) = 2 d tan(fov/2) / H metres across the direction in which the agent
// lies off the axis. The pixel-to-texel ratio is r = s / p, so d(r) = s H / (2 r tan(fov/2)). Along that direction
// perspective stretches every picture by 1 / cos(angle), the mesh's and the impostor's alike.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderers/gl/context.h"
#include "renderers/representation.h"
#include "scene/character/character.h"

namespace crowdbench::bench {

struct SwitchRequest {
  std::shared_ptr<const scene::Character> character;
  renderers::Spec representation;
  std::vector<double> ratios{0.5, 1, 2};  // screen pixels spanned by one texel
  int width = 640;
  int height = 480;
  double fov_y_deg = 35;     // vertical, (0, 170]
  double azimuth_deg = 0;    // from where the agent is seen: 0 = from the front, 90 = from its left
  double elevation_deg = 0;  // positive = from above
  double off_axis_deg = 0;   // angle between the view axis and the agent, to the right
  double scale = 1;          // of the agent
  int clip = -1;             // into Character::clips; -1: the bind pose
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
};

// The same place in the units in which engines are told to switch. What an engine calls a size is of its own bounds:
// here of the character's posed bounds over the clip, scaled.
struct EngineSizes {
  // Unity, LOD.screenRelativeTransitionHeight at lodBias 1: LODGroup.size (the largest extent of the bounds) over the
  // height of the view at the Euclidean distance: size / (2 distance tan(fov/2)).
  double unity_height = 0;
  // Unreal, ComputeBoundsScreenSize: diameter of the bounding sphere over the screen at the Euclidean distance:
  // max(P00, P11) radius / distance, P the projection. Distances below 1 unit (a centimetre) count as one.
  double unreal_size = 0;
  // Godot, GeometryInstance3D.visibility_range_end and _begin: metres from the camera to the middle of the bounds.
  double godot_metres = 0;
};

struct SwitchRow {
  double ratio = 1;
  double depth = 0;      // derived, metres along the view axis to the capture centre
  double distance = 0;   // the same place, Euclidean
  double height_px = 0;  // the character's height at that depth
  double stretch = 1;    // derived: pixels of a texel in the direction off the axis over those across it
  EngineSizes engines;
  // From pictures; nothing where the agent covers too few pixels or lies outside the picture at that place.
  std::optional<double> measured_depth;
  std::optional<double> measured_stretch;
};

struct SwitchReport {
  // Whether pictures were measured: not of a representation that does not draw Pass::texels, whose texel is then taken
  // at its word.
  bool measured = true;
  double texel = 0;   // metres, at scale 1
  double height = 0;  // the character's, metres, at scale 1
  std::vector<SwitchRow> rows;
};

// d(r) above. texel: metres, the agent's scale included. Radians.
double derive_switch_depth(double ratio, double texel, int rows, double fov_y);
// bounds: the box's edges in metres. distance: metres, Euclidean. aspect: width over height.
EngineSizes engine_sizes(const glm::dvec3& bounds, double distance, double fov_y, double aspect);

// Pixels that a texel of the drawn impostor spans at its capture centre, along x and along y, by a least-squares fit to
// the texel coordinates (renderers::Pass::texels) of the pixels around it.
struct TexelFootprint {
  double across_x = 0;
  double across_y = 0;
};
// texels: R, G in texels; ids: 0 = nothing; (x, y): pixels, row 0 on top. Pixels further than `radius` from there are
// left out. Nothing with fewer than 12 pixels or when these lie on a line.
std::optional<TexelFootprint> fit_texel_footprint(const ImageF& texels, const ImageU32& ids, double x, double y,
                                                  double radius);

// Throws Error: a representation without texels, an agent outside the picture.
SwitchReport measure_switch_distance(gl::Context& context, const SwitchRequest& request);

}  // namespace crowdbench::bench
