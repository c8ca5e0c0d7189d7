// How many participants a study needs: the whole of it simulated, answers and mixed model, as often as one likes.
#pragma once
#include <cstddef>
#include <cstdint>

#include "studies/analysis/analysis.h"
#include "studies/analysis/simulated.h"

namespace crowdbench {
class Progress;
}

namespace crowdbench::studies {

// Long work: each of the functions below advances `progress`, where there is one, by the participants of every study
// that it has simulated, and throws Interrupted between two studies.

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
  Progress* progress = nullptr;
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

// A planned study of a threshold: its own levels, clips, repeats and participants, by simulate_answers(), analysed by
// the mixed model that its analysis has (random effects, link, guess, level, confidence).
struct ThresholdPowerSettings {
  SimulatedObservers observers;
  SimulatedDesign design;
  AnalysisSettings analysis;  // `random` is not none
  size_t simulations = 1000;
  uint64_t seed = 1;
  unsigned threads = 0;  // 0: as many as the machine has; the result is the same
  Progress* progress = nullptr;
};
struct ThresholdPower {
  double mean_estimate = 0;  // of those with an estimate
  double sd_estimate = 0;
  double median_width = 0;  // of the closed intervals, in units of the level
  double held = 0;          // share of the closed intervals that hold the truth
  double held_se = 0;       // of that share, for their number
  size_t closed = 0;        // simulations whose interval has two ends
  size_t open = 0;          // with an estimate, and no such interval: the slope is not known to differ from 0
  size_t failed = 0;        // without an estimate
};
// Where the typical observer's P(yes) is analysis.curve.level.
double true_threshold(const ThresholdPowerSettings& settings);
// Asserts that observers.lapse is 0, and that P(yes) of the observers reaches the level: guess < level < 1.
ThresholdPower simulate_threshold_power(const ThresholdPowerSettings& settings);

// How often the verdict on one condition is "equivalent" where every participant answers `trials` trials.
struct EquivalencePowerSettings {
  uint32_t participants = 24;
  uint32_t trials = 12;
  EquivalenceSettings equivalence;
  size_t simulations = 1000;
  uint64_t seed = 1;
  unsigned threads = 0;
  Progress* progress = nullptr;
};
struct EquivalencePower {
  double power = 0;      // nobody sees anything: every answer is chance
  double at_margin = 0;  // every answer is chance + margin: what may be called equivalent at most alpha times
  double power_se = 0, at_margin_se = 0;
};
EquivalencePower simulate_equivalence_power(const EquivalencePowerSettings& settings);

}  // namespace crowdbench::studies
