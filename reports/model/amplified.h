// The difference of two pictures, made bright enough to be seen.
#pragma once
#include <optional>

#include "core/image.h"

namespace crowdbench::reports {

struct Amplified {
  Image8 picture;   // RGB: the difference of each channel's code values times the factor, at most 255; black: equal
  int factor = 1;   // 1, 2, 4, ... 64: the largest by which no more than one channel in a hundred that differs is cut
  int largest = 0;  // difference of a channel, code values
};
// a, b: sRGB-encoded, three or four channels, of which the first three count. Nothing where their sizes or channels are
// others, or they are equal.
std::optional<Amplified> amplified_difference(const Image8& a, const Image8& b);

}  // namespace crowdbench::reports
