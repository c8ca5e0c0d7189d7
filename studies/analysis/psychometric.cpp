// Based on: Wichmann and Hill, "The psychometric function" I and II (2001); intervals by the likelihood ratio.
#include "studies/analysis/psychometric.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/probability.h"
#include "studies/analysis/curve_problem.h"
#include "studies/analysis/optimise.h"

namespace crowdbench::studies {
namespace {

using curve::Problem;

// The least of the penalised likelihood with the location (f: nothing) or the place where F is f held at x.
class Profile {
 public:
  // level: of psi; nothing: of the location.
  Profile(const Problem& problem, const CurveParameters& best, std::optional<double> level)
      : problem_(problem), level_(level), from_(problem.vector_of(best)) {
    from_.erase(from_.begin());
  }
  double at(double x) {
    Bounds bounds = problem_.bounds();
    // A threshold far beyond the data is one of a curve that is all but flat over them: no bound may make it unlikely.
    (problem_.is_weibull() ? bounds.low : bounds.high)[1] =
        std::log(problem_.is_weibull() ? 2e-3 : problem_.spread() * 1e4);
    std::vector<double> steps = problem_.steps();
    bounds.low.erase(bounds.low.begin());
    bounds.high.erase(bounds.high.begin());
    steps.erase(steps.begin());
    const Objective objective = [&](std::span<const double> rest) {
      std::vector<double> v = {0};
      v.insert(v.end(), rest.begin(), rest.end());
      CurveParameters p = problem_.parameters(v);
      p.location = x;
      if (level_) {
        const double f = curve::base_level(problem_.settings().falling, p, *level_);
        if (!(f > 0 && f < 1)) return std::numeric_limits<double>::infinity();
        p.location = curve::location_for(problem_.settings().curve, p.scale, x, f);
      }
      return problem_.penalised(p);
    };
    // From where the last one ended, from a shallower curve and from one of middling slope: beyond the data the best is
    // often flat, and an estimate that is a step is left by none of its neighbours.
    Minimum best = minimise_by_simplex(objective, from_, bounds, steps);
    for (const double log_scale : {from_[0] + (problem_.is_weibull() ? -1 : 1),
                                   problem_.is_weibull() ? std::log(4) : std::log(problem_.spread() / 10)}) {
      std::vector<double> start = from_;
      start[0] = std::clamp(log_scale, bounds.low[0], bounds.high[0]);
      if (Minimum other = minimise_by_simplex(objective, start, bounds, steps); other.value < best.value) best = other;
    }
    from_ = best.x;
    return best.value;
  }

 private:
  const Problem& problem_;
  std::optional<double> level_;
  std::vector<double> from_;
};

// Where the profile has risen by `rise`, going from x outwards by steps that grow; nothing where it never does.
std::optional<double> profile_end(const Problem& problem, const CurveFit& fit, std::optional<double> level, double x,
                                  double rise, int side) {
  Profile profile(problem, fit.at, level);
  const double limit = problem.penalised(fit.at) + rise;
  double near = x;
  double step = problem.is_weibull() ? 0.02 * x : problem.spread() / 50;
  for (int i = 0; i < 40; ++i, step *= 1.5) {
    double far = near + side * step;
    if (problem.is_weibull() && far <= 0) far = near / 2;
    if (std::fabs(far - x) > 20 * problem.spread()) return std::nullopt;
    if (profile.at(far) < limit) {
      near = far;
      continue;
    }
    for (int halving = 0; halving < 60 && std::fabs(far - near) > 1e-7 * problem.spread(); ++halving) {
      const double middle = (near + far) / 2;
      (profile.at(middle) < limit ? near : far) = middle;
    }
    return (near + far) / 2;
  }
  return std::nullopt;
}

CurveFit::Ends profile_ends(const Problem& problem, const CurveFit& fit, std::optional<double> level, double x) {
  const double rise = chi_squared_quantile_1(problem.settings().confidence) / 2;
  return {profile_end(problem, fit, level, x, rise, -1), profile_end(problem, fit, level, x, rise, 1)};
}

void standard_errors(const Problem& problem, CurveFit& fit) {
  // In location and scale themselves; rates at a bound are held there.
  std::vector<double> x = {fit.at.location, fit.at.scale};
  const CurveSettings& s = problem.settings();
  const bool guess_moves = s.guess_rate != Rate::fixed && fit.at.guess > 1e-6 && fit.at.guess < s.most_guess - 1e-6;
  const bool lapse_moves = s.lapse_rate != Rate::fixed && fit.at.lapse > 1e-6 && fit.at.lapse < s.most_lapse - 1e-6;
  if (guess_moves) x.push_back(fit.at.guess);
  if (lapse_moves) x.push_back(fit.at.lapse);
  const Objective objective = [&](std::span<const double> v) {
    CurveParameters p = fit.at;
    p.location = v[0];
    p.scale = v[1];
    size_t at = 2;
    if (guess_moves) p.guess = v[at++];
    if (lapse_moves) p.lapse = v[at];
    return problem.penalised(p);
  };
  std::vector<double> step = {1e-3 * fit.at.scale, 1e-3 * fit.at.scale};
  if (problem.is_weibull()) step[0] = 1e-3 * fit.at.location / std::max(1.0, fit.at.scale);
  for (size_t i = 2; i < x.size(); ++i) step.push_back(std::min(1e-4, x[i] / 2));
  const std::vector<std::vector<double>> h = hessian(objective, x, step);
  if (const auto inverse = inverse_of_positive(h)) {
    fit.location_se = std::sqrt((*inverse)[0][0]);
    fit.scale_se = std::sqrt((*inverse)[1][1]);
  }
}

}  // namespace

std::string_view curve_name(Curve kind) {
  return kind == Curve::logistic ? "logistic" : kind == Curve::weibull ? "weibull" : "cumgauss";
}

std::optional<Curve> curve_named(std::string_view name) {
  for (const Curve kind : {Curve::logistic, Curve::cumulative_gaussian, Curve::weibull})
    if (name == curve_name(kind)) return kind;
  return std::nullopt;
}

double psi(Curve kind, bool falling, const CurveParameters& p, double x) {
  const double f = curve::base(kind, p, x);
  return p.guess + (1 - p.guess - p.lapse) * (falling ? 1 - f : f);
}

std::optional<double> x_at(Curve kind, bool falling, const CurveParameters& p, double level) {
  const double f = curve::base_level(falling, p, level);
  if (!(f > 0 && f < 1)) return std::nullopt;
  if (kind == Curve::logistic) return p.location + p.scale * std::log(f / (1 - f));
  if (kind == Curve::cumulative_gaussian) return p.location + p.scale * normal_quantile(f);
  return p.location * std::pow(-std::log1p(-f), 1 / p.scale);
}

std::vector<Level> merged_levels(std::span<const Level> levels) {
  std::vector<Level> sorted(levels.begin(), levels.end());
  std::sort(sorted.begin(), sorted.end(), [](const Level& a, const Level& b) { return a.x < b.x; });
  std::vector<Level> out;
  for (const Level& level : sorted) {
    if (level.of == 0) continue;
    if (out.empty() || out.back().x != level.x) out.push_back({level.x, 0, 0});
    out.back().yes += level.yes;
    out.back().of += level.of;
  }
  return out;
}

std::string_view state_text(CurveState state) {
  switch (state) {
    case CurveState::fitted: return "fitted";
    case CurveState::no_data: return "no data";
    case CurveState::one_level: return "one level";
    case CurveState::all_alike: return "all answers alike";
    case CurveState::no_slope: return "no slope";
    case CurveState::step: return "a step between two levels";
    case CurveState::not_reached: break;
  }
  return "level not reached";
}

CurveFit fit_curve(std::span<const Level> levels, const CurveSettings& settings) {
  const std::vector<Level> merged = merged_levels(levels);
  assert(settings.curve != Curve::weibull || merged.empty() || merged.front().x >= 0);
  CurveFit fit;
  fit.state = curve::state_of_data(merged);
  fit.levels = merged.size();
  for (const Level& level : merged) fit.answers += level.of;
  if (fit.state != CurveState::fitted) return fit;
  const Problem problem(merged, settings);
  fit = curve::fit_point(problem, std::nullopt);
  if (fit.state != CurveState::fitted && fit.state != CurveState::step) return fit;
  if (fit.state == CurveState::fitted) standard_errors(problem, fit);
  fit.location_profile = profile_ends(problem, fit, std::nullopt, fit.at.location);
  if (fit.threshold) fit.threshold_profile = profile_ends(problem, fit, settings.level, *fit.threshold);
  return fit;
}

}  // namespace crowdbench::studies
