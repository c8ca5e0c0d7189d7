// How little contrast people see: sensitivity against spatial frequency and the luminance around.
#pragma once
#include <array>
#include <cstdint>

#include "metrics/cvvdp/parameters.h"

namespace crowdbench::metrics::vdp {

// The sensitivity tables' axes: uniform in log10.
constexpr size_t kTableSize = 32;
constexpr double kLeastLuminance = 0.005, kMostLuminance = 10000;  // cd/m2
constexpr double kLeastFrequency = 0.1, kMostFrequency = 64;       // cycles per degree

// log10 of the sensitivity of a channel; frequency in cycles per degree, luminance in cd/m2. Without the correction.
double log10_sensitivity(size_t channel, double frequency, double luminance);

// One band's sensitivities: between two luminances of the table log2 S is a line in log2 of the luminance.
struct SensitivityLines {
  std::array<float, kTableSize> at{};  // log2 S = at[i] + slope[i] * log2(luminance) on segment i; the last is unused
  std::array<float, kTableSize> slope{};  //
};
// By linear interpolation of the table in log10 of the frequency (outside of it: its end segments, extended),
// correction included. factor: multiplies the sensitivities.
SensitivityLines sensitivity_lines(size_t channel, double frequency, double factor);

// log2 of a luminance, held within the table, and the segment that it lies on.
struct Segments {
  static constexpr float kLow = -7.6438562F;   // log2(0.005)
  static constexpr float kHigh = 13.2877124F;  // log2(10000)
  static constexpr float kPerUnit = (kTableSize - 1) / (kHigh - kLow);
};

// S of one luminance, as the lines have it.
double sensitivity(const SensitivityLines& lines, double luminance);

}  // namespace crowdbench::metrics::vdp
