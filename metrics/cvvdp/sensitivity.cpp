// Based on: M. Ashraf, R. K. Mantiuk, A. Chapiro, S. Wuerger, "castleCSF - A contrast sensitivity function of color,
// area, spatiotemporal frequency, luminance and eccentricity", Journal of Vision 24(4), 2024, doi 10.1167/jov.24.4.5.
// Differs from the source: ColorVideoVDP keeps the function as a table of 32 luminances and 32 frequencies. The
// formulas here give that table back (log10 S within 4e-4 above 0.05 cd/m2, mostly within 1e-6), which moves scores by
// less than 1e-5 JOD and needs no table of 4096 numbers. Interpolation is the table's.
#include "metrics/cvvdp/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crowdbench::metrics::vdp {
namespace {

constexpr double kArea = 2.25 * std::numbers::pi;  // square degrees: a disc of 1.5 degrees

double squared(double x) { return x * x; }

// The share of the stimulus' area that is summed up, as an amplitude.
double summation(double k, double frequency) { return std::sqrt(k / (1 + k / (kArea * squared(frequency)))); }

double achromatic(double frequency, double luminance) {
  const double l = std::log10(frequency);
  const double peak = std::log10(1.621429813 * std::pow(1 + 36.65742078 / luminance, -0.2558208759));
  double shape = -squared(l - peak) / 1.000156791;
  if (l < peak) shape = std::max(shape, std::log10(1 - 0.1036851554));
  return 68.06692168 * std::pow(1 + 59.50104343 / luminance, -0.1642757192) * (1 - std::exp(-5867.413549 / luminance)) *
         std::pow(10, shape) * summation(117.060156, frequency);
}

double red_green(double frequency, double luminance) {
  const double l = std::log10(frequency);
  const double summed = 49829.40877 / (1 + squared(frequency / 0.01877340505));
  const double s = 3842.639389 * std::pow(1 + 36.787 / luminance, -0.486759) *
                   std::pow(10, -squared(l + 3.435204968) / 8.917627884) * frequency *
                   std::sqrt(summed / (1 + summed / kArea));
  return s < 1 ? 0.2 : s;
}

double violet_yellow(double frequency, double luminance) {
  const double l = std::log10(frequency);
  return 437.4536931 * std::pow(1 + 70.9537 / luminance, -0.38997) *
         std::pow(10, -squared(l + 2.71017702) / 7.581797897) * summation(11.19391974, frequency);
}

double transient(double frequency, double luminance) {
  const double l = std::log10(frequency);
  return 0.2296447370 * achromatic(frequency, luminance) + 56.61231565 * std::pow(luminance, 0.5008460361) *
                                                               std::pow(10, -squared(l + 1.572695723) / 3.367015115) *
                                                               summation(117.0621792, frequency);
}

// The table's value on its way from `low` to `high`.
double at_step(size_t i, double low, double high) {
  return low * std::pow(high / low, static_cast<double>(i) / (kTableSize - 1));
}

}  // namespace

double log10_sensitivity(size_t channel, double frequency, double luminance) {
  constexpr std::array kFunctions = {&achromatic, &red_green, &violet_yellow, &transient};
  return std::log10(kFunctions.at(channel)(frequency, luminance));
}

SensitivityLines sensitivity_lines(size_t channel, double frequency, double factor) {
  constexpr double kNothing = -30;  // log10; where extrapolation leads below any number
  const double place =
      std::log10(frequency / kLeastFrequency) / std::log10(kMostFrequency / kLeastFrequency) * (kTableSize - 1);
  const auto column = static_cast<size_t>(std::clamp(std::floor(place), 0.0, static_cast<double>(kTableSize - 2)));
  const double low = at_step(column, kLeastFrequency, kMostFrequency);
  const double high = at_step(column + 1, kLeastFrequency, kMostFrequency);
  const double share = place - static_cast<double>(column);
  std::array<double, kTableSize> log2_s{};
  std::array<double, kTableSize> log2_l{};
  for (size_t i = 0; i < kTableSize; ++i) {
    const double luminance = at_step(i, kLeastLuminance, kMostLuminance);
    const double log10_s =
        std::lerp(log10_sensitivity(channel, low, luminance), log10_sensitivity(channel, high, luminance), share);
    const double corrected = std::max(log10_s + kSensitivityCorrection / 20 + std::log10(factor), kNothing);
    log2_s[i] = corrected * std::numbers::ln10 / std::numbers::ln2;
    log2_l[i] = std::log2(luminance);
  }
  SensitivityLines lines;
  for (size_t i = 0; i + 1 < kTableSize; ++i) {
    const double slope = (log2_s[i + 1] - log2_s[i]) / (log2_l[i + 1] - log2_l[i]);
    lines.slope[i] = static_cast<float>(slope);
    lines.at[i] = static_cast<float>(log2_s[i] - slope * log2_l[i]);
  }
  return lines;
}

double sensitivity(const SensitivityLines& lines, double luminance) {
  const double l = std::clamp(std::log2(luminance), double{Segments::kLow}, double{Segments::kHigh});
  const auto i = std::min(static_cast<size_t>((l - Segments::kLow) * Segments::kPerUnit), kTableSize - 2);
  return std::exp2(lines.at[i] + lines.slope[i] * l);
}

}  // namespace crowdbench::metrics::vdp
