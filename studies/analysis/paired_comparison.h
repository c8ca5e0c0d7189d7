// Which of several things people prefer, from comparisons two at a time: Bradley-Terry worths with ties (Davidson) and
// an effect of position, and a scale in just-objectionable differences (Thurstone's Case V). Where the comparisons do
// not determine one scale, that is the result, and no number stands in its place.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/statistics.h"

namespace crowdbench::studies {

// Answers to one pair of items.
struct Comparison {
  uint32_t a = 0;
  uint32_t b = 0;                  // not a
  std::optional<bool> a_is_first;  // which stood first, where it is known
  uint64_t a_wins = 0;
  uint64_t ties = 0;
  uint64_t b_wins = 0;
};

enum class WorthState {
  fitted,
  no_data,
  disconnected,  // groups of items that were never compared with each other
  unbeaten,      // a group of items that never lost to the rest, nor tied: the distance to it is infinite
  all_ties,      // nobody ever preferred anything
  one_position,  // the item in one position won whenever there was a winner: no finite effect of position
};
std::string_view state_text(WorthState state);

struct Worths {
  WorthState state = WorthState::no_data;
  // The items of each group within which worths can be compared: one group where fitted. Ordered by smallest item;
  // where unbeaten, from the best group to the worst as far as they are ordered.
  std::vector<std::vector<uint32_t>> groups;
  // Logs of the worths, their sum 0, with standard errors; by item.
  std::vector<double> log_worth, se;
  std::vector<std::vector<double>> covariance;  // of them
  std::vector<double> worth;                    // exp(log_worth) over their sum
  // Of the tie parameter; nothing where there were no ties (its estimate is then minus infinity).
  std::optional<double> log_nu, log_nu_se;
  // What standing first adds to the log-worth of an item that wins; nothing where positions were not given.
  std::optional<double> position, position_se;
  double log_likelihood = 0;  // multinomial, without constants
};

// P(a wins) : P(b wins) : P(tie) = exp(w_a + position if a is first) : exp(w_b + position if b is first)
//   : exp(log_nu + (w_a + w_b) / 2)   (Davidson 1970; the position as in Davidson and Beaver 1977).
// comparisons: any order, repeated pairs allowed. with_position: every comparison says who stood first.
Worths fit_worths(std::span<const Comparison> comparisons, size_t items, bool with_position);

// The difference of two log-worths and its standard error.
struct Difference {
  double value = 0;
  double se = 0;
};
Difference difference_of(const Worths& worths, size_t a, size_t b);

// ---- Thurstone's Case V, in JOD: P(i over j) = Phi((q_i - q_j) / 1.4826), so that 1 JOD is 75 %

// wins[i][j]: how often i was chosen over j. A tie is half a win each way before it comes here, or left out.
using Wins = std::vector<std::vector<double>>;

enum class JodPrior {
  none,      // maximum likelihood
  gaussian,  // pwcmp's: pairs that all agree about do not run off to infinity
};
struct Jod {
  WorthState state = WorthState::no_data;  // fitted, no_data, disconnected; unbeaten without a prior
  std::vector<double> q;                   // mean 0
  std::vector<double> se;  // against item 0, of maximum likelihood by the expected information; with a prior empty
  double negative_log_likelihood = 0;  // without the prior and without constants
};
Jod fit_jod(const Wins& wins, JodPrior prior);

// 1 - 2 tail percentile intervals (quantile() of core/statistics.h) of refits to whole observers drawn anew; by item,
// of their distance to the mean. Widened where they miss the estimate. draws: one row a resample, of indices into
// `observers`.
struct JodIntervals {
  std::vector<Interval> q;
  size_t failed = 0;
};
JodIntervals bootstrap_jod(std::span<const Wins> observers, std::span<const std::vector<size_t>> draws, JodPrior prior,
                           double confidence = 0.95);
// n rows of indices below `observers`, by hashes of the seed.
std::vector<std::vector<size_t>> bootstrap_draws(size_t observers, size_t n, uint64_t seed);

// ---- what the two share

// Groups within which every item is reached from every other along "won against or tied with": worths are finite within
// one (Ford 1957). From those that nobody outside beat downwards.
std::vector<std::vector<uint32_t>> comparable_groups(const std::vector<std::vector<bool>>& beat_or_tied);
// Groups of items that are joined by comparisons, whoever won.
std::vector<std::vector<uint32_t>> connected_groups(const std::vector<std::vector<bool>>& compared);

}  // namespace crowdbench::studies
