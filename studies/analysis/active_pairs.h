// Which two items to show next, so that the answer is expected to tell most about how all of them rank.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace crowdbench::studies {

struct PairAnswer {
  size_t a = 0;
  size_t b = 0;      // not a
  double a_won = 0;  // 1: a was chosen, 0: b was; 0.5: "cannot tell"
};

// What is known of the items' log-worths: P(a over b) = 1 / (1 + exp(w_b - w_a)) (Bradley and Terry 1952).
struct PairBelief {
  std::vector<double> mean;                     // by item, in logits
  std::vector<std::vector<double>> covariance;  // of them
};

// A normal approximation of the posterior, at its mode, after any answers in any order; before them every log-worth is
// normal with mean 0 and this standard deviation.
inline constexpr double kWorthSd = 1.5;
PairBelief pair_belief(std::span<const PairAnswer> answers, size_t items);

// The information that an answer to "a or b?" is expected to give, in nats: from 0 (known beforehand) to log 2.
double expected_information(const PairBelief& belief, size_t a, size_t b);

}  // namespace crowdbench::studies
