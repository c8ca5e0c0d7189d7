// Based on: Bates, Maechler, Bolker and Walker, "Fitting linear mixed-effects models using lme4" (2015).
// Differs from it: all parameters are optimised together from the start, and a variance that may as well be 0 is 0. A
// correlated slope is about its variable's mean while it is searched for: the model is the same, and the two are then
// nearly free of each other, whereas at a level 0 that lies far from the data they all but cancel.
#include "studies/analysis/mixed_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/probability.h"
#include "studies/analysis/dense.h"
#include "studies/analysis/mixed_likelihood.h"
#include "studies/analysis/optimise.h"

namespace crowdbench::studies {
namespace {

using mixed::Likelihood;
using mixed::Scales;

// |eta| beyond which chances are within 5e-5 of 0 or 1, where a search may stop that has no end.
constexpr double kInfinite = 10;

Eigen::VectorXd vector_of(std::span<const double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// The unknowns of the model as one vector: the scales that there are, then the fixed effects.
class Unknowns {
 public:
  Unknowns(const MixedSettings& settings, size_t effects) : effects_(effects) {
    add(&Scales::intercept, 0);
    if (settings.slopes && settings.correlated) add(&Scales::cross, -std::numeric_limits<double>::infinity());
    if (settings.slopes) add(&Scales::slope, 0);
    if (settings.clips) add(&Scales::clip, 0);
  }
  size_t scales() const { return members_.size(); }
  size_t count() const { return scales() + effects_; }
  // Whether it has a bound at 0.
  bool bounded(size_t i) const { return i < scales() && low_[i] == 0; }
  Scales scales_of(std::span<const double> x) const {
    Scales out;
    for (size_t i = 0; i < scales(); ++i) out.*members_[i] = x[i];
    return out;
  }
  Eigen::VectorXd effects_of(std::span<const double> x) const { return vector_of(x.subspan(scales())); }
  Bounds bounds() const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Bounds out{low_, std::vector<double>(scales(), kNone)};
    out.low.resize(count(), -kNone);
    out.high.resize(count(), kNone);
    return out;
  }
  std::vector<double> from(const Scales& scales) const {
    std::vector<double> out;
    for (double Scales::*const member : members_) out.push_back(scales.*member);
    return out;
  }

 private:
  void add(double Scales::*member, double low) {
    members_.push_back(member);
    low_.push_back(low);
  }
  size_t effects_;
  std::vector<double Scales::*> members_;
  std::vector<double> low_;
};

// ---- units

// Fixed effects in units of their own spread about their mean, and the slope's variable in units of its size or, where
// it may be correlated with the intercept, likewise: what is optimised is then of about one size, whether levels are
// metres or pixels.
class Units {
 public:
  Units(std::vector<MixedRow>& rows, bool correlated) {
    const auto n = static_cast<Eigen::Index>(rows.front().fixed.size());
    back_ = Eigen::MatrixXd::Identity(n, n);
    double count = 0;
    for (const MixedRow& row : rows) count += static_cast<double>(row.of);
    set_slope(rows, count, correlated);
    for (Eigen::Index j = 1; j < n; ++j) {
      const auto k = static_cast<size_t>(j);
      double mean = 0;
      double square = 0;
      for (const MixedRow& row : rows) mean += static_cast<double>(row.of) * row.fixed[k] / count;
      for (const MixedRow& row : rows)
        square += static_cast<double>(row.of) * (row.fixed[k] - mean) * (row.fixed[k] - mean) / count;
      // What is the same everywhere is nothing beside the intercept, whatever the mean's rounding leaves of it.
      const bool constant = !(square > 1e-24 * mean * mean);
      const double unit = constant ? 1 : std::sqrt(square);
      for (MixedRow& row : rows) row.fixed[k] = constant ? 0 : (row.fixed[k] - mean) / unit;
      back_(j, j) = 1 / unit;
      back_(0, j) = -mean / unit;
    }
  }
  // From effects in these units to those in the table's.
  const Eigen::MatrixXd& back() const { return back_; }
  // Where the table's slope variable is 0, in these units.
  double slope_at_zero() const { return -mean_ / slope_; }

  // Variances in the table's units.
  void set_variances(MixedFit& fit, const MixedSettings& s, const Scales& scales) const {
    const double at = slope_at_zero();
    const double shared = scales.intercept + at * scales.cross;
    fit.participant_variance = shared * shared + at * at * scales.slope * scales.slope;
    if (s.clips) fit.clip_variance = scales.clip * scales.clip;
    if (!s.slopes) {
      fit.participant_variance = scales.intercept * scales.intercept;
      return;
    }
    fit.slope_variance = (scales.slope * scales.slope + scales.cross * scales.cross) / (slope_ * slope_);
    if (s.correlated)
      fit.intercept_slope_covariance = (shared * scales.cross + at * scales.slope * scales.slope) / slope_;
  }
  // The way back, of a fit without a correlation.
  Scales scales_of(const MixedFit& fit) const {
    const double slope = std::sqrt(fit.slope_variance.value_or(0));
    Scales out{.clip = std::sqrt(fit.clip_variance.value_or(0))};
    out.intercept = std::hypot(std::sqrt(fit.participant_variance), mean_ * slope);
    if (out.intercept > 0) out.cross = mean_ * slope * slope * slope_ / out.intercept;
    out.slope = std::sqrt(std::max(0.0, slope * slope * slope_ * slope_ - out.cross * out.cross));
    return out;
  }
  std::vector<double> effects_of(const MixedFit& fit) const {
    std::vector<double> out(fit.fixed.size());
    out[0] = fit.fixed[0].estimate;
    for (size_t j = 1; j < out.size(); ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      out[j] = fit.fixed[j].estimate / back_(k, k);
      out[0] -= back_(0, k) * out[j];
    }
    return out;
  }

 private:
  void set_slope(std::vector<MixedRow>& rows, double count, bool centred) {
    if (centred)
      for (const MixedRow& row : rows) mean_ += static_cast<double>(row.of) * row.slope / count;
    const auto size = [&] {
      double square = 0;
      for (const MixedRow& row : rows)
        square += static_cast<double>(row.of) * (row.slope - mean_) * (row.slope - mean_) / count;
      return std::sqrt(square);
    };
    double unit = size();
    if (unit <= 1e-12 * std::fabs(mean_)) {  // the same everywhere
      mean_ = 0;
      unit = size();
    }
    if (unit > 0) slope_ = unit;
    for (MixedRow& row : rows) row.slope = (row.slope - mean_) / slope_;
  }

  Eigen::MatrixXd back_;
  double mean_ = 0;
  double slope_ = 1;
};

// ---- the pooled model, without anything random

struct Pooled {
  Eigen::VectorXd beta;
  Eigen::VectorXd direction;  // of the last step
  Eigen::MatrixXd information;
};

Pooled fit_pooled(const Likelihood& model) {
  const auto n = static_cast<Eigen::Index>(model.effects());
  const MixedSettings& s = model.settings();
  Pooled out{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
  const auto value_at = [&](const Eigen::VectorXd& beta) {
    double sum = 0;
    for (const MixedRow& cell : model.cells()) {
      const mixed::Local local = mixed::local_at(s.link, s.guess, vector_of(cell.fixed).dot(beta));
      sum += cell.weight_of_yes() * local.yes + cell.weight_of_no() * local.no;
    }
    return sum;
  };
  double value = value_at(out.beta);
  for (int i = 0; i < 60; ++i) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
    out.information.setZero();
    for (const MixedRow& cell : model.cells()) {
      const Eigen::VectorXd x = vector_of(cell.fixed);
      const mixed::Local local = mixed::local_at(s.link, s.guess, x.dot(out.beta));
      gradient += (cell.weight_of_yes() * local.yes_1 + cell.weight_of_no() * local.no_1) * x;
      out.information += -static_cast<double>(cell.of) * local.yes_1 * local.no_1 * x * x.transpose();
    }
    const Eigen::VectorXd step = dense::solve_symmetric(out.information, gradient);
    if (!step.allFinite() || step.dot(gradient) < 1e-14) break;
    double part = 1;
    double there = value_at(out.beta + step);
    for (int halving = 0; halving < 30 && !(there >= value); ++halving) there = value_at(out.beta + (part /= 2) * step);
    if (!(there >= value)) break;
    out.direction = part * step;
    out.beta += out.direction;
    value = there;
    if (out.beta.cwiseAbs().maxCoeff() > 1e8) break;
  }
  return out;
}

// Whether a direction of the fixed effects parts all answers: then going along it never lowers the likelihood, and
// there is no estimate. That is a proof, whoever found the direction.
bool parts_all(const Likelihood& model, const Eigen::VectorXd& direction) {
  double largest = 0;
  for (const MixedRow& cell : model.cells())
    largest = std::max(largest, std::fabs(vector_of(cell.fixed).dot(direction)));
  const double hair = 1e-6 * largest;
  for (const MixedRow& cell : model.cells()) {
    const double along = vector_of(cell.fixed).dot(direction);
    if ((cell.weight_of_yes() > 0 && along < -hair) || (cell.weight_of_no() > 0 && along > hair)) return false;
  }
  return largest > 0;
}

MixedState state_before(const Likelihood& model) {
  double yes = 0;
  double no = 0;
  for (const MixedRow& cell : model.cells()) {
    yes += cell.weight_of_yes();
    no += cell.weight_of_no();
  }
  if (yes == 0 || no == 0) return MixedState::all_alike;
  if (model.participants() < 2) return MixedState::one_participant;
  Eigen::MatrixXd x(static_cast<Eigen::Index>(model.cells().size()), static_cast<Eigen::Index>(model.effects()));
  for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = vector_of(model.cells()[static_cast<size_t>(i)].fixed);
  return dense::rank(x) < x.cols() ? MixedState::unidentified : MixedState::fitted;
}

// ---- the fit

struct Optimum {
  std::vector<double> x;
  double value = 0;  // minus the log-likelihood
  std::vector<bool> at_zero;
};

using Starts = std::vector<std::vector<double>>;  // as Unknowns has them

// Where a search begins: variances of middling size, and, where it is to be thorough, larger ones and correlations
// either way. With a slope the likelihood has more than one hill.
Starts starts_of(const Unknowns& unknowns, const MixedSettings& settings, const Eigen::VectorXd& beta) {
  std::vector<Scales> scales = {{0.5, 0, 0.5, 0.5}};
  if (settings.thorough) {
    scales.push_back({1.5, 0, 1.5, 1.5});
    if (settings.slopes && settings.correlated)
      for (const double correlation : {0.5, -0.5})
        scales.push_back({1, correlation, std::sqrt(1 - correlation * correlation), 0.5});
  }
  Starts out;
  for (const Scales& each : scales) {
    out.push_back(unknowns.from(each));
    out.back().insert(out.back().end(), beta.begin(), beta.end());
  }
  return out;
}

// The likelihood is flat at a variance of 0, where a minimiser without derivatives stops a little beside it: what may
// as well be 0 is.
void settle_zeros(const Objective& objective, const Unknowns& unknowns, const MixedSettings& settings,
                  const std::vector<double>& step, double gain, Optimum& out) {
  for (size_t i = 0; i < unknowns.scales(); ++i) {
    if (!unknowns.bounded(i) || out.x[i] > 0.1) continue;
    Bounds bounds = unknowns.bounds();
    bounds.high[i] = 0;
    for (size_t j = 0; j < out.at_zero.size(); ++j)
      if (out.at_zero[j]) bounds.high[j] = 0;
    std::vector<double> from = out.x;
    from[i] = 0;
    const Minimum without = minimise(objective, from, bounds, step, gain);
    if (without.value > out.value + (settings.thorough ? 1e-7 : 1e-5)) continue;
    out.x = without.x;
    out.value = without.value;
    out.at_zero[i] = true;
  }
}

Optimum optimise(Likelihood& model, const Unknowns& unknowns, const Pooled& pooled, const Starts& starts) {
  const Objective objective = [&](std::span<const double> x) {
    return -model.at(unknowns.scales_of(x), unknowns.effects_of(x));
  };
  std::vector<double> step(unknowns.scales(), 0.2);
  const Eigen::MatrixXd covariance = dense::inverse(pooled.information);
  for (Eigen::Index i = 0; i < pooled.beta.size(); ++i) {
    const double se = std::sqrt(covariance(i, i));
    step.push_back(std::isfinite(se) && se > 0 ? 2 * se : 0.1);
  }
  const double gain = model.settings().thorough ? 1e-9 : std::numeric_limits<double>::infinity();
  Minimum found{{}, std::numeric_limits<double>::infinity()};
  for (const std::vector<double>& start : starts) {
    Minimum other = minimise(objective, start, unknowns.bounds(), step, std::numeric_limits<double>::infinity());
    if (found.x.empty() || other.value < found.value - 1e-9) found = std::move(other);
  }
  if (model.settings().thorough) found = minimise(objective, found.x, unknowns.bounds(), step, gain);
  Optimum out{found.x, found.value, std::vector<bool>(unknowns.count(), false)};
  settle_zeros(objective, unknowns, model.settings(), step, gain, out);
  // Of a slope that has no intercept to be correlated with, the two parts are one.
  if (model.settings().slopes && model.settings().correlated && out.at_zero[0]) {
    out.x[2] = std::hypot(out.x[1], out.x[2]);
    out.x[1] = 0;
    out.at_zero[1] = true;
    out.at_zero[2] = out.x[2] == 0;
  }
  return out;
}

// The covariance of the fixed effects.
std::optional<Eigen::MatrixXd> fixed_covariance(Likelihood& model, const Unknowns& unknowns, const Optimum& best) {
  const auto effects = static_cast<Eigen::Index>(unknowns.count() - unknowns.scales());
  const auto given_scales = [&] {
    return dense::inverse_of_positive(model.fixed_information(unknowns.scales_of(best.x), unknowns.effects_of(best.x)));
  };
  if (!model.settings().full_errors) return given_scales();
  // What lies on a bound is held there.
  std::vector<size_t> moving;
  std::vector<double> x;
  std::vector<double> step;
  for (size_t i = 0; i < unknowns.count(); ++i) {
    if (best.at_zero[i]) continue;
    moving.push_back(i);
    x.push_back(best.x[i]);
    step.push_back(2e-3 * std::max(0.2, std::fabs(best.x[i])));
  }
  const Objective objective = [&](std::span<const double> moved) {
    std::vector<double> all = best.x;
    for (size_t i = 0; i < moving.size(); ++i) all[moving[i]] = moved[i];
    return -model.at(unknowns.scales_of(all), unknowns.effects_of(all));
  };
  const Matrix curvature = hessian(objective, x, step);
  Eigen::MatrixXd information(static_cast<Eigen::Index>(x.size()), static_cast<Eigen::Index>(x.size()));
  for (size_t i = 0; i < x.size(); ++i) information.row(static_cast<Eigen::Index>(i)) = vector_of(curvature[i]);
  const std::optional<Eigen::MatrixXd> inverse = dense::inverse_of_positive(information);
  if (!inverse) return given_scales();
  return inverse->bottomRightCorner(effects, effects);
}

// back: from the units of the fit to those of the table.
void set_effects(MixedFit& fit, const Eigen::MatrixXd& back, const Eigen::VectorXd& beta,
                 const std::optional<Eigen::MatrixXd>& covariance) {
  const Eigen::VectorXd estimate = dense::product(back, beta);
  Eigen::MatrixXd spread;
  if (covariance) spread = dense::product(dense::product(back, *covariance), back.transpose());
  for (Eigen::Index i = 0; i < beta.size(); ++i) {
    MixedEffect effect{.estimate = estimate[i], .se = std::numeric_limits<double>::quiet_NaN()};
    if (covariance) {
      effect.se = std::sqrt(spread(i, i));
      effect.z = effect.estimate / effect.se;
      effect.p = two_sided_normal_p(effect.z);
      fit.covariance.emplace_back(spread.row(i).begin(), spread.row(i).end());
    }
    fit.fixed.push_back(effect);
  }
}

// Whether the likelihood holds the fixed effects anywhere: not where it is flat.
bool is_held(const std::optional<Eigen::MatrixXd>& covariance) {
  constexpr double kFlat = 10;  // logits by standard deviation of a variable
  return covariance && covariance->diagonal().maxCoeff() < kFlat * kFlat;
}

double largest_eta(const Likelihood& model, const Eigen::VectorXd& beta) {
  double out = 0;
  for (const MixedRow& cell : model.cells()) out = std::max(out, std::fabs(vector_of(cell.fixed).dot(beta)));
  return out;
}

bool has_fit(const MixedFit& fit) { return fit.state == MixedState::fitted || fit.state == MixedState::singular; }

// The optimum of the model without a correlation as one more start: what it holds is then never below it.
void add_nested(Starts& starts, const std::vector<MixedRow>& rows, MixedSettings settings, const Unknowns& unknowns,
                const Units& units) {
  settings.correlated = settings.full_errors = false;
  const MixedFit fit = fit_mixed(rows, settings);
  if (!has_fit(fit)) return;
  starts.push_back(unknowns.from(units.scales_of(fit)));
  const std::vector<double> effects = units.effects_of(fit);
  starts.back().insert(starts.back().end(), effects.begin(), effects.end());
}

}  // namespace

std::string_view state_text(MixedState state) {
  switch (state) {
    case MixedState::fitted: return "fitted";
    case MixedState::singular: return "singular";
    case MixedState::no_data: return "no data";
    case MixedState::all_alike: return "all answers alike";
    case MixedState::one_participant: return "one participant";
    case MixedState::separated: return "separated";
    case MixedState::unidentified: break;
  }
  return "unidentified";
}

MixedFit fit_mixed(std::vector<MixedRow> rows, const MixedSettings& settings) {
  assert(settings.integration != Integration::quadrature || (!settings.slopes && !settings.clips));
  MixedFit fit;
  std::erase_if(rows, [](const MixedRow& row) { return row.of == 0; });
  if (rows.empty()) return fit;
  const bool correlated = settings.slopes && settings.correlated;
  const std::vector<MixedRow> table = correlated && settings.thorough ? rows : std::vector<MixedRow>();
  const Units units(rows, correlated);
  Likelihood model(std::move(rows), settings);
  for (const MixedRow& cell : model.cells()) fit.answers += cell.of;
  fit.participants = model.participants();
  fit.clips = model.clips();
  fit.state = state_before(model);
  if (fit.state != MixedState::fitted) return fit;
  const Pooled pooled = fit_pooled(model);
  if (parts_all(model, pooled.direction)) {
    fit.state = MixedState::separated;
    return fit;
  }
  const Unknowns unknowns(settings, model.effects());
  Starts starts = starts_of(unknowns, settings, pooled.beta);
  if (!table.empty()) add_nested(starts, table, settings, unknowns, units);
  const Optimum best = optimise(model, unknowns, pooled, starts);
  const Scales scales = unknowns.scales_of(best.x);
  const Eigen::VectorXd beta = unknowns.effects_of(best.x);
  const std::optional<Eigen::MatrixXd> covariance = fixed_covariance(model, unknowns, best);
  if (largest_eta(model, beta) > kInfinite && !is_held(covariance)) {
    fit.state = MixedState::separated;
    return fit;
  }
  if (std::find(best.at_zero.begin(), best.at_zero.end(), true) != best.at_zero.end()) fit.state = MixedState::singular;
  fit.log_likelihood = -best.value;
  units.set_variances(fit, settings, scales);
  set_effects(fit, units.back(), beta, covariance);
  for (const Likelihood::Mode& mode : model.modes(scales, beta, settings.slopes ? units.slope_at_zero() : 0)) {
    fit.modes.push_back(mode.intercept);
    fit.mode_sds.push_back(mode.sd);
  }
  return fit;
}

std::optional<LikelihoodRatio> likelihood_ratio(const std::vector<MixedRow>& rows, const MixedSettings& settings,
                                                const MixedFit& fit, size_t effect) {
  assert(has_fit(fit) && effect < fit.fixed.size());
  std::vector<MixedRow> smaller = rows;
  for (MixedRow& row : smaller) row.fixed.erase(row.fixed.begin() + static_cast<std::ptrdiff_t>(effect));
  MixedSettings quick = settings;
  quick.full_errors = false;
  const MixedFit without = fit_mixed(std::move(smaller), quick);
  if (!has_fit(without)) return std::nullopt;
  const double chi_squared = std::max(0.0, 2 * (fit.log_likelihood - without.log_likelihood));
  return LikelihoodRatio{chi_squared, chi_squared_tail(chi_squared, 1)};
}

}  // namespace crowdbench::studies
