// Based on: Tukey, "Bias and confidence in not-quite large samples" (1958); Efron and Tibshirani, "An Introduction to
// the Bootstrap" (1993), chapter 11. Differs: deviations are from the estimate of all, not from the mean of those
// without one, which is never the smaller.
#include <algorithm>
#include <cmath>

#include "studies/analysis/curve_problem.h"
#include "studies/analysis/psychometric.h"

namespace crowdbench::studies {
namespace {

// The fit to all groups but one.
CurveFit fit_without(std::span<const std::vector<Level>> groups, size_t left_out, const CurveSettings& settings,
                     const CurveParameters& hint) {
  std::vector<Level> levels;
  for (size_t i = 0; i < groups.size(); ++i)
    if (i != left_out) levels.insert(levels.end(), groups[i].begin(), groups[i].end());
  levels = merged_levels(levels);
  CurveFit out;
  out.state = curve::state_of_data(levels);
  return out.state == CurveState::fitted ? curve::fit_point(curve::Problem(levels, settings), hint) : out;
}

}  // namespace

std::optional<CurveJackknife> jackknife_threshold(const CurveFit& fit, std::span<const std::vector<Level>> groups,
                                                  const CurveSettings& settings) {
  if (!fit.threshold) return std::nullopt;
  CurveJackknife out;
  out.groups = groups.size();
  if (groups.size() < kLeastJackknifeGroups) {
    out.state = JackknifeState::too_few;
    return out;
  }
  const auto scale = [&](double x) { return settings.curve == Curve::weibull ? std::log(x) : x; };
  const auto back = [&](double x) { return settings.curve == Curve::weibull ? std::exp(x) : x; };
  const double at = scale(*fit.threshold);
  size_t steps = fit.state == CurveState::step ? groups.size() : 0;
  double squares = 0;
  double largest = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    const CurveFit rest = fit_without(groups, i, settings, fit.at);
    if (!rest.threshold) {
      out.state = JackknifeState::one_decides;
      return out;
    }
    steps += rest.state == CurveState::step ? 1 : 0;
    largest = std::max(largest, std::fabs(*rest.threshold - *fit.threshold));
    squares += (scale(*rest.threshold) - at) * (scale(*rest.threshold) - at);
  }
  std::vector<Level> all;
  for (const std::vector<Level>& group : groups) all.insert(all.end(), group.begin(), group.end());
  all = merged_levels(all);
  if (2 * steps > groups.size() || largest <= curve::kAlike * (all.back().x - all.front().x)) {
    out.state = JackknifeState::alike;
    return out;
  }
  const auto n = static_cast<double>(groups.size());
  const double half = student_t_quantile(1 - (1 - settings.confidence) / 2, n - 1) * std::sqrt((n - 1) / n * squares);
  out.threshold = {back(at - half), back(at + half)};
  return out;
}

}  // namespace crowdbench::studies
