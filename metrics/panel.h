// A picture with words above it: what a reader must know to tell the panels of one picture apart.
#pragma once
#include <span>
#include <string>

#include "core/image.h"

namespace crowdbench::metrics {

// `picture` (RGB) in the middle of a ground of sRGB 64, 64, 64, the lines above it in light grey, from the top, 16
// pixels each. A line that is wider than the picture and than `widest` pixels is broken after a space, comma or bar,
// and where there is none within that, it makes the panel wider. Words are ASCII; others are drawn as "?".
Image8 with_words_above(const Image8& picture, std::span<const std::string> lines, int widest = 320);

}  // namespace crowdbench::metrics
