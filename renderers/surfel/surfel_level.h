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
  double reach = 1;   // factor of Surfel::reach, the most that a disc's radius may be (fit_reach)
  // Of figures of few pixels (fit_areas): factor of the radii of all discs, (0, 1], and how far areas are off then.
  double thin = 1, uneven = 0;
};
// 64 points and then twice as many each, up to all. radius: SurfelOrder::radius. Empty where that is.
std::vector<SurfelLevel> surfel_levels(std::span<const float> radius);

struct SurfelRule {
  double size = 1;   // pixels: the radius that discs may have
  double cover = 1;  // factor of a level's radius
};
// Levels whose areas are farther off are not drawn while another is even enough: seen from one side such a crowd would
// be too large or too small.
inline constexpr double kEven = 0.025;
// The first level that is even enough, of at least kPointsEnough points or the last, and whose discs have a radius of
// at most rule.size pixels where a metre is `metre` of them; else the last.
inline constexpr uint32_t kPointsEnough = 4096;
size_t surfel_level(std::span<const SurfelLevel> levels, const SurfelRule& rule, double metre);

}  // namespace crowdbench::renderers
