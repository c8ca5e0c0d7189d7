#include "studies/analysis/proportions.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/probability.h"

namespace crowdbench::studies {

Interval clopper_pearson(uint64_t k, uint64_t n, double confidence) {
  assert(n > 0 && k <= n && confidence > 0 && confidence < 1);
  const double tail = (1 - confidence) / 2;
  const auto hit = static_cast<double>(k);
  const auto missed = static_cast<double>(n - k);
  return {k == 0 ? 0 : beta_quantile(tail, hit, missed + 1), k == n ? 1 : beta_quantile(1 - tail, hit + 1, missed)};
}

Interval wilson(uint64_t k, uint64_t n, double confidence) {
  assert(n > 0 && k <= n && confidence > 0 && confidence < 1);
  const double z = normal_quantile((1 + confidence) / 2);
  const auto count = static_cast<double>(n);
  const double p = static_cast<double>(k) / count;
  const double scale = 1 + z * z / count;
  const double centre = (p + z * z / (2 * count)) / scale;
  const double half = z / scale * std::sqrt(p * (1 - p) / count + z * z / (4 * count * count));
  return {k == 0 ? 0 : std::max(0.0, centre - half), k == n ? 1 : std::min(1.0, centre + half)};
}

BinomialTest binomial_test(uint64_t k, uint64_t n, double p0) {
  assert(k <= n);
  const std::vector<double> chances = binomial_probabilities(n, p0);
  // Outcomes that are equally likely but for the last digits count as such.
  const double limit = chances[k] * (1 + 1e-7);
  double sum = 0;
  for (const double chance : chances)
    if (chance <= limit) sum += chance;
  return {std::min(1.0, sum), binomial_at_least(k, n, p0), binomial_at_most(k, n, p0)};
}

double d_prime_2afc(double p) { return std::numbers::sqrt2 * normal_quantile(p); }

std::optional<SignalDetection> signal_detection(uint64_t hits, uint64_t signals, uint64_t false_alarms,
                                                uint64_t noises) {
  assert(hits <= signals && false_alarms <= noises);
  if (signals == 0 || noises == 0) return std::nullopt;
  SignalDetection out;
  out.corrected = hits == 0 || hits == signals || false_alarms == 0 || false_alarms == noises;
  const double more = out.corrected ? 0.5 : 0;
  const double n_signal = static_cast<double>(signals) + 2 * more;
  const double n_noise = static_cast<double>(noises) + 2 * more;
  const double hit_rate = (static_cast<double>(hits) + more) / n_signal;
  const double alarm_rate = (static_cast<double>(false_alarms) + more) / n_noise;
  const double z_hit = normal_quantile(hit_rate);
  const double z_alarm = normal_quantile(alarm_rate);
  const auto variance = [](double rate, double z, double n) {
    return rate * (1 - rate) / (n * normal_density(z) * normal_density(z));
  };
  const double both = variance(hit_rate, z_hit, n_signal) + variance(alarm_rate, z_alarm, n_noise);
  out.d_prime = z_hit - z_alarm;
  out.criterion = -(z_hit + z_alarm) / 2;
  out.d_prime_se = std::sqrt(both);
  out.criterion_se = std::sqrt(both) / 2;
  return out;
}

}  // namespace crowdbench::studies
