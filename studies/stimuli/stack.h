// Stacking: two pictures one above the other with a bar between them, so that one video shows both in step.
#pragma once
#include <array>
#include <cstdint>

#include "core/image.h"

namespace crowdbench::studies {

struct StackStyle {
  int bar_height = 8;                          // pixels, even, at least 2
  std::array<uint8_t, 3> bar_colour{0, 0, 0};  // sRGB
};

// Width and height of the stack of two pictures of width x height: both even (an odd width gains one column).
struct StackSize {
  int width;
  int height;
};
StackSize stack_size(int width, int height, const StackStyle& style = {});

// RGB of stack_size. top, bottom: 3 or 4 channels (alpha is left out), of equal size (asserted). The extra column of an
// odd width has the bar's colour.
Image8 stack_vertically(const Image8& top, const Image8& bottom, const StackStyle& style = {});

// Whether the first of two configurations is on top: the highest bit of random_bits(seed, pair, kSidePurpose), 0 = yes.
// pair: counts the pairs of one study from 0.
inline constexpr uint64_t kSidePurpose = 0x73696465;  // "side"
bool first_on_top(uint64_t seed, uint64_t pair = 0);

}  // namespace crowdbench::studies
