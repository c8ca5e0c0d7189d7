// Based on: NIST Digital Library of Mathematical Functions, 8.17.22 (continued fraction of the incomplete beta
// function), 8.9.2 and 8.7.1 (incomplete gamma function), 7.12.1 (tail of the error function); Abramowitz and
// Stegun 26.2.23 (first guess of the normal quantile, which Halley's rule then sharpens).
#include "core/probability.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace crowdbench {
namespace {

constexpr double kTiny = 1e-300;
constexpr double kEnough = 1e-16;

// lgamma keeps the sign of its result in a global; this one does not.
double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

// The continued fraction of I_x(a, b), by Lentz's rule; converges fast for x < (a + 1) / (a + b + 2).
double beta_fraction(double x, double a, double b) {
  double c = 1;
  double d = 1 / std::max(kTiny, std::fabs(1 - (a + b) * x / (a + 1))) * (1 - (a + b) * x / (a + 1) < 0 ? -1 : 1);
  double value = d;
  for (int m = 1; m < 100000; ++m) {
    for (const bool even : {true, false}) {
      const double term = even ? m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
                               : -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 + term * d;
      c = 1 + term / c;
      if (std::fabs(d) < kTiny) d = kTiny;
      if (std::fabs(c) < kTiny) c = kTiny;
      d = 1 / d;
      value *= c * d;
    }
    if (std::fabs(c * d - 1) < kEnough) break;
  }
  return value;
}

// The root of a rising function between low and high, to the last digit.
template <typename F>
double bisect(double low, double high, F&& rises) {
  for (int i = 0; i < 2000; ++i) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    (rises(middle) < 0 ? low : high) = middle;
  }
  return low + (high - low) / 2;
}

// The lower half of the normal quantile, p <= 0.5.
double lower_normal_quantile(double p) {
  const double t = std::sqrt(-2 * std::log(p));
  double x = -(t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308))));
  for (int i = 0; i < 4; ++i) {
    const double error = (normal_cdf(x) - p) / normal_density(x);
    x -= error / (1 + x * error / 2);
  }
  return x;
}

}  // namespace

double normal_density(double x) { return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi); }

double normal_cdf(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; }

double log_normal_cdf(double x) {
  if (x > -30) return x > 5 ? std::log1p(-normal_cdf(-x)) : std::log(normal_cdf(x));
  // The tail's asymptotic series: at -30 its fourth term is below 1e-10 of the first.
  const double s = 1 / (x * x);
  return -x * x / 2 - std::log(-x) - std::log(2 * std::numbers::pi) / 2 + std::log1p(-s * (1 - 3 * s * (1 - 5 * s)));
}

double normal_quantile(double p) {
  assert(p >= 0 && p <= 1);
  if (p == 0) return -std::numeric_limits<double>::infinity();
  if (p == 1) return std::numeric_limits<double>::infinity();
  return p <= 0.5 ? lower_normal_quantile(p) : -lower_normal_quantile(1 - p);
}

double two_sided_normal_p(double z) { return std::erfc(std::fabs(z) / std::numbers::sqrt2); }

double student_t_cdf(double t, double degrees) {
  assert(degrees > 0);
  if (!std::isfinite(t)) return t > 0 ? 1 : 0;
  const double tail = beta_cdf(degrees / (degrees + t * t), degrees / 2, 0.5) / 2;
  return t > 0 ? 1 - tail : tail;
}

double student_t_two_sided(double t, double degrees) { return 2 * student_t_cdf(-std::fabs(t), degrees); }

double student_t_quantile(double p, double degrees) {
  assert(p > 0 && p < 1);
  if (p == 0.5) return 0;
  double edge = 1;
  while (student_t_cdf(-edge, degrees) > std::min(p, 1 - p)) edge *= 2;
  const double low = bisect(-edge, 0, [&](double t) { return student_t_cdf(t, degrees) - std::min(p, 1 - p); });
  return p < 0.5 ? low : -low;
}

double chi_squared_tail(double x, double degrees) {
  assert(x >= 0 && degrees > 0);
  if (degrees == 1) return std::erfc(std::sqrt(x / 2));
  const double a = degrees / 2;
  const double h = x / 2;
  if (h == 0) return 1;
  const double front = std::exp(a * std::log(h) - h - log_gamma(a));
  if (h < a + 1) {  // the series of the lower part
    double term = 1 / a;
    double sum = term;
    for (int k = 1; k < 100000 && term > sum * kEnough; ++k) sum += term *= h / (a + k);
    return 1 - front * sum;
  }
  double b = h + 1 - a;
  double c = 1 / kTiny;
  double d = 1 / b;
  double value = d;
  for (int k = 1; k < 100000; ++k) {
    const double term = -k * (k - a);
    b += 2;
    d = 1 / (term * d + b);
    c = b + term / c;
    value *= c * d;
    if (std::fabs(c * d - 1) < kEnough) break;
  }
  return front * value;
}

double chi_squared_quantile_1(double p) {
  const double z = normal_quantile((1 + p) / 2);
  return z * z;
}

double beta_cdf(double x, double a, double b) {
  assert(a > 0 && b > 0 && x >= 0 && x <= 1);
  if (x == 0 || x == 1) return x;
  const double front = std::exp(a * std::log(x) + b * std::log1p(-x) + log_gamma(a + b) - log_gamma(a) - log_gamma(b));
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(x, a, b) / a : 1 - front * beta_fraction(1 - x, b, a) / b;
}

double beta_quantile(double p, double a, double b) {
  assert(p >= 0 && p <= 1);
  if (p == 0 || p == 1) return p;
  return bisect(0, 1, [&](double x) { return beta_cdf(x, a, b) - p; });
}

std::vector<double> binomial_probabilities(uint64_t n, double p) {
  assert(p >= 0 && p <= 1);
  std::vector<double> out(n + 1, 0);
  if (p == 0 || p == 1) {
    out[p == 0 ? 0 : n] = 1;
    return out;
  }
  // Outwards from the mode, so that what is small stays exact.
  const auto mode = std::min(n, static_cast<uint64_t>(static_cast<double>(n + 1) * p));
  const double odds = p / (1 - p);
  out[mode] = std::exp(log_choose(n, mode) + static_cast<double>(mode) * std::log(p) +
                       static_cast<double>(n - mode) * std::log1p(-p));
  for (uint64_t k = mode; k < n; ++k)
    out[k + 1] = out[k] * odds * static_cast<double>(n - k) / static_cast<double>(k + 1);
  for (uint64_t k = mode; k > 0; --k)
    out[k - 1] = out[k] / odds * static_cast<double>(k) / static_cast<double>(n - k + 1);
  return out;
}

double binomial_at_most(uint64_t k, uint64_t n, double p) {
  if (k >= n) return 1;
  if (p == 0 || p == 1) return p == 0 ? 1 : 0;
  return beta_cdf(1 - p, static_cast<double>(n - k), static_cast<double>(k + 1));
}

double binomial_at_least(uint64_t k, uint64_t n, double p) {
  if (k == 0) return 1;
  if (k > n || p == 0) return 0;
  if (p == 1) return 1;
  return beta_cdf(p, static_cast<double>(k), static_cast<double>(n - k + 1));
}

CountLimits binomial_limits(uint64_t n, double p, double confidence) {
  assert(p > 0 && p < 1 && confidence > 0 && confidence < 1);
  const double tail = 0.5 * (1 - confidence);
  const std::vector<double> probabilities = binomial_probabilities(n, p);
  CountLimits limits{0, n};
  double below = probabilities[0];
  while (limits.low < n && below <= tail) below += probabilities[++limits.low];
  double above = probabilities[n];
  while (limits.high > 0 && above <= tail) above += probabilities[--limits.high];
  return limits;
}

double log_choose(uint64_t n, uint64_t k) {
  assert(k <= n);
  return log_gamma(static_cast<double>(n) + 1) - log_gamma(static_cast<double>(k) + 1) -
         log_gamma(static_cast<double>(n - k) + 1);
}

double log_one_plus_exp(double x) { return x > 0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x)); }

double logistic_cdf(double x) {
  if (x >= 0) return 1 / (1 + std::exp(-x));
  const double e = std::exp(x);
  return e / (1 + e);
}

}  // namespace crowdbench
