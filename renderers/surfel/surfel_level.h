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
  // Factors of the radii of all discs, (0, 1], in figures of few pixels and in others, and how far areas are off then
  // (SurfelArea).
  double thin = 1, uneven = 0;
  double closed = 1, over = 0;
};
// 64 points and then twice as many each, up to all. radius: SurfelOrder::radius. Empty where that is.
std::vector<SurfelLevel> surfel_levels(std::span<const float> radius);

struct SurfelRule {
  double size = 1;   // pixels: the radius that discs may have
  double cover = 1;  // factor of a level's radius
};
// Pixels of a figure's longest side: up to the first discs are thin, from the second on closed, between them between
// (surfel.vert).
inline constexpr double kFewPixels[2] = {8, 64};
// Levels whose areas are farther off are not drawn while another is even enough: seen from one side such a crowd would
// be too large or too small. Thin discs of at least kPointsEnough points are even enough.
inline constexpr double kEven = 0.025;
inline constexpr uint32_t kPointsEnough = 4096;
// Levels that would cover more than this of the character's area beside it are not drawn.
inline constexpr double kOver = 0.04;
// The first level that covers as much as it should and whose discs have a radius of at most rule.size pixels where a
// metre is `metre` of them; else the last. tall: of the figure's longest side, metres.
size_t surfel_level(std::span<const SurfelLevel> levels, const SurfelRule& rule, double metre, double tall);

}  // namespace crowdbench::renderers
