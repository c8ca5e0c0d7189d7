// When two drivers' pictures of one frame are the same.
//
// What may differ, and why: another driver rounds positions to its own grid of 1/256 pixel or finer and filters with
// weights of its own, so that a surface's edge, or a texel's, comes to lie up to 1/128 pixel elsewhere; a pixel whose
// centre is passed over by it changes altogether. And it rounds colours to the code beside. So of the pixels that show
// anybody a share of kEdges may differ by more than kCodes; on the mean over them no channel may differ by more than
// kBias codes: rounding has no preferred direction, light has.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "core/image.h"

namespace crowdbench::support {

constexpr int kCodes = 4;        // of 255
constexpr double kEdges = 0.03;  // of the pixels that show anybody
constexpr double kBias = 0.5;    // codes

struct PictureComparison {
  size_t shown = 0;              // pixels in which either picture shows anybody
  double differing = 0;          // of them: by more than kCodes in some channel
  std::array<double, 3> bias{};  // codes: mean difference of each channel over them
  bool same() const {
    return shown > 0 && differing <= kEdges &&
           std::all_of(bias.begin(), bias.end(), [](double b) { return std::abs(b) <= kBias; });
  }
};

// Both RGBA, of one size, on the background #808080.
inline PictureComparison compare(const Image8& test, const Image8& reference) {
  const auto background = [](const uint8_t* p) { return p[0] == 128 && p[1] == 128 && p[2] == 128; };
  PictureComparison out;
  for (size_t i = 0; i < 4 * reference.pixels(); i += 4) {
    const uint8_t* a = &test.data[i];
    const uint8_t* b = &reference.data[i];
    if (background(a) && background(b)) continue;
    ++out.shown;
    int most = 0;
    for (size_t c = 0; c < 3; ++c) {
      const int difference = int{a[c]} - int{b[c]};
      out.bias[c] += difference;
      most = std::max(most, std::abs(difference));
    }
    out.differing += most > kCodes ? 1 : 0;
  }
  if (out.shown == 0) return out;
  out.differing /= static_cast<double>(out.shown);
  for (double& b : out.bias) b /= static_cast<double>(out.shown);
  return out;
}

}  // namespace crowdbench::support
