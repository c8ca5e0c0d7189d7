// How far two orders of the same things agree: Spearman's and Kendall's rank correlation, ties counted rightly, and
// their bootstrap intervals. Pure functions: the same numbers in give the same numbers out.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/statistics.h"

namespace crowdbench {

// Ranks from 1, equal values at the mean of theirs. Values may be infinite, never NaN.
std::vector<double> ranks_of(std::span<const double> values);

// Both spans: the same length. Between -1 and 1; nothing where there are fewer than two, or all of one span are equal.
// Spearman's rho: Pearson's correlation of the ranks.
std::optional<double> spearman(std::span<const double> a, std::span<const double> b);
// Kendall's tau-b: pairs in the same order less pairs in opposite order, over the geometric mean of the pairs that each
// span puts in an order. In n log n steps.
std::optional<double> kendall_tau_b(std::span<const double> a, std::span<const double> b);

struct RankCorrelation {
  double value = 0;
  Interval interval;  // 95 %
};
struct RankAgreement {
  std::optional<RankCorrelation> spearman, kendall;  // nothing: as above, or every resample is so
  size_t pairs = 0;
  size_t groups = 0;
};
// groups: of each element, whose like are not independent of each other: whole groups are drawn anew, as many as there
// are, by hashes of (seed, resample, draw). One group alone gives an interval of no width, which says nothing: state
// the count beside it. The interval is of percentiles, outwards to values that occur.
constexpr size_t kRankResamples = 1000;
RankAgreement rank_agreement(std::span<const double> a, std::span<const double> b, std::span<const uint32_t> groups,
                             uint64_t seed, size_t resamples = kRankResamples);

}  // namespace crowdbench
