// Based on: Wichmann and Hill, "The psychometric function: II. Bootstrap-based confidence intervals and sampling"
// (2001). Differs: where participants are known, whole participants are drawn, and the interval is stretched by what
// makes that of a mean right (Hesterberg, "What teachers should know about the bootstrap", 2015, moves the
// percentiles instead, which few draws do not have).
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "studies/analysis/curve_problem.h"
#include "studies/analysis/psychometric.h"

namespace crowdbench::studies {
namespace {

constexpr uint64_t kCurveDraw = 0x70737963;
constexpr uint64_t kMostDrawn = 2000;  // answers that are drawn one by one
constexpr double kLargeVariance = 1e4;

double unit(uint64_t seed, size_t resample, size_t draw) {
  return random_unit(mix64(seed + kCurveDraw), resample, draw);
}

// The count of which the distribution function reaches u; where the variance is large, of the normal one, which is off
// by less than a hundredth of the standard deviation.
uint64_t binomial_quantile(uint64_t n, double p, double u) {
  const auto count = static_cast<double>(n);
  if (count * p * (1 - p) > kLargeVariance) {
    const double at = count * p + std::sqrt(count * p * (1 - p)) * normal_quantile(u);
    return static_cast<uint64_t>(std::clamp(std::round(at), 0.0, count));
  }
  uint64_t low = 0;
  uint64_t high = n;
  while (low < high) {
    const uint64_t middle = low + (high - low) / 2;
    if (binomial_at_most(middle, n, p) >= u)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

uint64_t binomial_draw(uint64_t n, double p, uint64_t seed, size_t resample, size_t& draw) {
  if (n > kMostDrawn) return binomial_quantile(n, p, unit(seed, resample, draw++));
  uint64_t out = 0;
  for (uint64_t i = 0; i < n; ++i) out += unit(seed, resample, draw++) < p ? 1 : 0;
  return out;
}

}  // namespace

std::optional<CurveBootstrap> bootstrap_threshold(const CurveFit& fit, std::span<const Level> levels,
                                                  std::span<const std::vector<Level>> groups,
                                                  const CurveSettings& settings, uint64_t seed, size_t resamples) {
  if (!fit.threshold || resamples == 0) return std::nullopt;
  const std::vector<Level> merged = merged_levels(levels);
  CurveBootstrap out;
  out.resamples = resamples;
  const double tail = (1 - settings.confidence) / 2;
  if (!groups.empty()) {
    const auto n = static_cast<double>(groups.size());
    out.few = groups.size() < kLeastBootstrapGroups;
    if (out.few) return out;
    out.stretch = student_t_quantile(1 - tail, n - 1) / normal_quantile(1 - tail) * std::sqrt(n / (n - 1));
  }
  std::vector<double> thresholds;
  size_t steps = 0;
  for (size_t r = 0; r < resamples; ++r) {
    std::vector<Level> drawn;
    size_t draw = 0;
    if (groups.empty()) {
      drawn = merged;
      for (Level& level : drawn)
        level.yes = binomial_draw(level.of, psi(settings.curve, settings.falling, fit.at, level.x), seed, r, draw);
    }
    for (size_t g = 0; g < groups.size(); ++g) {
      const auto& group = groups[static_cast<size_t>(unit(seed, r, draw++) * static_cast<double>(groups.size()))];
      drawn.insert(drawn.end(), group.begin(), group.end());
    }
    drawn = merged_levels(drawn);
    const CurveState state = curve::state_of_data(drawn);
    std::optional<double> threshold;
    if (state == CurveState::fitted) {
      const CurveFit refit = curve::fit_point(curve::Problem(drawn, settings), fit.at);
      threshold = refit.threshold;
      steps += refit.state == CurveState::step ? 1 : 0;
    }
    if (threshold)
      thresholds.push_back(*threshold);
    else
      ++out.failed;
  }
  out.open = thresholds.empty() || static_cast<double>(out.failed) > tail * static_cast<double>(resamples);
  if (thresholds.empty()) return out;
  out.threshold = {quantile(thresholds, tail), quantile(thresholds, 1 - tail)};
  const double span = merged.back().x - merged.front().x;
  out.alike = 2 * steps > resamples || out.threshold.high - out.threshold.low <= curve::kAlike * span;
  out.widened = out.threshold.low > *fit.threshold || out.threshold.high < *fit.threshold;
  out.threshold = {std::min(out.threshold.low, *fit.threshold), std::max(out.threshold.high, *fit.threshold)};
  out.threshold.low = *fit.threshold - out.stretch * (*fit.threshold - out.threshold.low);
  out.threshold.high = *fit.threshold + out.stretch * (out.threshold.high - *fit.threshold);
  return out;
}

}  // namespace crowdbench::studies
