// The distributions that tests and intervals are read from: normal, Student's t, binomial. Pure functions.
#pragma once
#include <cstdint>

namespace crowdbench {

// P(Z <= z) of the standard normal, and the z of a probability in (0, 1). Errors below 1e-13, relative in both tails.
double normal_cdf(double z);
double normal_quantile(double p);

// P(|T| >= |t|) of Student's t with `df` > 0 degrees of freedom (any real number). An infinite t gives 0.
double student_t_two_sided(double t, double df);
// The t with P(T <= t) = p, p in (0, 1).
double student_t_quantile(double p, double df);

// The regularised incomplete beta function I_x(a, b), a and b > 0, x in [0, 1].
double incomplete_beta(double a, double b, double x);

// The counts between which a binomial(n, p) count lies with at least the given confidence, at most half of the rest on
// either side: what a count of n trials is held against when p is claimed.
struct CountLimits {
  uint64_t low = 0;
  uint64_t high = 0;
};
CountLimits binomial_limits(uint64_t n, double p, double confidence = 0.95);

}  // namespace crowdbench
