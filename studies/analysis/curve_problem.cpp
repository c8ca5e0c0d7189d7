// Based on: Wichmann and Hill, "The psychometric function: I. Fitting, sampling, and goodness of fit" (2001); the
// penalty on the rates is psignifit's default prior (Schuett, Harmeling, Macke and Wichmann 2016).
#include "studies/analysis/curve_problem.h"

#include <algorithm>
#include <limits>

namespace crowdbench::studies::curve {
namespace {

constexpr double kPenaltyB = 10;  // of Beta(1, b)

double penalty_of(Rate rate, double value) {
  return rate == Rate::penalised ? -(kPenaltyB - 1) * std::log1p(-value) : 0;
}

double xlogy(uint64_t n, double p) { return n == 0 ? 0 : static_cast<double>(n) * std::log(p); }

// The best of several local minima: the likelihood has more than one where lapses are fitted, and steps between levels
// are narrow ones.
Minimum best_fit(const Problem& problem, const std::optional<CurveParameters>& hint) {
  const Objective objective = [&](std::span<const double> v) { return problem.penalised(problem.parameters(v)); };
  const Bounds bounds = problem.bounds();
  std::vector<std::vector<double>> starts;
  for (const double steepness : {0.003, 0.03, 0.1, 0.3}) {
    std::vector<std::vector<double>> of_one = problem.starts(steepness);
    const auto best = std::min_element(of_one.begin(), of_one.end(),
                                       [&](const auto& a, const auto& b) { return objective(a) < objective(b); });
    starts.push_back(*best);
  }
  if (hint) {
    std::sort(starts.begin(), starts.end(), [&](const auto& a, const auto& b) { return objective(a) < objective(b); });
    starts.resize(1);
    starts.push_back(problem.vector_of(*hint));
  }
  Minimum best{{}, std::numeric_limits<double>::infinity()};
  for (std::vector<double>& start : starts) {
    for (size_t i = 0; i < start.size(); ++i) start[i] = std::clamp(start[i], bounds.low[i], bounds.high[i]);
    Minimum found = minimise_by_simplex(objective, start, bounds, problem.steps());
    if (!hint) found = minimise(objective, found.x, bounds, problem.steps(), 1e-11);
    if (found.value < best.value) best = found;
  }
  return best;
}

// Minus the log-likelihood of a level line.
double flat_likelihood(const Problem& problem) {
  uint64_t yes = 0;
  uint64_t of = 0;
  for (const Level& level : problem.levels()) {
    yes += level.yes;
    of += level.of;
  }
  const double p = static_cast<double>(yes) / static_cast<double>(of);
  return -xlogy(yes, p) - xlogy(of - yes, 1 - p);
}

// Of a fit: whether it is one. A curve must do better than a level line; where at most one level
// lies on its slope, place and steepness are not told apart: any steeper curve does as well.
CurveState state_of_fit(const Problem& problem, const CurveFit& fit) {
  const CurveSettings& s = problem.settings();
  if (problem.likelihood(fit.at) > flat_likelihood(problem) - 1e-3) return CurveState::no_slope;
  const auto between = std::count_if(problem.levels().begin(), problem.levels().end(), [&](const Level& level) {
    const double f = base(s.curve, fit.at, level.x);
    return f > 1e-4 && f < 1 - 1e-4;
  });
  if (between < 2) return CurveState::step;
  const std::optional<double> x = x_at(s.curve, s.falling, fit.at, s.level);
  const double reach = 10 * std::max(problem.spread(), std::fabs(problem.levels().back().x));
  return x && std::fabs(*x) <= reach ? CurveState::fitted : CurveState::not_reached;
}

}  // namespace

double base(Curve curve, const CurveParameters& p, double x) {
  switch (curve) {
    case Curve::logistic: return logistic_cdf((x - p.location) / p.scale);
    case Curve::cumulative_gaussian: return normal_cdf((x - p.location) / p.scale);
    case Curve::weibull: break;
  }
  return x <= 0 ? 0 : -std::expm1(-std::pow(x / p.location, p.scale));
}

double base_level(bool falling, const CurveParameters& p, double level) {
  const double f = (level - p.guess) / (1 - p.guess - p.lapse);
  return falling ? 1 - f : f;
}

double location_for(Curve curve, double scale, double x, double f) {
  if (curve == Curve::logistic) return x - scale * std::log(f / (1 - f));
  if (curve == Curve::cumulative_gaussian) return x - scale * normal_quantile(f);
  return x / std::pow(-std::log1p(-f), 1 / scale);
}

Problem::Problem(std::vector<Level> levels, const CurveSettings& settings)
    : levels_(std::move(levels)), settings_(settings) {
  for (const Level& level : levels_) {
    const double p = static_cast<double>(level.yes) / static_cast<double>(level.of);
    constant_ -= log_choose(level.of, level.yes);
    saturated_ -= xlogy(level.yes, p) + xlogy(level.of - level.yes, 1 - p);
  }
}

size_t Problem::unknowns() const {
  return 2 + (settings_.guess_rate != Rate::fixed ? 1 : 0) + (settings_.lapse_rate != Rate::fixed ? 1 : 0);
}

CurveParameters Problem::parameters(std::span<const double> v) const {
  CurveParameters out;
  out.location = is_weibull() ? std::exp(v[0]) : v[0];
  out.scale = std::exp(v[1]);
  size_t at = 2;
  out.guess = settings_.guess_rate == Rate::fixed ? settings_.guess : v[at++];
  out.lapse = settings_.lapse_rate == Rate::fixed ? settings_.lapse : v[at];
  return out;
}

std::vector<double> Problem::vector_of(const CurveParameters& p) const {
  std::vector<double> out = {is_weibull() ? std::log(p.location) : p.location, std::log(p.scale)};
  if (settings_.guess_rate != Rate::fixed) out.push_back(p.guess);
  if (settings_.lapse_rate != Rate::fixed) out.push_back(p.lapse);
  return out;
}

double Problem::likelihood(const CurveParameters& p) const {
  double sum = 0;
  for (const Level& level : levels_) {
    const double y = std::clamp(psi(settings_.curve, settings_.falling, p, level.x), 0.0, 1.0);
    sum -= xlogy(level.yes, y) + xlogy(level.of - level.yes, 1 - y);
  }
  return sum;
}

double Problem::penalised(const CurveParameters& p) const {
  return likelihood(p) + penalty_of(settings_.guess_rate, p.guess) + penalty_of(settings_.lapse_rate, p.lapse);
}

Bounds Problem::bounds() const {
  Bounds out;
  const double low = levels_.front().x;
  const double high = levels_.back().x;
  if (is_weibull())
    out = {{std::log(smallest_positive() / 1000), std::log(0.05)}, {std::log(high * 1000), std::log(2e4)}};
  else
    out = {{low - 20 * spread(), std::log(spread() * 1e-6)}, {high + 20 * spread(), std::log(spread() * 20)}};
  if (settings_.guess_rate != Rate::fixed) {
    out.low.push_back(0);
    out.high.push_back(settings_.most_guess);
  }
  if (settings_.lapse_rate != Rate::fixed) {
    out.low.push_back(0);
    out.high.push_back(settings_.most_lapse);
  }
  return out;
}

std::vector<double> Problem::steps() const {
  std::vector<double> out = {is_weibull() ? 0.1 : spread() / 10, 0.3};
  out.resize(unknowns(), 0.01);
  return out;
}

double Problem::smallest_positive() const {
  const auto found = std::find_if(levels_.begin(), levels_.end(), [](const Level& level) { return level.x > 0; });
  return found == levels_.end() ? 1 : found->x;
}

std::vector<std::vector<double>> Problem::starts(double steepness) const {
  std::vector<double> places;
  for (size_t i = 0; i < levels_.size(); ++i) {
    places.push_back(levels_[i].x);
    if (i > 0) places.push_back((levels_[i - 1].x + levels_[i].x) / 2);
  }
  std::vector<std::vector<double>> out;
  CurveParameters p;
  for (const double place : places)
    for (const double rate : {0.1, 0.5, 0.95}) {
      p.location = is_weibull() ? std::max(place, smallest_positive()) : place;
      p.scale = is_weibull() ? 0.4 / steepness : steepness * spread();
      p.guess = rate * settings_.most_guess;
      p.lapse = rate * settings_.most_lapse;
      out.push_back(vector_of(p));
    }
  return out;
}

CurveState state_of_data(std::span<const Level> levels) {
  uint64_t yes = 0;
  uint64_t of = 0;
  for (const Level& level : levels) {
    yes += level.yes;
    of += level.of;
  }
  if (of == 0) return CurveState::no_data;
  if (yes == 0 || yes == of) return CurveState::all_alike;
  return levels.size() == 1 ? CurveState::one_level : CurveState::fitted;
}

CurveFit fit_point(const Problem& problem, const std::optional<CurveParameters>& hint) {
  CurveFit fit;
  fit.levels = problem.levels().size();
  for (const Level& level : problem.levels()) fit.answers += level.of;
  fit.at = problem.parameters(best_fit(problem, hint).x);
  fit.negative_log_likelihood = problem.likelihood(fit.at) + problem.constant();
  fit.deviance = 2 * (problem.likelihood(fit.at) - problem.saturated());
  fit.state = state_of_fit(problem, fit);
  if (fit.state == CurveState::fitted || fit.state == CurveState::step)
    fit.threshold = x_at(problem.settings().curve, problem.settings().falling, fit.at, problem.settings().level);
  return fit;
}

}  // namespace crowdbench::studies::curve
