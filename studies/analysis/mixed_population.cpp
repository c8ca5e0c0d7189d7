// Based on: Fieller, "Some problems in interval estimation" (1954), for the interval of a ratio; Satterthwaite, "An
// approximate distribution of estimates of variance components" (1946), for the degrees of freedom.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/probability.h"
#include "studies/analysis/mixed_model.h"

namespace crowdbench::studies {
namespace {

double probability(const MixedSettings& s, double eta) {
  return s.guess + (1 - s.guess) * (s.link == Link::logit ? logistic_cdf(eta) : normal_cdf(eta));
}

double linear(const MixedFit& fit, const std::vector<double>& fixed) {
  double out = 0;
  for (size_t i = 0; i < fixed.size(); ++i) out += fit.fixed[i].estimate * fixed[i];
  return out;
}

// Of n that were drawn at random, with a variance of their own: what they add to the variance of eta's estimate.
struct Drawn {
  double variance = 0;
  double degrees = 0;  // of freedom, n - 1
};
Drawn drawn(double variance, size_t n) {
  return n < 2 ? Drawn{} : Drawn{std::max(0.0, variance) / static_cast<double>(n), static_cast<double>(n - 1)};
}

// The estimate of eta at x beside its variance as the fit states it, which takes the variances of participants and
// clips for known.
struct Spread {
  double inflation = 1;  // of the stated variance: maximum likelihood divides squares by n, and not by n - 1
  double degrees = std::numeric_limits<double>::infinity();
};
Spread spread_at(const MixedFit& fit, double x) {
  const auto& c = fit.covariance;
  const double stated = c[0][0] + 2 * x * c[0][1] + x * x * c[1][1];
  const double participant = fit.participant_variance + 2 * x * fit.intercept_slope_covariance.value_or(0) +
                             x * x * fit.slope_variance.value_or(0);
  double more = 0;
  double squares = 0;
  for (const Drawn& each : {drawn(participant, fit.participants), drawn(fit.clip_variance.value_or(0), fit.clips)}) {
    if (each.variance == 0) continue;
    const double share = std::min(each.variance, stated);
    more += share / each.degrees;
    squares += (share + share / each.degrees) * (share + share / each.degrees) / each.degrees;
  }
  // Of few participants the variance between them is often estimated as 0 where it is not, which would leave infinitely
  // many degrees: there are never more than participants less one.
  const double most = fit.participants > 1 ? static_cast<double>(fit.participants - 1) : Spread().degrees;
  if (squares == 0) return {1, most};
  return {1 + more / stated, std::min(most, (stated + more) * (stated + more) / squares)};
}

// How many squared standard errors a two-sided interval reaches.
double squared_quantile(double confidence, double degrees) {
  constexpr double kAsGoodAsNormal = 1e6;
  if (degrees > kAsGoodAsNormal) return chi_squared_quantile_1(confidence);
  const double t = student_t_quantile(0.5 + confidence / 2, degrees);
  return t * t;
}

}  // namespace

PopulationProbability population_probability(const MixedFit& fit, const MixedSettings& settings,
                                             const std::vector<double>& fixed) {
  assert(fixed.size() == fit.fixed.size());
  const double eta = linear(fit, fixed);
  const double x = fixed.size() > 1 ? fixed[1] : 0;
  double variance = fit.participant_variance + fit.clip_variance.value_or(0);
  variance += 2 * x * fit.intercept_slope_covariance.value_or(0) + x * x * fit.slope_variance.value_or(0);
  PopulationProbability out{probability(settings, eta), 0};
  const Quadrature& rule = gauss_hermite_25();
  for (size_t k = 0; k < rule.nodes.size(); ++k)
    out.average += rule.weights[k] * probability(settings, eta + std::sqrt(variance) * rule.nodes[k]);
  return out;
}

std::optional<MixedThreshold> mixed_threshold(const MixedFit& fit, const MixedSettings& settings, double level,
                                              double confidence) {
  assert(fit.fixed.size() == 2);
  const double f = (level - settings.guess) / (1 - settings.guess);
  if (!(f > 0 && f < 1) || fit.fixed[1].estimate == 0) return std::nullopt;
  const double target = settings.link == Link::logit ? std::log(f / (1 - f)) : normal_quantile(f);
  MixedThreshold out{(target - fit.fixed[0].estimate) / fit.fixed[1].estimate, std::nullopt};
  if (fit.covariance.empty()) return out;
  // Fieller: all t of which b0 + b1 t - target is within so many standard errors of 0.
  const Spread spread = spread_at(fit, out.at);
  const double z2 = spread.inflation * squared_quantile(confidence, spread.degrees);
  const double b0 = fit.fixed[0].estimate - target;
  const double b1 = fit.fixed[1].estimate;
  const double a = b1 * b1 - z2 * fit.covariance[1][1];
  const double b = b0 * b1 - z2 * fit.covariance[0][1];
  const double c = b0 * b0 - z2 * fit.covariance[0][0];
  const double root = b * b - a * c;
  if (a <= 0 || root < 0) return out;
  out.interval = Interval{(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
  return out;
}

}  // namespace crowdbench::studies
