// Masked textures: where a surface is there, and mip levels that keep how much of it is.
//
// Based on: I. Castano, "Computing alpha mipmaps" (2010): alpha of each level scaled so that as many texels pass the
// test as in the first. Differs from the source: the scale is exact, from the level's histogram.
#pragma once
#include <cstdint>
#include <span>

#include "scene/character/character.h"

namespace crowdbench::scene {

// The least alpha of image times vertex colour that counts as there: the material's cutoff, its factor divided out. 0:
// it is not masked; above 1: nothing is there.
float alpha_threshold(const Material& material);

// The fraction of RGBA texels whose alpha is at least `threshold`.
double alpha_coverage(std::span<const uint8_t> rgba, float threshold);

// Scales alpha so that the fraction is as near to `wanted` as can be.
void scale_alpha_to(std::span<uint8_t> rgba, float threshold, double wanted);

}  // namespace crowdbench::scene
