// The block bootstrap: where it is the plain one, and its coverage on autocorrelated values.
#include "core/block_bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "core/probability.h"
#include "core/random.h"

namespace crowdbench {
namespace {

using Numbers = std::vector<double>;

// A first-order autoregression of normal values with median 0 and variance 1, as it is after a long time.
Numbers autoregression(size_t n, double correlation, uint64_t seed) {
  Numbers values(n);
  const auto normal = [&](size_t i) { return normal_quantile(random_unit(seed, i, 0x6172) * (1 - 1e-12) + 5e-13); };
  const double fresh = std::sqrt(1 - correlation * correlation);
  values[0] = normal(0);
  for (size_t i = 1; i < n; ++i) values[i] = correlation * values[i - 1] + fresh * normal(i);
  return values;
}

struct Coverage {
  double blocks = 0;
  double independent = 0;
};
// The share of intervals that hold the true median, of `runs` series.
Coverage coverage_of(size_t n, double correlation, size_t runs, size_t resamples) {
  size_t by_blocks = 0;
  size_t by_values = 0;
  for (size_t run = 0; run < runs; ++run) {
    const Numbers values = autoregression(n, correlation, run + 1);
    const auto holds = [](const Interval& interval) { return interval.low <= 0 && interval.high >= 0 ? 1U : 0U; };
    by_blocks += holds(block_bootstrap_median(values, 1, 0.95, resamples));
    by_values += holds(bootstrap_median(values, 1, 0.95, resamples));
  }
  const auto share = [runs](size_t count) { return static_cast<double>(count) / static_cast<double>(runs); };
  return {share(by_blocks), share(by_values)};
}

TEST(BlockBootstrap, SerialCorrelationByHand) {
  // Ranks 1 to 5: deviations -2 .. 2, products 2, 0, 0, 2 over squares 10; 0.4 and the correction (1 + 1.6) / 5.
  EXPECT_NEAR(serial_correlation(Numbers{1, 2, 3, 4, 5}), 0.4 + 2.6 / 5, 1e-15);
  EXPECT_EQ(serial_correlation(Numbers{1, 2, 3}), 0);
  EXPECT_EQ(serial_correlation(Numbers{7, 7, 7, 7, 7}), 0);
  EXPECT_LT(serial_correlation(Numbers{1, 9, 2, 8, 3, 7, 4, 6}), 0);
}

TEST(BlockBootstrap, IsThePlainOneWhereNothingIsCorrelated) {
  const Numbers values = autoregression(60, 0, 5);
  EXPECT_EQ(block_length(values), 1U);
  const Interval a = block_bootstrap_median(values, 3);
  const Interval b = bootstrap_median(values, 3);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_EQ(block_length(Numbers{4}), 1U);
  EXPECT_EQ(serial_inflation(values), 1);
}

TEST(BlockBootstrap, IsAFunctionOfItsSeedAndHoldsTheMedian) {
  const Numbers values = autoregression(80, 0.7, 9);
  EXPECT_GT(block_length(values), 2U);
  EXPECT_LE(block_length(values), 26U);
  const Interval a = block_bootstrap_median(values, 3);
  EXPECT_EQ(a.low, block_bootstrap_median(values, 3).low);
  EXPECT_LT(a.low, median(values));
  EXPECT_GT(a.high, median(values));
}

// Ranks 1 to 5: a correlation of 0.92 by hand above. A p of 2.5 % is a deviate of -1.96; four times the variance halves
// it.
TEST(BlockBootstrap, InflationIsOfTheVariance) {
  EXPECT_NEAR(serial_inflation(Numbers{1, 2, 3, 4, 5}), 1.92 / 0.08, 1e-9);
  EXPECT_EQ(serial_inflation(Numbers{1, 9, 2, 8, 3, 7, 4, 6}), 1) << "never below 1";
  EXPECT_NEAR(inflated_p(normal_cdf(-1.96), 4), normal_cdf(-0.98), 1e-12);
  EXPECT_EQ(inflated_p(0.01, 1), 0.01);
  EXPECT_EQ(inflated_p(0, 4), 0);
}

// At 95 % and a correlation of 0.6 from one round to the next the plain bootstrap holds the median in two of three
// runs. CROWDBENCH_LONG_FORM=1 (tools/statistics_evidence.sh): a table of many more series.
TEST(BlockBootstrap, KeepsItsCoverageUnderSerialCorrelation) {
  const bool long_form = std::getenv("CROWDBENCH_LONG_FORM") != nullptr;
  const std::vector<size_t> lengths = long_form ? std::vector<size_t>{24, 60, 200} : std::vector<size_t>{100};
  const Numbers correlations = long_form ? Numbers{0, 0.3, 0.6, 0.8} : Numbers{0, 0.6};
  if (long_form) std::cout << "| rounds | correlation | block bootstrap | plain bootstrap |\n|--:|--:|--:|--:|\n";
  for (const size_t n : lengths)
    for (const double correlation : correlations) {
      const Coverage coverage =
          long_form ? coverage_of(n, correlation, 2000, 600) : coverage_of(n, correlation, 300, 300);
      if (long_form)
        std::cout << "| " << n << " | " << correlation << " | " << 100 * coverage.blocks << " % | "
                  << 100 * coverage.independent << " % |\n"
                  << std::flush;
      EXPECT_GE(coverage.blocks, 0.89) << n << ' ' << correlation;
      if (correlation >= 0.6) {
        EXPECT_LT(coverage.independent, 0.8) << "the plain one is too narrow: " << n;
      }
    }
}

}  // namespace
}  // namespace crowdbench
