// The texels of one map while a relief is captured: what was found in each, and the intervals of depth made of it, such
// that no gap opens where one surface passes from a texel into the next.
#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "renderers/relief/relief_surface.h"

namespace crowdbench::renderers {

// What surfaces lie within one texel's square.
struct Touched {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  Winner front;  // by the middle of each triangle's part in the square
  Winner back;
  bool any() const { return front.triangle != UINT32_MAX; }
};

// What an axis of a box sees, texel by texel; the winners at texel centres, the nearest and the farthest.
struct AxisMaps {
  size_t n;  // texels a side
  std::array<std::vector<Winner>, 2> winners;
  std::vector<Touched> touched;
  std::vector<Touched> kept;                     // of these, what the winners are of
  std::vector<std::array<double, 2>> intervals;  // least and greatest depth
  explicit AxisMaps(size_t side)
      : n(side), winners{std::vector<Winner>(n * n), std::vector<Winner>(n * n)}, touched(n * n), intervals(n * n) {}
  bool covered(size_t texel) const { return winners[0][texel].triangle != UINT32_MAX; }
};

// From the winners at texel centres to closed intervals, see ReliefModel. Depths in [0, 1].
void close_gaps(AxisMaps& maps);

// Of a square of `side` texels the covered one nearest to its middle; none: n * n. (u, v): which square.
size_t middle_of(const AxisMaps& maps, size_t u, size_t v, size_t side);

}  // namespace crowdbench::renderers
