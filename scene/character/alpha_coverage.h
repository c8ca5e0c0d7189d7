// Masked textures: where a surface is there, and mip levels that keep how much of it is.
//
// Based on: I. Castano, "Computing alpha mipmaps" (2010): alpha of each level scaled so that as much passes the test as
// in the first. Differs from the source: what is kept is area as it is sampled, between texels, and not a number of
// texels; and a level that no scale can hold is found out, by places: stripes, checkers and nets of a level's texels
// average to one grey, of which any scale leaves all or nothing. There the levels end.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// The least alpha of image times vertex colour that counts as there: the material's cutoff, its factor divided out. 0:
// it is not masked; above 1: nothing is there.
float alpha_threshold(const Material& material);

// The fraction of RGBA texels whose alpha is at least `threshold`.
double alpha_coverage(std::span<const uint8_t> rgba, float threshold);

// The alpha of a texture's level, row by row.
struct AlphaLevel {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> alpha;
};

// How a level is looked at: between texels or at the nearest one, and what lies beyond its edges.
struct AlphaSampling {
  bool linear = true;
  bool repeat_u = true;
  bool repeat_v = true;
};

class CoverageKeeper {
 public:
  // base: the first level, of at least one texel. threshold: in (0, 1]. near: how the first level is magnified; far:
  // how the others are sampled.
  CoverageKeeper(const AlphaLevel& base, float threshold, const AlphaSampling& near, const AlphaSampling& far);

  // The share of the first level that is there, [0, 1].
  double covered() const;
  // Scales the alpha of a coarser level so that it covers as much as the first. False, and as it was, where no scale
  // comes within 3 % of that, or where the level does so elsewhere than the first.
  bool keep(AlphaLevel& level) const;

 private:
  float threshold_;
  AlphaSampling far_;
  int side_ = 1;
  std::vector<double> cells_;  // side_ x side_ of the picture: the share of each that is there
};

}  // namespace crowdbench::scene
