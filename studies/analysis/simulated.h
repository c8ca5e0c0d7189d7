// Simulated observers: answers of whom everything is known, to test the analysis and to plan with. They are no people,
// and whatever is made of them says so.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "studies/analysis/answers.h"
#include "studies/analysis/paired_comparison.h"

namespace crowdbench::studies {

// P(yes) = g + (1 - g - lapse) / (1 + exp(-eta)), where
// eta = slope of the observer (level - threshold of the observer) + effect of the clip
//       + learning (trials done / all trials - 1/2) +- side_bias,
// g = guess, whose logit is moved by +- side_bias, too: who sees nothing chooses the preferred side.
struct SimulatedObservers {
  double threshold = 0;     // in units of the level; of the typical observer
  double slope = 1;         // of eta by unit of level; below 0 for what is seen less the higher the level
  double threshold_sd = 0;  // between observers
  double slope_log_sd = 0;  // of the logs of the slopes of observers
  double clip_sd = 0;       // of eta between clips
  double guess = 0;
  double lapse = 0;
  double side_bias = 0;  // in logits: added where what is looked for stands first, taken off where it stands second
  double learning = 0;   // of eta from the first trial to the last
};
struct SimulatedDesign {
  uint32_t participants = 24;
  std::vector<double> levels;  // at least one
  uint32_t clips = 1;
  uint32_t repeats = 1;  // of each clip at each level
};
// The rate of right guesses by who prefers a side; bias: in logits, below 0 where what is looked for stands on the
// other. At most 1 - lapse.
double biased_guess(double guess, double lapse, double bias);

// Every observer sees every clip at every level `repeats` times, in an order of their own; of the repeats every second
// has what is looked for on the first side. The same seed gives the same answers; the first observers are the same
// however many there are.
Answers simulate_answers(const SimulatedObservers& observers, const SimulatedDesign& design, uint64_t seed);

// As a table that add_answers() reads, with a first column that says simulated.
std::string answers_csv(const Answers& answers);

// Comparisons by observers whose log-worths differ from each other's.
struct SimulatedRanking {
  std::vector<double> log_worth;  // by item
  double log_nu = -1;             // of ties
  double position = 0;            // what standing first adds
  double worth_sd = 0;            // between observers, of each item
};
// Every observer compares every pair `repeats` times, every second time in the other order.
std::vector<Comparison> simulate_comparisons(const SimulatedRanking& ranking, uint32_t participants, uint32_t repeats,
                                             uint64_t seed);

// A standard normal number, by hash.
double random_normal(uint64_t seed, uint64_t index, uint64_t purpose);

}  // namespace crowdbench::studies
