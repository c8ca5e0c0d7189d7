// Cone maps for search=cone: how far a ray may go, from what one texel stores, without passing a surface unseen.
//
// Lengths are unit coordinates of the box, distances across the map the greater of |du| and |dv|, so that a cone is a
// square pyramid and a texel's square a ball. The search marches in the map of the axis that a ray crosses most of:
// across / along is at most 1, and so is every ratio stored here (1: whatever lies beside it, no ray gets there).
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "renderers/relief/relief_atlas.h"

namespace crowdbench::renderers {

// One texel's cones, for rays that go up (along the axis) and down, as codes of cone_ratio().
// approach: apex on the surface that the ray has before it, opening toward the ray: a ray that goes from the column of
//   this texel, inside the cone, into a surface does not come out of it before it leaves the cone. (Relaxed: it may
//   pass into one surface, never through it.) An empty texel has its apex on the far side of the box.
// leave: apex on the surface that the ray has behind it, opening away: no surface lies inside. An empty texel has its
//   apex on the near side.
// Both hold for every ray from anywhere above or below the texel's square when the cone is narrowed by one texel all
// around: half for where in its own texel the ray is, half for where in the other texel the surface is.
struct TexelCones {
  uint8_t approach_up = 255;
  uint8_t leave_up = 255;
  uint8_t approach_down = 255;
  uint8_t leave_down = 255;
};

// Distance across the map over depth: the square of code / 255, so that narrow cones keep their precision.
double cone_ratio(uint8_t code);

// depth: n x n texels of [least, greatest], 16 bits, empty ones (65535, 0), as in ReliefModel::depth. Ratios are
// rounded down.
std::vector<TexelCones> derive_cones(const uint16_t* depth, size_t n);

// Of every map and level of the atlas, in the depth picture's layout, four bytes a texel: TexelCones. Parallel over
// maps, which progress counts; deterministic.
std::vector<uint8_t> derive_cones(const ReliefModel& model, const AtlasPlan& plan, const Atlas& atlas,
                                  const BakeProgress& progress = {});

}  // namespace crowdbench::renderers
