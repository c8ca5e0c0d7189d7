// Shares of answers: intervals, exact tests against a chance level, and what signal detection makes of them. Pure
// functions. Trials are taken as independent of each other; those of one participant are not, which equivalence.h and
// mixed_model.h are for.
#pragma once
#include <cstdint>
#include <optional>

#include "core/statistics.h"

namespace crowdbench::studies {

// k of n, 0 < n, k <= n; confidence in (0, 1).
// Clopper and Pearson 1934: exact, covers at least as often as it says.
Interval clopper_pearson(uint64_t k, uint64_t n, double confidence = 0.95);
// Wilson 1927, without continuity correction: covers as often as it says on average.
Interval wilson(uint64_t k, uint64_t n, double confidence = 0.95);

struct BinomialTest {
  double two_sided = 1;  // sum of the chances of all outcomes no likelier than k (as R's binom.test)
  double greater = 1;    // P(X >= k)
  double less = 1;       // P(X <= k)
};
// Of the hypothesis that every trial has chance p0, in [0, 1].
BinomialTest binomial_test(uint64_t k, uint64_t n, double p0);

// d' of a two-alternative task whose share of right answers is p in [0, 1]: sqrt(2) times the normal quantile.
double d_prime_2afc(double p);

// A same-different or yes-no task: how far apart signal and noise are, and how ready the answer is.
struct SignalDetection {
  double d_prime = 0;
  double criterion = 0;  // above 0: slow to say that there was a signal
  // Standard errors by the delta method (Gourevitch and Galanter 1967).
  double d_prime_se = 0;
  double criterion_se = 0;
  bool corrected = false;  // a rate was 0 or 1
};
// hits of signals, false_alarms of noises. Where a rate is 0 or 1, half an answer is added to each of the four cells
// (the log-linear rule of Hautus 1995). Nothing where there were no signals or no noises.
std::optional<SignalDetection> signal_detection(uint64_t hits, uint64_t signals, uint64_t false_alarms,
                                                uint64_t noises);

}  // namespace crowdbench::studies
