#include "renderers/relief/relief_gaps.h"

#include <algorithm>
#include <cstdint>

namespace crowdbench::renderers {
namespace {

// Widens the intervals of two neighbours to where a surface that lies in both crosses from one into the other.
void join(const Touched& a, const Touched& b, std::array<double, 2>& at_a, std::array<double, 2>& at_b) {
  const bool ordered = at_a[1] < at_b[0];
  const Touched& below = ordered ? a : b;
  const Touched& above = ordered ? b : a;
  std::array<double, 2>& lower = ordered ? at_a : at_b;
  std::array<double, 2>& upper = ordered ? at_b : at_a;
  // Diagonal neighbours share one corner, where a sloping surface has one's least and the other's greatest depth: equal
  // but for rounding.
  if (lower[1] >= upper[0] || above.low > below.high + 1e-9) return;
  const double meeting = std::clamp(0.5 * (lower[1] + upper[0]), std::min(above.low, below.high), below.high);
  lower[1] = std::max(lower[1], meeting);
  upper[0] = std::min(upper[0], meeting);
}

}  // namespace

void close_gaps(AxisMaps& maps) {
  const size_t n = maps.n;
  const std::vector<Touched>& touched = maps.kept;
  std::vector<Winner>& front = maps.winners[0];
  std::vector<Winner>& back = maps.winners[1];
  std::vector<std::array<double, 2>>& intervals = maps.intervals;
  const auto covered = [&](size_t texel) { return maps.covered(texel); };
  for (size_t texel = 0; texel < n * n; ++texel) intervals[texel] = {front[texel].depth, back[texel].depth};
  const auto join_all = [&] {
    for (size_t v = 0; v < n; ++v) {
      for (size_t u = 0; u < n; ++u) {
        const size_t a = v * n + u;
        if (!covered(a)) continue;
        // Diagonal ones too: a step may pass a corner.
        const bool below = v + 1 < n;
        for (const size_t b : {u + 1 < n ? a + 1 : a, below ? a + n : a, below && u + 1 < n ? a + n + 1 : a,
                               below && u > 0 ? a + n - 1 : a})
          if (b != a && covered(b)) join(touched[a], touched[b], intervals[a], intervals[b]);
      }
    }
  };
  join_all();
  // Walls seen edge-on: no centre finds them, or another surface covers the centre.
  std::vector<size_t> missed;
  const double slack = 1.0 / static_cast<double>(n);
  for (size_t v = 0; v < n; ++v) {
    for (size_t u = 0; u < n; ++u) {
      const size_t texel = v * n + u;
      if (!touched[texel].any()) continue;
      bool held = false;
      for (const size_t near : {texel, u > 0 ? texel - 1 : texel, u + 1 < n ? texel + 1 : texel,
                                v > 0 ? texel - n : texel, v + 1 < n ? texel + n : texel})
        held = held || (covered(near) && intervals[near][0] <= touched[texel].low + slack &&
                        intervals[near][1] >= touched[texel].high - slack);
      if (!held) missed.push_back(texel);
    }
  }
  for (const size_t texel : missed) {
    const bool alone = !covered(texel);
    if (alone || touched[texel].low < intervals[texel][0]) {
      front[texel] = touched[texel].front;
      intervals[texel][0] = touched[texel].low;
    }
    if (alone || touched[texel].high > intervals[texel][1]) {
      back[texel] = touched[texel].back;
      intervals[texel][1] = touched[texel].high;
    }
  }
  if (!missed.empty()) join_all();
}

size_t middle_of(const AxisMaps& maps, size_t u, size_t v, size_t side) {
  size_t found = maps.n * maps.n;
  size_t nearest = 2 * side * side;
  const auto from = [side](size_t x) { return 2 * x + 1 > side ? 2 * x + 1 - side : side - 2 * x - 1; };
  for (size_t y = 0; y < side; ++y)
    for (size_t x = 0; x < side; ++x) {
      const size_t texel = (v * side + y) * maps.n + u * side + x;
      const size_t off = from(x) * from(x) + from(y) * from(y);
      if (off >= nearest || !maps.covered(texel)) continue;
      found = texel;
      nearest = off;
    }
  return found;
}

}  // namespace crowdbench::renderers
