// The distributions that tests, intervals and likelihoods are read from: normal, Student's t, chi-squared, beta,
// binomial. Pure functions, exact to about 1e-12 of themselves unless said; arguments out of range are bugs and assert.
#pragma once
#include <cstdint>
#include <vector>

namespace crowdbench {

// ---- normal
double normal_density(double x);
double normal_cdf(double x);
// log of normal_cdf(x), finite for every finite x: an answer that the model holds for impossible still has a
// likelihood.
double log_normal_cdf(double x);
// p in (0, 1); 0 and 1 give minus and plus infinity.
double normal_quantile(double p);
// The chance of more than |z| on either side.
double two_sided_normal_p(double z);

// ---- Student's t; degrees of freedom above 0, any real number
double student_t_cdf(double t, double degrees);
double student_t_two_sided(double t, double degrees);  // P(|T| >= |t|); an infinite t gives 0
double student_t_quantile(double p, double degrees);   // p in (0, 1)

// ---- chi-squared: the chance of more than x; x at least 0. `chi_squared_quantile_1` is for one degree of freedom.
double chi_squared_tail(double x, double degrees);
double chi_squared_quantile_1(double p);

// ---- beta: I_x(a, b), a and b above 0, x in [0, 1]; and the x of which it is p
double beta_cdf(double x, double a, double b);
double beta_quantile(double p, double a, double b);

// ---- binomial: n trials of chance p in [0, 1]
// P(X = k) for every k from 0 to n.
std::vector<double> binomial_probabilities(uint64_t n, double p);
double binomial_at_most(uint64_t k, uint64_t n, double p);   // P(X <= k)
double binomial_at_least(uint64_t k, uint64_t n, double p);  // P(X >= k)
double log_choose(uint64_t n, uint64_t k);
// The counts between which a count of n trials lies with at least the given confidence, at most half of the rest on
// either side: what a count is held against when p, in (0, 1), is claimed.
struct CountLimits {
  uint64_t low = 0;
  uint64_t high = 0;
};
CountLimits binomial_limits(uint64_t n, double p, double confidence = 0.95);

// log(1 + exp(x)) and 1 / (1 + exp(-x)), exact at both ends.
double log_one_plus_exp(double x);
double logistic_cdf(double x);

}  // namespace crowdbench
