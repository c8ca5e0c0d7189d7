// How alike two captures of one frame are. Covered: an agent's id stands there.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "renderers/frame/capture.h"

namespace crowdbench::renderers::testing {

inline size_t covered(const Capture& c) {
  return static_cast<size_t>(std::count_if(c.ids.data.begin(), c.ids.data.end(), [](uint32_t id) { return id != 0; }));
}

// Pixels that both cover over those that either does; 0 where nobody is seen.
inline double iou(const Capture& a, const Capture& b) {
  int both = 0;
  int either = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    both += a.ids.data[i] != 0 && b.ids.data[i] != 0;
    either += a.ids.data[i] != 0 || b.ids.data[i] != 0;
  }
  return either == 0 ? 0 : static_cast<double>(both) / either;
}

// Share of the pixels that both cover that show the same agent.
inline double same_ids(const Capture& a, const Capture& b) {
  int same = 0;
  int both = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 || b.ids.data[i] == 0) continue;
    ++both;
    same += a.ids.data[i] == b.ids.data[i];
  }
  return both == 0 ? 0 : static_cast<double>(same) / both;
}

// Pixels that show another agent, or an agent in one alone.
inline size_t different_ids(const Capture& a, const Capture& b) {
  size_t n = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) n += a.ids.data[i] != b.ids.data[i] ? 1U : 0U;
  return n;
}

// Pixels whose right or lower neighbour is covered and they are not, or the other way round.
inline size_t outline_pixels(const Capture& c) {
  size_t n = 0;
  for (int y = 0; y + 1 < c.ids.height; ++y)
    for (int x = 0; x + 1 < c.ids.width; ++x) {
      const bool in = *c.ids.at(x, y) != 0;
      n += in != (*c.ids.at(x + 1, y) != 0) || in != (*c.ids.at(x, y + 1) != 0) ? 1U : 0U;
    }
  return n;
}

// The largest difference of a channel over the pixels that both cover, code values; 255 where there are none.
inline int worst_colour_difference(const Capture& a, const Capture& b) {
  int worst = -1;
  for (size_t i = 0; i < a.ids.data.size(); ++i)
    if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
      for (size_t k = 0; k < 3; ++k)
        worst = std::max(worst, std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}));
  return worst < 0 ? 255 : worst;
}

// The mean difference of a channel over the pixels that either covers, code values; 255 where there are none.
inline double mean_colour_difference(const Capture& a, const Capture& b) {
  double sum = 0;
  double count = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 && b.ids.data[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) sum += std::abs(int{a.colour.data[4 * i + c]} - int{b.colour.data[4 * i + c]});
    count += 3;
  }
  return count == 0 ? 255 : sum / count;
}

// How a picture differs from the mesh's at the identical camera.
struct Difference {
  double iou = 0;
  double mean_depth = 0;   // metres, inside both silhouettes
  double worst_depth = 0;  // metres, 99 % of the pixels inside both, by the mesh's silhouette shrunk by two pixels
  double mean_colour = 0;  // code values, inside both
  int pixels = 0;          // of the mesh
  int drawn = 0;           // of the test
  int inside = 0;          // pixels whose 5 x 5 neighbours the mesh all covers: where a hole can be
  int holes = 0;           // of these, those that the test does not cover
  int strays = 0;          // pixels of the test farther than two pixels from the mesh
};

inline Difference difference(const Capture& mesh, const Capture& test) {
  Difference d;
  const int w = mesh.ids.width;
  const int h = mesh.ids.height;
  int both = 0;
  int either = 0;
  std::vector<double> gaps;
  const auto around = [&](int x, int y, bool all) {
    for (int j = std::max(0, y - 2); j <= std::min(h - 1, y + 2); ++j)
      for (int i = std::max(0, x - 2); i <= std::min(w - 1, x + 2); ++i)
        if ((*mesh.ids.at(i, j) != 0) != all) return !all;
    return all;
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const bool in_a = *mesh.ids.at(x, y) != 0;
      const bool in_b = *test.ids.at(x, y) != 0;
      d.pixels += in_a;
      d.drawn += in_b;
      either += in_a || in_b;
      const bool inside = in_a && around(x, y, true);
      d.inside += inside;
      if (inside && !in_b) ++d.holes;
      if (in_b && !in_a && !around(x, y, false)) ++d.strays;
      if (!in_a || !in_b) continue;
      ++both;
      const double gap =
          std::abs(static_cast<double>(*mesh.depth.at(x, y)) - static_cast<double>(*test.depth.at(x, y)));
      if (inside) gaps.push_back(gap);
      d.mean_depth += gap;
      for (int c = 0; c < 3; ++c) d.mean_colour += std::abs(mesh.colour.at(x, y)[c] - test.colour.at(x, y)[c]) / 3.0;
    }
  }
  std::sort(gaps.begin(), gaps.end());
  if (!gaps.empty()) d.worst_depth = gaps[std::min(gaps.size() - 1, gaps.size() * 99 / 100)];
  d.iou = either > 0 ? static_cast<double>(both) / either : 0;
  d.mean_depth /= std::max(both, 1);
  d.mean_colour /= std::max(both, 1);
  return d;
}

}  // namespace crowdbench::renderers::testing
