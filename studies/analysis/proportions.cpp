#include "studies/analysis/proportions.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/probability.h"

namespace crowdbench::studies {
namespace {

// Outcomes of more trials are not gone through one by one.
constexpr uint64_t kMostListed = 100'000;

double log_chance(uint64_t k, uint64_t n, double p) {
  return log_choose(n, k) + static_cast<double>(k) * std::log(p) + static_cast<double>(n - k) * std::log1p(-p);
}

// The same sum by where the outcomes that are likelier than k end on the other side of the likeliest: chances fall on
// either side of it.
double two_sided_of_many(uint64_t k, uint64_t n, double p) {
  if (p == 0 || p == 1) return k == (p == 0 ? 0 : n) ? 1 : 0;
  const auto mode = std::min(n, static_cast<uint64_t>(static_cast<double>(n + 1) * p));
  const double limit = log_chance(k, n, p) + 1e-7;
  if (log_chance(mode, n, p) <= limit) return 1;
  uint64_t likelier = mode;
  uint64_t beyond = k < mode ? n + 1 : 0;  // n + 1 is no outcome
  if (k > mode && log_chance(0, n, p) > limit) return binomial_at_least(k, n, p);
  while (std::max(likelier, beyond) - std::min(likelier, beyond) > 1) {
    const uint64_t middle = std::min(likelier, beyond) + (std::max(likelier, beyond) - std::min(likelier, beyond)) / 2;
    (log_chance(middle, n, p) > limit ? likelier : beyond) = middle;
  }
  const double sum = k < mode ? binomial_at_most(k, n, p) + binomial_at_least(beyond, n, p)
                              : binomial_at_least(k, n, p) + binomial_at_most(beyond, n, p);
  return std::min(1.0, sum);
}

}  // namespace

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
  if (n > kMostListed) return {two_sided_of_many(k, n, p0), binomial_at_least(k, n, p0), binomial_at_most(k, n, p0)};
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
