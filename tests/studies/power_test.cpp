// What a plan's own design is worth, by simulated studies: widths and shares that go the way they must, and come to
// what is known without simulation.
#include "studies/analysis/power.h"

#include <gtest/gtest.h>

#include <cmath>

#include "studies/analysis/equivalence.h"

namespace crowdbench::studies {
namespace {

ThresholdPowerSettings falling_levels() {
  ThresholdPowerSettings s;
  s.observers = {.threshold = 12, .slope = -0.6, .threshold_sd = 1, .guess = 0.5};
  s.design = {.participants = 10, .levels = {4, 8, 12, 16, 20}, .clips = 1, .repeats = 6};
  s.analysis.curve.falling = true;
  s.simulations = 16;
  return s;
}

TEST(ThresholdPower, TheTruthIsWhereTheLevelIsReached) {
  ThresholdPowerSettings s = falling_levels();
  EXPECT_DOUBLE_EQ(true_threshold(s), 12) << "three quarters right: half seen, half of the rest guessed";
  s.analysis.curve.level = 0.9;
  EXPECT_NEAR(true_threshold(s), 12 - std::log(4) / 0.6, 1e-12) << "eight of ten seen";
}

TEST(ThresholdPower, IntervalsHoldTheTruthAndNarrowWithParticipants) {
  ThresholdPowerSettings s = falling_levels();
  const ThresholdPower few = simulate_threshold_power(s);
  EXPECT_EQ(few.closed + few.open + few.failed, s.simulations);
  EXPECT_GE(few.closed, 14U);
  EXPECT_NEAR(few.mean_estimate, 12, 0.8);
  EXPECT_GE(few.held, 0.75) << "fewer than 12 of 16 at 95 %: one of 10,000 runs";
  s.threads = 1;
  EXPECT_EQ(simulate_threshold_power(s).median_width, few.median_width) << "whatever the number of threads";
  s.design.participants = 40;
  const ThresholdPower many = simulate_threshold_power(s);
  EXPECT_NEAR(many.median_width / few.median_width, 0.5, 0.15) << "four times as many";
}

TEST(EquivalencePower, IsSaidOfEqualsAndSeldomAtTheMargin) {
  EquivalencePowerSettings s{.participants = 36, .trials = 12, .equivalence = {.margin = 0.1}, .simulations = 100};
  const EquivalencePower got = simulate_equivalence_power(s);
  const double exact = tost_power(36 * 12, 0.4, 0.6, 0.5, 0.05);
  EXPECT_GT(exact, 0.98);
  EXPECT_GT(got.power, 0.9) << "the test of participants is asked for, too";
  EXPECT_LE(got.at_margin, 0.05 + 3.3 * std::sqrt(0.05 * 0.95 / 100));
  s.trials = 2;
  EXPECT_LT(simulate_equivalence_power(s).power, 0.2) << "72 trials are too few";
}

}  // namespace
}  // namespace crowdbench::studies
