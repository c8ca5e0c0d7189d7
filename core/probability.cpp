// Based on: the continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), evaluated by the
// method of W. J. Lentz, "Generating Bessel functions in Mie scattering calculations using continued fractions",
// Applied Optics 15 (1976), as modified by Thompson and Barnett (1986).
#include "core/probability.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace crowdbench {
namespace {

// The continued fraction beside x^a (1 - x)^b / (a B(a, b)); converges fast for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  const auto away_from_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1;
  double d = 1 / away_from_zero(1 - (a + b) * x / (a + 1));
  double fraction = d;
  for (int step = 1; step < 10'000; ++step) {
    const double m = step;
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away_from_zero(1 + even * d);
    c = away_from_zero(1 + even / c);
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away_from_zero(1 + odd * d);
    c = away_from_zero(1 + odd / c);
    fraction *= d * c;
    if (std::abs(d * c - 1) < 1e-16) break;
  }
  return fraction;
}

// The root of an ascending function of z: the bracket is doubled until it holds one, then halved.
template <typename Cdf>
double inverse(const Cdf& cdf, double p) {
  double low = -1;
  double high = 1;
  while (cdf(low) > p) low *= 2;
  while (cdf(high) < p) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-15 * (std::abs(low) + std::abs(high)); ++i) {
    const double middle = 0.5 * (low + high);
    (cdf(middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

double normal_quantile(double p) {
  assert(p > 0 && p < 1);
  return inverse(normal_cdf, p);
}

double incomplete_beta(double a, double b, double x) {
  assert(a > 0 && b > 0 && x >= 0 && x <= 1);
  if (x == 0 || x == 1) return x;
  const double factor =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return factor * beta_fraction(a, b, x) / a;
  return 1 - factor * beta_fraction(b, a, 1 - x) / b;
}

double student_t_two_sided(double t, double df) {
  assert(df > 0);
  if (std::isinf(t)) return 0;
  return incomplete_beta(0.5 * df, 0.5, df / (df + t * t));
}

double student_t_quantile(double p, double df) {
  assert(p > 0 && p < 1);
  return inverse(
      [df](double t) {
        const double tail = 0.5 * student_t_two_sided(t, df);
        return t < 0 ? tail : 1 - tail;
      },
      p);
}

CountLimits binomial_limits(uint64_t n, double p, double confidence) {
  assert(p > 0 && p < 1 && confidence > 0 && confidence < 1);
  const double tail = 0.5 * (1 - confidence);
  const double trials = static_cast<double>(n);
  const auto probability = [&](uint64_t count) {
    const double k = static_cast<double>(count);
    return std::exp(std::lgamma(trials + 1) - std::lgamma(k + 1) - std::lgamma(trials - k + 1) + k * std::log(p) +
                    (trials - k) * std::log1p(-p));
  };
  CountLimits limits{0, n};
  double below = probability(0);
  while (limits.low < n && below <= tail) below += probability(++limits.low);
  double above = probability(n);
  while (limits.high > 0 && above <= tail) above += probability(--limits.high);
  return limits;
}

}  // namespace crowdbench
