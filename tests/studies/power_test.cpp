// What a plan's own design is worth, by simulated studies: widths and shares that go the way they must, and come to
// what is known without simulation.
#include "studies/analysis/power.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>

#include "core/probability.h"
#include "core/progress.h"
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
  const double expected = 0.5 * student_t_quantile(0.975, 39) / student_t_quantile(0.975, 9);
  EXPECT_NEAR(many.median_width / few.median_width, expected, 0.15) << "four times as many";
}

// By participants, so that rows of more of them count for as much as they take.
TEST(Power, SaysHowFarItIs) {
  const auto said = [](size_t total, const auto& simulate) {
    std::string lines;
    int64_t seconds = 0;
    ProgressBoard board({.write = [&](std::string_view text) { lines += text; },
                         .now = [&] { return std::chrono::seconds(seconds += 11); }});
    Progress progress("simulated participants", total, board);
    simulate(&progress);
    return lines;
  };
  const std::string one = said(240, [](Progress* progress) {
    simulate_power({.participants = 12, .clips = 2, .simulations = 10, .threads = 1, .progress = progress});
  });
  EXPECT_NE(one.find("simulated participants: 12/240, "), std::string::npos) << one;
  EXPECT_NE(one.find(" left"), std::string::npos) << one;
  EXPECT_NE(one.find("simulated participants: 120/240, "), std::string::npos) << one;
  EXPECT_EQ(one.find("132/"), std::string::npos) << one;
  ThresholdPowerSettings threshold = falling_levels();
  threshold.simulations = 2;
  EXPECT_NE(said(20,
                 [&](Progress* progress) {
                   threshold.progress = progress;
                   simulate_threshold_power(threshold);
                 })
                .find("20/20"),
            std::string::npos);
  EXPECT_NE(said(72,
                 [](Progress* progress) {
                   simulate_equivalence_power({.participants = 36, .simulations = 2, .progress = progress});
                 })
                .find("72/72"),
            std::string::npos);
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
