// The maps of all boxes of a model in three pictures, with their mip levels: integer texel fetches of one level then
// reach everything, and boxes may differ in resolution.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/relief/relief_bake.h"

namespace crowdbench::renderers {

// Mip levels of a map of n texels: down to 4 a side, below which a joint is a blob of one colour. Depths are searched
// down to 8: of 4 by 4 texels, one is more than a twentieth of what a limb covers.
uint32_t atlas_levels(int texels);

// Depth texels; the colour and normal pictures are twice as wide, and of a cube the depth picture too: six maps a box.
// A box takes 3 n x 3 n / 2: the three axes' level 0 next to each other, under each its smaller levels from left to
// right.
struct AtlasPlan {
  int width = 0;
  int height = 0;
  std::vector<uint32_t> left;  // one a box
  std::vector<uint32_t> top;
};
AtlasPlan plan_atlas(const ReliefModel& model);

// First texel, in the depth picture, of a box's axis 0 at one level; the other axes follow `texels` to the right each.
struct AtlasPlace {
  size_t left = 0;
  size_t top = 0;
};
AtlasPlace atlas_place(const AtlasPlan& plan, size_t box, size_t texels, uint32_t level);

struct Atlas {
  std::vector<uint16_t> depth;  // width x height x 2; of a cube twice as wide
  std::vector<uint8_t> colour;  // 2 width x height x 4; six columns a box
  std::vector<uint8_t> normal;
  std::vector<uint8_t> emission;  // as colour (renderers/bake/emission.h); empty where nothing glows
  // width/2 x height/2 x 2: one texel for two by two of the depth picture's, level by level. Least and greatest depth
  // of anything that touches these texels or, on the level's own scale, the texels next to them, rounded outward: what
  // lies outside, in any of the three axes' maps, is air.
  std::vector<uint8_t> bounds;  // of a cube empty
};
// Halved levels. A texel is covered when half of the area under it is at level 0, but that every aligned square of four
// texels and more keeps the area that it has at level 0, within a texel: patterns neither close nor vanish. Where that
// asks for fewer or more, the fullest texels are taken. Only depths of covered children are joined (their means), so
// that no surface appears between a limb and nothing. Ids are not mixed, emission is averaged in linear light; colours
// are the model's own of each level. Both are spread beyond the silhouette by two texels so that they can be filtered.
Atlas fill_atlas(const ReliefModel& model, const AtlasPlan& plan);

}  // namespace crowdbench::renderers
