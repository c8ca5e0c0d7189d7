// How alike two captures of one frame are. Covered: an agent's id stands there.
#pragma once
#include <algorithm>
#include <cstdlib>

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
  return static_cast<double>(same) / both;
}

// The largest difference of a channel over the pixels that both cover, code values.
inline int worst_colour_difference(const Capture& a, const Capture& b) {
  int worst = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i)
    if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
      for (size_t k = 0; k < 3; ++k)
        worst = std::max(worst, std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}));
  return worst;
}

// The mean difference of a channel over the pixels that either covers, code values.
inline double mean_colour_difference(const Capture& a, const Capture& b) {
  double sum = 0;
  double count = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 && b.ids.data[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) sum += std::abs(int{a.colour.data[4 * i + c]} - int{b.colour.data[4 * i + c]});
    count += 3;
  }
  return count == 0 ? 0 : sum / count;
}

}  // namespace crowdbench::renderers::testing
