// The maps of all boxes of a model in three pictures, with their mip levels: integer texel fetches of one level then
// reach everything, and boxes may differ in resolution.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/relief/relief_bake.h"

namespace crowdbench::renderers {

// Mip levels of a map of n texels: down to 4 a side, below which a joint is a blob of one colour.
uint32_t atlas_levels(int texels);

// Depth texels; the colour and normal pictures are twice as wide. A box takes 3 n x 3 n / 2: the three axes' level 0
// next to each other, under each its smaller levels from left to right.
struct AtlasPlan {
  int width = 0;
  int height = 0;
  std::vector<uint32_t> left;  // one a box
  std::vector<uint32_t> top;
};
AtlasPlan plan_atlas(const ReliefModel& model);

struct Atlas {
  std::vector<uint16_t> depth;  // width x height x 2
  std::vector<uint8_t> colour;  // 2 width x height x 4; six columns a box
  std::vector<uint8_t> normal;
};
// Halved levels. A texel is covered when at least two of its four children are: the silhouette keeps its area on
// average, and only depths of covered children are joined (least and greatest), so that no surface appears between a
// limb and nothing. Ids are not mixed.
Atlas fill_atlas(const ReliefModel& model, const AtlasPlan& plan);

}  // namespace crowdbench::renderers
