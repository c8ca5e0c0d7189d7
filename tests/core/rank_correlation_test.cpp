#include "core/rank_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"

namespace crowdbench {
namespace {

using Numbers = std::vector<double>;

TEST(RankCorrelation, EqualValuesShareTheMeanOfTheirRanks) {
  EXPECT_EQ(ranks_of(Numbers{30, 10, 20}), (Numbers{3, 1, 2}));
  EXPECT_EQ(ranks_of(Numbers{5, 1, 5, 5}), (Numbers{3, 1, 3, 3})) << "places 2, 3 and 4";
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ranks_of(Numbers{infinity, 1, infinity}), (Numbers{2.5, 1, 2.5}));
  EXPECT_TRUE(ranks_of(Numbers{}).empty());
}

// Ranks 1, 2.5, 2.5, 4 and 1, 3, 2, 4: sums of products 4.5, of squares 4.5 and 5. Five pairs in the same order, none
// in opposite order, one tied in the first.
TEST(RankCorrelation, ByHandWithATieInOne) {
  const Numbers a = {1, 2, 2, 3};
  const Numbers b = {10, 30, 20, 40};
  EXPECT_NEAR(spearman(a, b).value(), 4.5 / std::sqrt(4.5 * 5), 1e-15);
  EXPECT_NEAR(kendall_tau_b(a, b).value(), 5 / std::sqrt(5.0 * 6), 1e-15);
}

// Five things; a ties 1-2 and 4-5, b ties 2-3 and 4-5. Of ten pairs: tied in a {12, 45}, in b {23, 45}, both {45};
// opposite {14, 15, 24, 25, 34, 35}, same {13}. Ranks 1.5 1.5 3 4.5 4.5 and 3 4.5 4.5 1.5 1.5, so that
// deviations are -1.5 -1.5 0 1.5 1.5 and 0 1.5 1.5 -1.5 -1.5.
TEST(RankCorrelation, ByHandWithTiesInBoth) {
  const Numbers a = {1, 1, 2, 3, 3};
  const Numbers b = {5, 6, 6, 4, 4};
  EXPECT_NEAR(spearman(a, b).value(), (-1.5 * 1.5 - 4.5) / std::sqrt(9.0 * 9.0), 1e-15);
  EXPECT_NEAR(kendall_tau_b(a, b).value(), (1 - 6) / std::sqrt(8.0 * 8.0), 1e-15);
}

TEST(RankCorrelation, OrdersThatAgreeAndThatDoNot) {
  const Numbers up = {1, 2, 3, 4, 5, 6};
  const Numbers powers = {1, 10, 100, 1e4, 1e6, std::numeric_limits<double>::infinity()};
  const Numbers down = {6, 5, 4, 3, 2, 1};
  EXPECT_DOUBLE_EQ(spearman(up, powers).value(), 1);
  EXPECT_DOUBLE_EQ(kendall_tau_b(up, powers).value(), 1);
  EXPECT_DOUBLE_EQ(spearman(up, down).value(), -1);
  EXPECT_DOUBLE_EQ(kendall_tau_b(up, down).value(), -1);
}

TEST(RankCorrelation, NothingWhereNothingIsOrdered) {
  EXPECT_FALSE(spearman(Numbers{1, 1, 1}, Numbers{1, 2, 3}));
  EXPECT_FALSE(kendall_tau_b(Numbers{1, 2, 3}, Numbers{4, 4, 4}));
  EXPECT_FALSE(spearman(Numbers{1}, Numbers{2}));
  EXPECT_FALSE(kendall_tau_b(Numbers{}, Numbers{}));
}

// The definition, pair by pair.
double tau_by_pairs(const Numbers& a, const Numbers& b) {
  double difference = 0;
  double ordered_a = 0;
  double ordered_b = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const int s = (a[i] > a[j]) - (a[i] < a[j]);
      const int t = (b[i] > b[j]) - (b[i] < b[j]);
      difference += s * t;
      ordered_a += s * s;
      ordered_b += t * t;
    }
  return difference / std::sqrt(ordered_a * ordered_b);
}

TEST(RankCorrelation, TauIsItsDefinitionForManyTies) {
  for (uint64_t seed = 0; seed < 30; ++seed) {
    Numbers a;
    Numbers b;
    for (uint64_t i = 0; i < 5 + 7 * seed; ++i) {
      a.push_back(static_cast<double>(random_below(seed, i, 1, 2 + seed)));
      b.push_back(a.back() + static_cast<double>(random_below(seed, i, 2, 9)));
    }
    EXPECT_NEAR(kendall_tau_b(a, b).value(), tau_by_pairs(a, b), 1e-12) << seed;
  }
}

TEST(RankCorrelation, IntervalsDrawWholeGroups) {
  Numbers a;
  Numbers b;
  std::vector<uint32_t> each;
  std::vector<uint32_t> one;
  for (uint64_t i = 0; i < 60; ++i) {
    a.push_back(random_unit(1, i, 1));
    b.push_back(a.back() + random_unit(1, i, 2));
    each.push_back(static_cast<uint32_t>(i));
    one.push_back(7);
  }
  const RankAgreement free = rank_agreement(a, b, each, 5);
  EXPECT_EQ(free.pairs, 60U);
  EXPECT_EQ(free.groups, 60U);
  ASSERT_TRUE(free.spearman && free.kendall);
  EXPECT_DOUBLE_EQ(free.spearman->value, spearman(a, b).value());
  EXPECT_LT(free.spearman->interval.low, free.spearman->value - 0.05);
  EXPECT_GT(free.spearman->interval.high, free.spearman->value + 0.02);
  EXPECT_LT(free.kendall->interval.low, free.kendall->value);
  const RankAgreement again = rank_agreement(a, b, each, 5);
  EXPECT_EQ(again.spearman->interval.low, free.spearman->interval.low) << "the same seed";
  EXPECT_NE(rank_agreement(a, b, each, 6).spearman->interval.low, free.spearman->interval.low);
  const RankAgreement together = rank_agreement(a, b, one, 5);
  EXPECT_EQ(together.groups, 1U);
  EXPECT_EQ(together.spearman->interval.low, together.spearman->interval.high);
}

// Without dependence the interval of about 95 of a hundred samples holds 0; with 40 groups a little fewer.
TEST(RankCorrelation, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int held = 0;
  for (uint64_t seed = 0; seed < 100; ++seed) {
    Numbers a;
    Numbers b;
    std::vector<uint32_t> groups;
    for (uint64_t i = 0; i < 40; ++i) {
      a.push_back(random_unit(seed, i, 1));
      b.push_back(random_unit(seed, i, 2));
      groups.push_back(static_cast<uint32_t>(i));
    }
    const Interval interval = rank_agreement(a, b, groups, seed, 200).spearman->interval;
    held += interval.low <= 0 && interval.high >= 0 ? 1 : 0;
  }
  EXPECT_GE(held, 88);
  EXPECT_LE(held, 100);
}

}  // namespace
}  // namespace crowdbench
