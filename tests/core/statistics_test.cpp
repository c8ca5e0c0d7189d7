#include "core/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/random.h"

namespace crowdbench {
namespace {

TEST(Statistics, QuantilesInterpolateBetweenOrderStatistics) {
  // Positions (n - 1) q on 1, 2, 4, 8: 0 -> 1; 0.75 -> 1.75; 1.5 -> 3; 2.85 -> 7.4; 3 -> 8.
  const std::array<double, 4> values{8, 1, 4, 2};
  EXPECT_DOUBLE_EQ(quantile(values, 0), 1);
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(quantile(values, 0.5), 3);
  EXPECT_DOUBLE_EQ(quantile(values, 0.95), 7.4);
  EXPECT_DOUBLE_EQ(quantile(values, 1), 8);
  EXPECT_DOUBLE_EQ(median(values), 3);
  EXPECT_DOUBLE_EQ(median(std::array{5.0, 1.0, 9.0}), 5);
  EXPECT_DOUBLE_EQ(median(std::array{7.0}), 7);
  EXPECT_DOUBLE_EQ(quantile(std::array{7.0}, 0.99), 7);
}

TEST(Statistics, SummaryOfTwoHundredFrames) {
  // 1 ms .. 200 ms: the slowest 1 % are 199 and 200 ms, mean 199.5 ms.
  std::vector<double> times(200);
  for (size_t i = 0; i < times.size(); ++i) times[i] = 1e6 * static_cast<double>(200 - i);
  const Summary s = summarise(times);
  EXPECT_EQ(s.count, 200U);
  EXPECT_DOUBLE_EQ(s.median, 100.5e6);
  EXPECT_DOUBLE_EQ(s.p05, 10.95e6);  // position 9.95
  EXPECT_DOUBLE_EQ(s.p95, 190.05e6);
  EXPECT_DOUBLE_EQ(s.p99, 198.01e6);
  EXPECT_DOUBLE_EQ(s.low_1_percent_fps, 1e3 / 199.5);
  EXPECT_DOUBLE_EQ(summarise(std::array{2e6}).low_1_percent_fps, 500);
}

TEST(Statistics, MedianOfRatiosPairsByTurn) {
  // The medians of the two series are equal (2); the ratios by turn are 2, 1/2, 3: drift must not be averaged away.
  const MedianRatio r = median_of_ratios(std::array{2.0, 1.0, 6.0}, std::array{1.0, 2.0, 2.0}, 1);
  EXPECT_DOUBLE_EQ(r.median, 2);
  EXPECT_EQ(r.pairs, 3U);
  // A median of three is at its least value with probability 7/27: both ends of the interval are the extremes.
  EXPECT_DOUBLE_EQ(r.interval.low, 0.5);
  EXPECT_DOUBLE_EQ(r.interval.high, 3);
}

TEST(Statistics, EqualRatiosHaveAnIntervalOfNoWidth) {
  const MedianRatio r = median_of_ratios(std::array{4.0, 6.0, 8.0}, std::array{2.0, 3.0, 4.0}, 9);
  EXPECT_DOUBLE_EQ(r.median, 2);
  EXPECT_DOUBLE_EQ(r.interval.low, 2);
  EXPECT_DOUBLE_EQ(r.interval.high, 2);
}

TEST(Statistics, BootstrapIsAFunctionOfItsSeed) {
  std::vector<double> values(21);
  for (size_t i = 0; i < values.size(); ++i) values[i] = random_unit(5, i, 1);
  const Interval a = bootstrap_median(values, 1);
  const Interval b = bootstrap_median(values, 1);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_LT(a.low, median(values));
  EXPECT_GT(a.high, median(values));
  // 90 % lies within 95 %.
  const Interval narrow = bootstrap_median(values, 1, 0.90);
  EXPECT_LE(a.low, narrow.low);
  EXPECT_GE(a.high, narrow.high);
}

// Of 11 values the median of a resample is at most the k-th smallest with the probability that at least 6 of 11 draws
// hit the k smallest: binomial, k/11 each. That is 0.0072 for k = 2 and 0.0512 for k = 3, so the 2.5 % quantile of the
// medians is the 3rd value, and by symmetry the 97.5 % quantile the 9th.
TEST(Statistics, BootstrapOfElevenValuesIsTheThirdAndTheNinth) {
  std::vector<double> values(11);
  std::iota(values.begin(), values.end(), 1.0);
  const Interval interval = bootstrap_median(values, 3);
  EXPECT_DOUBLE_EQ(interval.low, 3);
  EXPECT_DOUBLE_EQ(interval.high, 9);
}

// The true median lies in the 95 % interval about 95 times in a hundred, for a skewed distribution as well (log-normal,
// as frame times are), at the smallest number of pairs that `ratio` takes.
TEST(Statistics, BootstrapIntervalCoversTheTruth) {
  constexpr size_t kSets = 500;
  constexpr size_t kPairs = 20;
  size_t covered = 0;
  for (size_t set = 0; set < kSets; ++set) {
    std::vector<double> values(kPairs);
    for (size_t i = 0; i < kPairs; ++i) {
      double normal = -6;
      for (uint64_t k = 0; k < 12; ++k) normal += random_unit(77, set * kPairs + i, 100 + k);
      values[i] = 3 * std::exp(0.3 * normal);  // median 3
    }
    const Interval interval = bootstrap_median(values, set, 0.95, 2000);
    if (interval.low <= 3 && 3 <= interval.high) ++covered;
  }
  EXPECT_GE(covered, kSets * 92 / 100);
  EXPECT_LE(covered, kSets * 98 / 100);
  RecordProperty("covered", static_cast<int>(covered));
}

TEST(Crossovers, PowerLawsCrossWhereAlgebraSays) {
  // x^1 and 100 x^(1/3) meet at x = 1000. Points of the curves are elsewhere.
  Curve a;
  Curve b;
  for (const double x : {1.0, 10.0, 1e4, 1e5}) {
    a.x.push_back(x);
    a.y.push_back(x);
  }
  for (const double x : {2.0, 300.0, 5e4}) {
    b.x.push_back(x);
    b.y.push_back(100 * std::cbrt(x));
  }
  const auto found = crossovers(a, b);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].x, 1000, 1e-8);
  EXPECT_NEAR(found[0].y, 1000, 1e-8);
  EXPECT_FALSE(found[0].first_is_below_after);
  const auto swapped = crossovers(b, a);
  ASSERT_EQ(swapped.size(), 1U);
  EXPECT_TRUE(swapped[0].first_is_below_after);
}

TEST(Crossovers, FindsEachChangeOfOrderOnce) {
  const Curve flat{{1, 2, 4, 8, 16}, {5, 5, 5, 5, 5}};
  // Below, touching at a knot and below again, above, equal over a knot and then below.
  const Curve wavy{{1, 2, 4, 8, 16}, {4, 5, 4, 6.25, 4}};
  const auto found = crossovers(wavy, flat);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].x, std::sqrt(4.0 * 8.0), 1e-12);  // log 4/5 and log 6.25/5 are opposite: half way
  EXPECT_FALSE(found[0].first_is_below_after);
  EXPECT_NEAR(found[1].x, std::sqrt(8.0 * 16.0), 1e-12);
  EXPECT_TRUE(found[1].first_is_below_after);
  const auto at_knot = crossovers(Curve{{1, 2, 4}, {1, 5, 9}}, Curve{{1, 2, 4}, {5, 5, 5}});
  ASSERT_EQ(at_knot.size(), 1U);
  EXPECT_NEAR(at_knot[0].x, 2, 1e-12);
}

TEST(Crossovers, NoneWhereTheRangesDoNotMeetOrNothingIsMeasured) {
  EXPECT_TRUE(crossovers({{1, 2}, {1, 2}}, {{3, 4}, {1, 2}}).empty());
  EXPECT_TRUE(crossovers({}, {{3, 4}, {1, 2}}).empty());
  EXPECT_TRUE(crossovers({{1, 10}, {1, 1}}, {{1, 10}, {2, 2}}).empty());
  EXPECT_TRUE(crossovers({{5}, {1}}, {{5}, {2}}).empty());
}

}  // namespace
}  // namespace crowdbench
