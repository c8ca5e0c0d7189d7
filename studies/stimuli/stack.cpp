#include "studies/stimuli/stack.h"

#include <algorithm>
#include <cassert>

#include "core/random.h"

namespace crowdbench::studies {

StackSize stack_size(int width, int height, const StackStyle& style) {
  assert(style.bar_height >= 2 && style.bar_height % 2 == 0);
  return {width + width % 2, 2 * height + style.bar_height};
}

Image8 stack_vertically(const Image8& top, const Image8& bottom, const StackStyle& style) {
  assert(top.width == bottom.width && top.height == bottom.height);
  const auto [width, height] = stack_size(top.width, top.height, style);
  Image8 out(width, height, 3);
  for (size_t i = 0; i < out.pixels(); ++i) std::copy_n(style.bar_colour.data(), 3, &out.data[i * 3]);
  const auto place = [&out](const Image8& half, int first_row) {
    assert(half.channels == 3 || half.channels == 4);
    for (int y = 0; y < half.height; ++y) {
      for (int x = 0; x < half.width; ++x) std::copy_n(half.at(x, y), 3, out.at(x, first_row + y));
    }
  };
  place(top, 0);
  place(bottom, top.height + style.bar_height);
  return out;
}

bool first_on_top(uint64_t seed, uint64_t pair) { return (random_bits(seed, pair, kSidePurpose) >> 63) == 0; }

}  // namespace crowdbench::studies
