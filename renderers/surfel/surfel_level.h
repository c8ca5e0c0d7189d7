// How many surfels a figure is drawn with.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crowdbench::renderers {

struct SurfelLevel {
  uint32_t points = 0;
  double radius = 0;  // metres: discs of it about the points reach the whole surface
};
// 64 points and then twice as many each, up to all. radius: SurfelCloud::radius. Empty where that is.
std::vector<SurfelLevel> surfel_levels(std::span<const float> radius);

struct SurfelRule {
  double size = 1;   // pixels: the radius that discs may have
  double cover = 1;  // factor of a level's radius
};
// The first level whose discs have a radius of at most rule.size pixels where a metre is `metre` of them; else the
// last.
size_t surfel_level(std::span<const SurfelLevel> levels, const SurfelRule& rule, double metre);

}  // namespace crowdbench::renderers
