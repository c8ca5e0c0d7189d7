// Rank tests of two samples and of pairs: they ask nothing of the shape of a distribution, so that the hitches of frame
// times cannot decide a verdict. Pure functions: the same numbers in give the same numbers out.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

namespace crowdbench {

// How a p value is read from the rank sum.
enum class RankLaw {
  automatic,          // exact where that takes no more than some hundredths of a second, else normal_continuity
  exact,              // every assignment of the pooled ranks, equal values at the mean of theirs (midranks)
  normal,             // the normal approximation, its variance corrected for ties
  normal_continuity,  // the same, moved by half a step towards the mean
};

struct RankTest {
  double statistic = 0;     // U of x, or V (see below)
  double p_less = 1;        // that the statistic is this small or smaller where nothing differs
  double p_greater = 1;     // this large or larger
  double p_two_sided = 1;   // twice the smaller of the two, at most 1
  bool exact = false;       // by the exact law
  bool degenerate = false;  // all values equal (all differences 0): every p is 1 and nothing was tested
  size_t informative = 0;   // values (pairs, without those that differ by 0) that the statistic is made of
};

// Mann and Whitney's test of x against y. statistic: U of x, the pairs (x, y) with x above y, and half of those that
// are equal. Small p_less: x tends to be the smaller. Both: at least one value, all finite.
RankTest mann_whitney(std::span<const double> x, std::span<const double> y, RankLaw law = RankLaw::automatic);

// What becomes of pairs that do not differ.
enum class ZeroRule {
  drop,   // left out before ranking (Wilcoxon 1945)
  pratt,  // ranked with the others, then left out (Pratt 1959)
};
// Wilcoxon's signed rank test of x - y. statistic: V, the sum of the ranks of the positive differences by their size.
// Differences of decimals lose ties to rounding (3.2 - 2.9 is not 2.3 - 2.0): give whole units where ties matter.
// differences: at least one, all finite.
RankTest wilcoxon_signed_rank(std::span<const double> differences, ZeroRule zeros = ZeroRule::drop,
                              RankLaw law = RankLaw::automatic);

// Brunner and Munzel's test of P(x < y) + P(x = y) / 2 = 1/2: like Mann and Whitney's, but its level holds where the
// spreads of x and y differ. std::nullopt: fewer than two values in one of them, or no variance (no value of one lies
// among those of the other, or all are equal), where the statistic is not defined.
struct BrunnerMunzel {
  double statistic = 0;    // positive where y tends to be the larger
  double df = 0;           // Satterthwaite's degrees of freedom
  double p_two_sided = 1;  // by Student's t
  double probability = 0;  // P(x < y) + P(x = y) / 2
};
std::optional<BrunnerMunzel> brunner_munzel(std::span<const double> x, std::span<const double> y);

}  // namespace crowdbench
