// Based on: D. N. Politis and J. P. Romano, "A circular block-resampling procedure for stationary data" (1992);
// E. Carlstein, "The use of subseries values for estimating the variance of a general statistic from a stationary
// sequence", Annals of Statistics 14 (1986): the block length for a first-order autoregression,
// (2 r / (1 - r^2))^(2/3) n^(1/3).
// Blocks are twice that long: it is the length of the least mean square error of a variance, and shorter blocks make
// intervals that are too narrow sooner than longer ones make them too wide.
// Differs from the sources: r is of ranks, which hitches do not move, and the interval is widened as the header says.
#include "core/block_bootstrap.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "core/probability.h"
#include "core/random.h"
#include "core/rank_correlation.h"

namespace crowdbench {
namespace {

constexpr uint64_t kBlockPurpose = 0x626c6f63;  // "bloc"
constexpr double kMostCorrelation = 0.95;
constexpr double kNoticed = 0.8416;         // the normal quantile of 0.8
constexpr double kNoticedByTests = 1.6449;  // of 0.95

}  // namespace

double serial_correlation(std::span<const double> values) {
  if (values.size() < 4) return 0;
  const std::vector<double> ranks = ranks_of(values);
  const auto n = static_cast<double>(ranks.size());
  const double mean = (n + 1) / 2;
  double products = 0;
  double squares = 0;
  for (size_t i = 0; i < ranks.size(); ++i) {
    squares += (ranks[i] - mean) * (ranks[i] - mean);
    if (i > 0) products += (ranks[i] - mean) * (ranks[i - 1] - mean);
  }
  if (squares == 0) return 0;
  const double raw = products / squares;
  return std::clamp(raw + (1 + 4 * raw) / n, -1.0, 1.0);  // its expectation is lower by (1 + 4 r) / n
}

size_t block_length(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  const double r = std::min(serial_correlation(values), kMostCorrelation);
  if (r * std::sqrt(n) < kNoticed) return 1;
  const double length = std::ceil(2 * std::pow(2 * r / (1 - r * r), 2.0 / 3) * std::cbrt(n));
  return std::clamp<size_t>(static_cast<size_t>(length), 1, std::max<size_t>(1, values.size() / 3));
}

Interval block_bootstrap_median(std::span<const double> values, uint64_t seed, double confidence, size_t resamples) {
  assert(!values.empty() && confidence > 0 && confidence < 1 && resamples > 0);
  const size_t n = values.size();
  const size_t block = block_length(values);
  if (block == 1) return bootstrap_median(values, seed, confidence, resamples);
  const size_t blocks = (n + block - 1) / block;
  std::vector<double> medians(resamples);
  std::vector<double> drawn(n);
  for (size_t r = 0; r < resamples; ++r) {
    for (size_t b = 0; b < blocks; ++b) {
      const size_t start = random_below(seed, r * blocks + b, kBlockPurpose, n);
      for (size_t i = b * block; i < std::min(n, (b + 1) * block); ++i) drawn[i] = values[(start + i - b * block) % n];
    }
    medians[r] = median_in_place(drawn);
  }
  const double tail = 0.5 * (1 - confidence);
  const double centre = median(values);
  const double independent = static_cast<double>(n) / static_cast<double>(block);
  const double wider = std::sqrt(static_cast<double>(n) / static_cast<double>(n - block)) *
                       student_t_quantile(1 - tail, std::max(1.0, independent - 1)) / normal_quantile(1 - tail);
  const double least = *std::min_element(values.begin(), values.end());
  const double greatest = *std::max_element(values.begin(), values.end());
  const auto widened = [&](double end) { return std::clamp(centre + (end - centre) * wider, least, greatest); };
  return {widened(quantile(medians, tail)), widened(quantile(medians, 1 - tail))};
}

double serial_inflation(std::span<const double> values) {
  const double r = std::min(serial_correlation(values), kMostCorrelation);
  const bool noticed = r * std::sqrt(static_cast<double>(values.size())) >= kNoticedByTests;
  return noticed ? (1 + r) / (1 - r) : 1;
}

double inflated_p(double p, double inflation) {
  assert(p >= 0 && p <= 1 && inflation >= 1);
  if (inflation == 1 || p == 0 || p == 1) return p;
  return normal_cdf(normal_quantile(p) / std::sqrt(inflation));
}

}  // namespace crowdbench
