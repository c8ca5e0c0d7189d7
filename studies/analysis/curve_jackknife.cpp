// Based on: Tukey, "Bias and confidence in not-quite large samples" (1958); Efron and Tibshirani, "An Introduction to
// the Bootstrap" (1993), chapter 11. Differs: deviations are from the estimate of all, not from the mean of those
// without one, which is never the smaller. Over participants and clips: Cameron, Gelbach and Miller, "Robust inference
// with multiway clustering" (2011); differs: what the two share is taken from the likelihood, which holds no more than
// the variance of the cells of both, and the degrees of freedom are Satterthwaite's.
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

// Lengths on the scale on which an interval is symmetrical.
class Scale {
 public:
  explicit Scale(const CurveSettings& settings) : log_(settings.curve == Curve::weibull) {}
  double of(double x) const { return log_ ? std::log(x) : x; }
  double back(double x) const { return log_ ? std::exp(x) : x; }

 private:
  bool log_;
};

// What the threshold is without each of some groups in turn.
struct Refits {
  bool all_have_one = true;
  size_t steps = 0;
  double largest = 0;   // of the ways from the estimate of all, in units of the level
  double variance = 0;  // of the estimate, on the scale
};
Refits leave_each_out(const CurveFit& fit, std::span<const std::vector<Level>> groups, const CurveSettings& settings) {
  Refits out;
  const Scale scale(settings);
  double squares = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    const CurveFit rest = fit_without(groups, i, settings, fit.at);
    if (!rest.threshold) {
      out.all_have_one = false;
      return out;
    }
    out.steps += rest.state == CurveState::step ? 1 : 0;
    out.largest = std::max(out.largest, std::fabs(*rest.threshold - *fit.threshold));
    const double way = scale.of(*rest.threshold) - scale.of(*fit.threshold);
    squares += way * way;
  }
  const auto n = static_cast<double>(groups.size());
  out.variance = (n - 1) / n * squares;
  return out;
}

// The variance that the answers' number alone gives the threshold; 0 where the likelihood leaves an end open.
double variance_of_trials(const CurveFit& fit, const CurveSettings& settings) {
  const CurveFit::Ends& ends = fit.threshold_profile;
  if (fit.state != CurveState::fitted || !ends.low || !ends.high) return 0;
  const Scale scale(settings);
  const double se =
      (scale.of(*ends.high) - scale.of(*ends.low)) / 2 / normal_quantile(1 - (1 - settings.confidence) / 2);
  return se * se;
}

double range_of(std::span<const std::vector<Level>> groups) {
  std::vector<Level> all;
  for (const std::vector<Level>& group : groups) all.insert(all.end(), group.begin(), group.end());
  all = merged_levels(all);
  return all.back().x - all.front().x;
}

}  // namespace

std::optional<CurveJackknife> jackknife_threshold(const CurveFit& fit, std::span<const std::vector<Level>> groups,
                                                  std::span<const std::vector<Level>> clips,
                                                  const CurveSettings& settings) {
  if (!fit.threshold) return std::nullopt;
  CurveJackknife out;
  out.groups = groups.size();
  if (groups.size() < kLeastJackknifeGroups) {
    out.state = JackknifeState::too_few;
    return out;
  }
  const Refits people = leave_each_out(fit, groups, settings);
  if (!people.all_have_one) {
    out.state = JackknifeState::one_decides;
    return out;
  }
  const size_t steps = people.steps + (fit.state == CurveState::step ? groups.size() : 0);
  if (2 * steps > groups.size() || people.largest <= curve::kAlike * range_of(groups)) {
    out.state = JackknifeState::alike;
    return out;
  }
  double variance = people.variance;
  out.degrees = static_cast<double>(groups.size()) - 1;
  if (clips.size() >= kLeastJackknifeGroups) {
    const Refits shown = leave_each_out(fit, clips, settings);
    if (!shown.all_have_one) {
      out.state = JackknifeState::one_clip_decides;
      return out;
    }
    out.clips = clips.size();
    const double sum = people.variance + shown.variance;
    variance = std::max({people.variance, shown.variance, sum - variance_of_trials(fit, settings)});
    out.degrees = variance * variance /
                  (people.variance * people.variance / out.degrees +
                   shown.variance * shown.variance / (static_cast<double>(clips.size()) - 1));
  }
  const double half = student_t_quantile(1 - (1 - settings.confidence) / 2, out.degrees) * std::sqrt(variance);
  const Scale scale(settings);
  const double at = scale.of(*fit.threshold);
  out.threshold = {scale.back(at - half), scale.back(at + half)};
  return out;
}

}  // namespace crowdbench::studies
