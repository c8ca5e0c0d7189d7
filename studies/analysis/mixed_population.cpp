// Based on: Fieller, "Some problems in interval estimation" (1954), for the interval of a ratio.
#include <cassert>
#include <cmath>

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
  // Fieller: all t of which b0 + b1 t - target is within z standard errors of 0.
  const double z2 = chi_squared_quantile_1(confidence);
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
