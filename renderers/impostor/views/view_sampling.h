// How coarsely the bake of a representation that stores views samples the directions and poses of a character.
#pragma once
#include <cstdint>
#include <span>

#include "renderers/impostor/views/view_grid.h"

namespace crowdbench::renderers {

// Where a view's picture lies when it is drawn.
enum class ViewLies : uint8_t {
  nearest,  // on the plane nearest to the body (fit_plane, of renderers/impostor/tiles/plane.h)
  across,   // across the view, through the centre
  by_part   // each body part on a plane of its own
};

struct ViewSampling {
  ViewGrid grid;
  int frames = 1;              // stored of a clip that moves
  double texel = 0;            // metres, of the finest level
  uint64_t texture_bytes = 0;  // by the bounds of what is stored, all levels
  // How far the farthest vertex moves from one stored frame to the next, metres: over all pairs, and their mean.
  double pose_step_largest = 0, pose_step_mean = 0;
  glm::dvec3 centre{0.0};  // that the planes of all views go through: model space, metres
  ViewLies lies = ViewLies::nearest;
  bool surface_depth = false;  // what is drawn has the depth of the surface that it shows, not that of a plane
};

// From pose_steps (renderers/impostor/tiles/stored_frames.h); zeros where there are none.
void set_pose_steps(ViewSampling& sampling, std::span<const double> steps);

}  // namespace crowdbench::renderers
