#include "metrics/flip_filters.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace crowdbench::metrics {
namespace {

using std::numbers::pi;

std::vector<double> gaussian(int radius, double scale, double exponent) {
  std::vector<double> taps;
  for (int i = 0; i <= radius; ++i) taps.push_back(scale * std::exp(exponent * i * i));
  return taps;
}

double sum_of(const std::vector<double>& taps) {
  double sum = taps[0];
  for (size_t i = 1; i < taps.size(); ++i) sum += 2 * taps[i];
  return sum;
}

Taps scaled(const std::vector<double>& taps, double factor) {
  Taps out;
  for (const double tap : taps) out.push_back(static_cast<float>(tap * factor));
  return out;
}

}  // namespace

ContrastFilters contrast_filters(double pixels_per_degree) {
  assert(pixels_per_degree >= 1);
  // A Gaussian of scale b falls by pi^2 x^2 / b at x degrees. Achromatic, red-green, and blue-yellow with its weights.
  constexpr double kAchromatic = 0.0047;
  constexpr double kRedGreen = 0.0053;
  constexpr double kBlueYellow[2] = {0.04, 0.025};
  constexpr double kWeight[2] = {34.1, 13.5};
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(kBlueYellow[0] / (2 * pi * pi)) * pixels_per_degree));
  const auto exponent = [&](double b) { return -pi * pi / (b * pixels_per_degree * pixels_per_degree); };
  ContrastFilters out;
  const auto achromatic = gaussian(radius, 1, exponent(kAchromatic));
  const auto red_green = gaussian(radius, 1, exponent(kRedGreen));
  out.achromatic = scaled(achromatic, 1 / sum_of(achromatic));
  out.red_green = scaled(red_green, 1 / sum_of(red_green));
  std::vector<double> both[2];
  double squares = 0;
  for (int k = 0; k < 2; ++k) {
    const double scale = std::sqrt(kWeight[k] * std::sqrt(pi / kBlueYellow[k]));
    both[k] = gaussian(radius, scale, exponent(kBlueYellow[k]));
    squares += sum_of(both[k]) * sum_of(both[k]);
  }
  for (int k = 0; k < 2; ++k) out.blue_yellow[k] = scaled(both[k], 1 / std::sqrt(squares));
  return out;
}

FeatureFilters feature_filters(double pixels_per_degree) {
  assert(pixels_per_degree >= 1);
  constexpr double kEdgeDegrees = 0.082;
  const double sigma = 0.5 * kEdgeDegrees * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto g = gaussian(radius, 1, -1 / (2 * sigma * sigma));
  std::vector<double> first;
  std::vector<double> second;
  double one_side = 0;
  double positive = 0;
  double negative = 0;
  for (int i = 0; i <= radius; ++i) {
    const double tap = g[static_cast<size_t>(i)];
    first.push_back(-i * tap);
    one_side += i * tap;
    second.push_back((i * i / (sigma * sigma) - 1) * tap);
    (second.back() > 0 ? positive : negative) += (i == 0 ? 1 : 2) * std::abs(second.back());
  }
  for (double& tap : second) tap /= tap > 0 ? positive : negative;
  return {scaled(g, 1 / sum_of(g)), scaled(first, 1 / one_side), scaled(second, 1)};
}

Taps trimmed(const Taps& taps) {
  double all = 0;
  for (const float tap : taps) all += std::abs(tap);
  double left_out = 0;
  size_t kept = taps.size();
  while (kept > 1) {
    left_out += std::abs(taps[kept - 1]);
    if (left_out > std::ldexp(all, -26)) break;
    --kept;
  }
  return {taps.begin(), taps.begin() + static_cast<std::ptrdiff_t>(kept)};
}

}  // namespace crowdbench::metrics
