// Based on: R. J. Hyndman and Y. Fan, "Sample quantiles in statistical packages", The American Statistician 50 (1996);
// B. Efron, "Bootstrap methods: another look at the jackknife", Annals of Statistics 7 (1979).
// Differs from the source: draws are counter-based, not from a stream.
#include "core/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/random.h"

namespace crowdbench {
namespace {

constexpr uint64_t kBootstrapPurpose = 0x626f6f74;

double quantile_of_sorted(std::span<const double> sorted, double q) {
  const double position = static_cast<double>(sorted.size() - 1) * q;
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

std::vector<double> sorted_copy(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

// log y of a curve at log x, which lies within its range.
double log_y_at(const Curve& curve, double log_x) {
  size_t i = 0;
  while (i + 2 < curve.x.size() && std::log(curve.x[i + 1]) < log_x) ++i;
  if (curve.x.size() == 1) return std::log(curve.y[0]);
  const double x0 = std::log(curve.x[i]);
  const double x1 = std::log(curve.x[i + 1]);
  const double y0 = std::log(curve.y[i]);
  const double y1 = std::log(curve.y[i + 1]);
  if (log_x == x0) return y0;
  if (log_x == x1) return y1;
  return y0 + (log_x - x0) / (x1 - x0) * (y1 - y0);
}

[[maybe_unused]] bool valid(const Curve& curve) {
  if (curve.x.size() != curve.y.size()) return false;
  for (size_t i = 0; i < curve.x.size(); ++i) {
    if (!(curve.x[i] > 0) || !(curve.y[i] > 0)) return false;
    if (i > 0 && !(curve.x[i] > curve.x[i - 1])) return false;
  }
  return true;
}

}  // namespace

double quantile(std::span<const double> values, double q) {
  assert(!values.empty() && q >= 0 && q <= 1);
  return quantile_of_sorted(sorted_copy(values), q);
}

double median_in_place(std::span<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*std::max_element(values.begin(), middle) + *middle);
}

double median(std::span<const double> values) {
  assert(!values.empty());
  std::vector<double> copy(values.begin(), values.end());
  return median_in_place(copy);
}

Summary summarise(std::span<const double> times_ns) {
  assert(!times_ns.empty());
  const std::vector<double> sorted = sorted_copy(times_ns);
  assert(sorted.front() > 0);
  const size_t slowest = (sorted.size() + 99) / 100;
  const double slow_sum = std::accumulate(sorted.end() - static_cast<ptrdiff_t>(slowest), sorted.end(), 0.0);
  return {.count = sorted.size(),
          .median = quantile_of_sorted(sorted, 0.5),
          .p05 = quantile_of_sorted(sorted, 0.05),
          .p95 = quantile_of_sorted(sorted, 0.95),
          .p99 = quantile_of_sorted(sorted, 0.99),
          .low_1_percent_fps = 1e9 * static_cast<double>(slowest) / slow_sum};
}

Interval bootstrap_median(std::span<const double> values, uint64_t seed, double confidence, size_t resamples) {
  assert(!values.empty() && confidence > 0 && confidence < 1 && resamples > 0);
  std::vector<double> medians(resamples);
  std::vector<double> drawn(values.size());
  for (size_t r = 0; r < resamples; ++r) {
    for (size_t i = 0; i < drawn.size(); ++i)
      drawn[i] = values[random_below(seed, r * drawn.size() + i, kBootstrapPurpose, drawn.size())];
    medians[r] = median_in_place(drawn);
  }
  std::sort(medians.begin(), medians.end());
  return {quantile_of_sorted(medians, 0.5 * (1 - confidence)), quantile_of_sorted(medians, 0.5 * (1 + confidence))};
}

MedianRatio median_of_ratios(std::span<const double> numerator, std::span<const double> denominator, uint64_t seed,
                             size_t resamples) {
  assert(!numerator.empty() && numerator.size() == denominator.size());
  std::vector<double> ratios(numerator.size());
  for (size_t i = 0; i < ratios.size(); ++i) {
    assert(numerator[i] > 0 && denominator[i] > 0);
    ratios[i] = numerator[i] / denominator[i];
  }
  return {median(ratios), bootstrap_median(ratios, seed, 0.95, resamples), ratios.size()};
}

std::vector<Crossover> crossovers(const Curve& first, const Curve& second) {
  assert(valid(first) && valid(second));
  std::vector<Crossover> found;
  if (first.x.empty() || second.x.empty()) return found;
  const double from = std::max(first.x.front(), second.x.front());
  const double to = std::min(first.x.back(), second.x.back());
  std::vector<double> knots;
  for (const Curve* curve : {&first, &second})
    std::copy_if(curve->x.begin(), curve->x.end(), std::back_inserter(knots),
                 [&](double x) { return x >= from && x <= to; });
  std::sort(knots.begin(), knots.end());
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());

  // Between two neighbouring knots the difference of the logarithms is a straight line.
  double last_sign = 0;
  double previous_x = 0;
  double previous_difference = 0;
  for (const double knot : knots) {
    const double log_x = std::log(knot);
    const double difference = log_y_at(first, log_x) - log_y_at(second, log_x);
    if (difference != 0) {
      const double sign = difference > 0 ? 1 : -1;
      if (last_sign != 0 && sign != last_sign) {
        const double t = previous_difference / (previous_difference - difference);
        const double crossing = previous_x + t * (log_x - previous_x);
        found.push_back({std::exp(crossing), std::exp(log_y_at(first, crossing)), sign < 0});
      }
      last_sign = sign;
    }
    previous_x = log_x;
    previous_difference = difference;
  }
  return found;
}

}  // namespace crowdbench
