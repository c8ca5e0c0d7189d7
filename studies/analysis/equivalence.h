// Whether nobody can tell: two one-sided tests that a share of answers lies within a margin of chance, what sample they
// need, and the verdict in one of three words. A test that finds no difference has not found equality; this one can.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/statistics.h"

namespace crowdbench::studies {

// Two one-sided tests (Schuirmann 1987) of "the share is `low` or less" and "it is `upp` or more". Equivalent at level
// alpha where p, the larger of the two, is at most alpha: the same as the 1 - 2 alpha interval lying inside.
struct Tost {
  double p_low = 1;
  double p_upp = 1;
  double p = 1;
};
// k of n > 0, 0 <= low < upp <= 1. exact: binomial tails. score: normal, with the variance at the limit. wald: normal,
// with the variance of the sample.
Tost tost_exact(uint64_t k, uint64_t n, double low, double upp);
Tost tost_score(uint64_t k, uint64_t n, double low, double upp);
Tost tost_wald(uint64_t k, uint64_t n, double low, double upp);

// The chance that the exact test says "equivalent" of n independent trials of chance p_true.
double tost_power(uint64_t n, double low, double upp, double p_true, double alpha);
// How many independent trials the exact test needs for that power. Exact power saws up and down with n: `first` is the
// smallest n that has it, `always` the one from which on all have it, in the range that is searched.
struct SampleSize {
  std::optional<uint64_t> first, always;
};
SampleSize tost_sample_size(double low, double upp, double p_true, double alpha, double power, uint64_t searched_to,
                            uint64_t searched_from = 1);

// What one participant answered of one condition.
struct Share {
  uint64_t chosen = 0;
  uint64_t of = 0;  // at least 1
};

enum class Verdict { equivalent, different, not_enough_data };
std::string_view verdict_text(Verdict verdict);  // "equivalent", "different", "not enough data"
// How many more; 0 where enough are there, or where no number would be enough.
uint64_t still_needed(const std::optional<uint64_t>& needed, uint64_t have);

struct Equivalence {
  Verdict verdict = Verdict::not_enough_data;
  Tost exact;                          // all trials as if they were independent
  double different_exact = 1;          // two-sided exact p against chance, likewise
  std::optional<Tost> by_participant;  // t tests of the participants' shares: from two participants on
  std::optional<double> different_by_participant;
  double mean = 0;  // of the participants' shares; of all trials where there is one
  std::optional<Interval>
      interval;  // 1 - 2 alpha, of the mean of the participants' shares; no narrower than the trials'
  std::optional<double> participant_sd;  // of their shares
  // What the verdict "equivalent" would take with the power asked for if the truth were chance itself: independent
  // trials by the exact test; participants of as many trials as these had, by t tests with the spread that these have.
  std::optional<uint64_t> trials_needed;
  std::optional<uint64_t> participants_needed;
  uint64_t more_trials = 0;
  uint64_t more_participants = 0;  // by their spread alone; an analysis adds those that `more_trials` takes
};
struct EquivalenceSettings {
  double chance = 0.5;
  double margin = 0.1;  // chance -+ margin within [0, 1]
  double alpha = 0.05;
  double power = 0.8;
};
// shares: one a participant, at least one. A verdict other than "not enough data" needs both tests, the one of trials
// and the one of participants: trials of one participant are alike, so the first alone promises too much, and the
// second alone does so where all shares happen to be equal. A share that differs from chance and still lies within the
// margin is "equivalent": that is what the margin says.
Equivalence judge_equivalence(std::span<const Share> shares, const EquivalenceSettings& settings);

// ---- two conditions

// Two one-sided tests of "the shares k1 / n1 and k2 / n2 differ by `margin` or more", either way; n1, n2 > 0, 0 <
// margin < 1. wald: the variance of the sample. agresti_caffo: likewise with one answer of each kind added to either
// condition (Agresti and Caffo 2000). score: the variance at the limit (Miettinen and Nurminen 1985), whose error of
// the first kind holds at small numbers and near 0 and 1, too.
enum class DifferenceMethod { wald, agresti_caffo, score };
Tost tost_difference(uint64_t k1, uint64_t n1, uint64_t k2, uint64_t n2, double margin, DifferenceMethod method);

// What one participant answered of two conditions; of either `of` may be 0.
struct SharePair {
  Share first, second;
};
struct DifferenceEquivalence {
  Verdict verdict = Verdict::not_enough_data;
  double difference = 0;               // of all shares, first less second
  Tost score;                          // all trials as if they were independent
  double different_score = 1;          // two-sided p of "no difference", likewise
  size_t participants = 0;             // who answered both
  std::optional<Tost> by_participant;  // t tests of their differences: from two on
  std::optional<double> different_by_participant;
  std::optional<Interval> interval;      // 1 - 2 alpha, of the mean difference
  std::optional<double> participant_sd;  // of the differences
  // What "equivalent" would take with the power asked for, were there no difference: independent trials of either
  // condition by the normal approximation, participants by t tests with the spread that these have.
  std::optional<uint64_t> trials_needed;
  std::optional<uint64_t> participants_needed;
  uint64_t more_trials = 0;  // of either condition
  uint64_t more_participants = 0;
};
// pairs: one a participant, or one alone of which nobody knows who it was (`known` false). Either condition has
// answers. Verdicts as judge_equivalence gives them; settings.chance plays no part.
DifferenceEquivalence judge_difference(std::span<const SharePair> pairs, bool known,
                                       const EquivalenceSettings& settings);

}  // namespace crowdbench::studies
