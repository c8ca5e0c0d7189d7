// The error picture: dark blue where two pictures are equal, red where they differ as much as they can.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// 256 sRGB colours, for values from the one end of a scale to the other.
using ColourTable = std::array<std::array<uint8_t, 3>, 256>;

// 256 sRGB colours from dark blue (0) over violet to red (255). Lightness rises all the way and neighbours are equally
// far apart in OKLab, so that a larger error never looks like a smaller one, in print and to colour-blind readers too.
const ColourTable& error_colours();
// Perceptually uniform and dark at 0: black over violet to pale yellow, and dark violet over green to yellow. FLIP's
// tool paints errors in the first and exposures in the second.
const ColourTable& magma_colours();
const ColourTable& viridis_colours();
// White to black: what is equal is white.
const ColourTable& grey_colours();

// The mean of |a - b| over R, G and B, rounded: one channel. Its mean is the MAE up to rounding. Throws Error when the
// sizes differ.
Image8 error_levels(const Image8& a, const Image8& b);
Image8 error_levels(const Image16& a, const Image16& b);

// One channel of 0..255 through a table: RGB, same size.
Image8 pseudocolour(const Image8& levels, const ColourTable& colours = error_colours());

// What the ends of a colour bar stand for.
struct BarRange {
  double first = 0;   // the table's first colour
  double last = 255;  // its last
  bool open = false;  // values beyond `last` have its colour: it is labelled ">= 255", or "<= 5" where values fall
};

// The colour bar alone, RGB on white: its ends and quarters labelled and `caption` beneath, in two lines where it would
// be wider than the bar. As wide as `width` pixels, or more where the words need it; 66 x scale pixels high, and
// 16 x scale more for a second line.
Image8 colour_bar(int width, const std::string& caption, const BarRange& range = {},
                  const ColourTable& colours = error_colours(), double scale = 1);

// `picture` (RGB) with that bar below it, at least 360 pixels wide. A picture that is narrower than its bar is centred
// on white. Larger pictures get a larger bar.
Image8 with_colour_bar(const Image8& picture, const std::string& caption, const BarRange& range = {},
                       const ColourTable& colours = error_colours());

}  // namespace crowdbench::metrics
