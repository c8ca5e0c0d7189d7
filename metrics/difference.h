// Pixel by pixel: mean absolute error, mean squared error, PSNR, the picture of absolute differences, and what must
// happen to a picture before it can be scored.
//
// Code values: scores work on sRGB-encoded values of 0..255 as they lie in the file, not on linear light. Grey counts
// as R = G = B; alpha is ignored (composite with over() first). 16-bit values count as v / 257, unrounded. Every
// function that takes two pictures throws Error when their sizes differ.
//
// Viewing conditions: none. Source: the formulas at the functions are the whole definition; 255 is the peak of PSNR at
// 16 bits too. Limits: no neighbour counts and no eye does. A shift by a pixel costs as much as noise; a step of a code
// value costs as much in black, where it is seen, as in white, where it is not.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "core/image.h"

namespace crowdbench::metrics {

// One double a pixel.
using Plane = Image<double>;
// 1 channel; a pixel belongs when it is not 0.
using Mask = Image8;

// Y = 0.299 R + 0.587 G + 0.114 B (BT.601) of the code values: 0..255, not rounded.
Plane luma601(const Image8& image);
Plane luma601(const Image16& image);

// Exact: v * 257, so that pictures of 8 and of 16 bits can be compared.
Image16 widen(const Image8& image);

// What becomes of a composited value between two code values. down: floor, which ImageMagick's flatten does in every
// pixel; nearest: halves up. One from the other moves MAE by up to 0.002 and ColorVideoVDP by up to 9.1e-4 JOD.
enum class OverRounding : uint8_t { down, nearest };

// Source-over onto one colour, on the encoded values (not linear light), rounded to 8 bits: c a + b (1 - a), a the
// straight alpha. 3 channels come back. Pictures without alpha keep their values (16 bits are rounded alike).
Image8 over(const Image8& image, const std::array<uint8_t, 3>& colour, OverRounding rounding = OverRounding::down);
Image8 over(const Image16& image, const std::array<uint8_t, 3>& colour, OverRounding rounding = OverRounding::down);

struct Difference {
  uint64_t pixels = 0;  // that were counted
  double mae = 0;       // mean of |a - b| over pixels and R, G, B; 0 = equal, 255 = the most
  double mse = 0;       // mean of (a - b)^2 over the same; 0 .. 65025
  double psnr = 0;      // 10 log10(255^2 / mse) in dB; +infinity when equal, 0 the least
  double worst = 0;     // the largest |a - b| of any channel, and its pixel (the first in reading order)
  int worst_x = 0;
  int worst_y = 0;
};
// Sums are exact integers. `mask`: only its pixels count (same size); none = all. Nothing when no pixel counts.
std::optional<Difference> difference(const Image8& a, const Image8& b, const Mask* mask = nullptr);
std::optional<Difference> difference(const Image16& a, const Image16& b, const Mask* mask = nullptr);

// |a - b| of R, G, B: 3 channels. 16-bit differences are rounded to 8 bits.
Image8 absolute_difference(const Image8& a, const Image8& b);
Image8 absolute_difference(const Image16& a, const Image16& b);

// Float pictures have no code values: mean absolute error and root mean square over pixels and colour channels, in the
// pictures' own unit (linear light, metres). Finite values alone: scores are not available where a picture has others
// (metrics/not_finite.h).
struct LinearDifference {
  double mae = 0;
  double rms = 0;
};
// Range 0 (equal) to infinity; lower is better.
LinearDifference linear_difference(const ImageF& a, const ImageF& b);

}  // namespace crowdbench::metrics
