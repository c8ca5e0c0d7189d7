// How coarsely the bake of a representation that stores views samples the directions and poses of a character.
#pragma once
#include <cstdint>
#include <span>

#include "renderers/impostor/views/view_grid.h"

namespace crowdbench::renderers {

struct ViewSampling {
  ViewGrid grid;
  int frames = 1;              // stored of a clip that moves
  double texel = 0;            // metres, of the finest level
  uint64_t texture_bytes = 0;  // by the bounds of what is stored, all levels
  // How far the farthest vertex moves from one stored frame to the next, metres: over all pairs, and their mean.
  double pose_step_largest = 0, pose_step_mean = 0;
};

// From pose_steps (renderers/impostor/tiles/stored_frames.h); zeros where there are none.
void set_pose_steps(ViewSampling& sampling, std::span<const double> steps);

}  // namespace crowdbench::renderers
