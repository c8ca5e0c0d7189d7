// How many participants a study needs: the whole of it simulated, answers and mixed model, as often as one likes.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crowdbench::studies {

// Two conditions (x = -1/2 and +1/2) within every observer, each of `clips` clips `repeats` times in either. Answers by
// logit P = intercept + effect x + observer + clip; analysed by the mixed logistic regression that this is, with clips
// random where they were made to differ, and the Wald test of the effect.
struct PowerSettings {
  double intercept = 0;
  double effect = 0.5;  // in logits
  double participant_sd = 0.8;
  double clip_sd = 0;
  uint32_t participants = 24;
  uint32_t clips = 10;
  uint32_t repeats = 2;
  double alpha = 0.05;
  size_t simulations = 1000;
  uint64_t seed = 1;
  unsigned threads = 0;  // 0: as many as the machine has; the result is the same
};
struct Power {
  double power = 0;     // share of simulations whose test rejects "no effect"
  double power_se = 0;  // of that share, for the number of simulations
  double mean_estimate = 0;
  double sd_estimate = 0;
  double mean_se = 0;         // what the fits say that the spread is
  double interval_width = 0;  // mean width of the 95 % interval of the effect
  size_t singular = 0;        // fits with a variance of 0
  size_t failed = 0;          // without an estimate: counted as not rejecting, left out of the means
};
Power simulate_power(const PowerSettings& settings);

}  // namespace crowdbench::studies
