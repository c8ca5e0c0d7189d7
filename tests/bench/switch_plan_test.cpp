#include "bench/experiments/switch_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "core/random.h"

namespace crowdbench::bench {
namespace {

bool every_change(size_t, size_t, size_t) { return true; }

// Three candidates, four bins from near to far: the reference, allowed everywhere; a middle one; a cheap one.
SwitchTable three_by_four() {
  return {.cost = {{10, 10, 10, 10}, {6, 5, 4, 4}, {3, 2, 1, 1}},
          .error = {{0, 0, 0, 0}, {4, 2, 1, 0.5}, {9, 6, 3, 1}},
          .allowed = {{1, 1, 1, 1}, {0, 1, 1, 1}, {0, 0, 0, 1}},
          .agents = {1, 2, 10, 100}};
}

TEST(SwitchPlan, TakesTheCheapestThatIsAllowedInEachBin) {
  const auto plan = cheapest_plan(three_by_four(), every_change);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->candidate, (std::vector<size_t>{0, 1, 1, 2}));
  EXPECT_DOUBLE_EQ(plan->cost, 10 + 2 * 5 + 10 * 4 + 100 * 1);
  EXPECT_DOUBLE_EQ(plan->error, 0 + 2 * 2 + 10 * 1 + 100 * 1);
  const auto changes = switches_of(*plan);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[1].from, 1U);
  EXPECT_EQ(changes[1].to, 2U);
  EXPECT_EQ(changes[1].bin, 3U);
}

TEST(SwitchPlan, AChangeThatShowsIsMadeElsewhereOrNotAtAll) {
  // From the reference to the middle one shows in the nearest bin where it could be.
  const auto later = cheapest_plan(
      three_by_four(), [](size_t from, size_t to, size_t bin) { return !(from == 0 && to == 1 && bin == 1); });
  EXPECT_EQ(later->candidate, (std::vector<size_t>{0, 0, 1, 2}));
  const auto never = cheapest_plan(three_by_four(), [](size_t, size_t, size_t) { return false; });
  EXPECT_EQ(never->candidate, (std::vector<size_t>{0, 0, 0, 0}));
}

TEST(SwitchPlan, AsksOnlyOfChangesOnItsWayAndOfEachOnce) {
  std::set<std::tuple<size_t, size_t, size_t>> asked;
  cheapest_plan(three_by_four(), [&](size_t from, size_t to, size_t bin) {
    EXPECT_TRUE(asked.emplace(from, to, bin).second);
    return true;
  });
  EXPECT_EQ(asked.size(), 2U);
}

TEST(SwitchPlan, ABinWithoutAgentsIsDecidedByWhatOneWouldCost) {
  SwitchTable table = three_by_four();
  table.agents = {0, 0, 0, 5};
  EXPECT_EQ(cheapest_plan(table, every_change)->candidate, (std::vector<size_t>{0, 1, 1, 2}));
}

TEST(SwitchPlan, NamesTheBinInWhichNothingIsAllowed) {
  SwitchTable table = three_by_four();
  EXPECT_FALSE(first_forbidden_bin(table));
  table.allowed[0][2] = table.allowed[1][2] = 0;
  EXPECT_EQ(first_forbidden_bin(table), 2U);
  EXPECT_FALSE(cheapest_plan(table, every_change));
}

// Every plan of random tables, one by one.
TEST(SwitchPlan, NoOtherPlanIsBetter) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const auto random = [&](uint64_t i) { return random_unit(seed, i, 1); };
    SwitchTable table;
    for (size_t c = 0; c < 3; ++c) {
      for (auto* rows : {&table.cost, &table.error}) rows->emplace_back();
      table.allowed.emplace_back();
      for (size_t b = 0; b < 5; ++b) {
        table.cost[c].push_back(0.1 + random(100 * c + b));
        table.error[c].push_back(random(1000 + 100 * c + b));
        table.allowed[c].push_back(c == 0 || random(2000 + 100 * c + b) < 0.6);
      }
    }
    for (size_t b = 0; b < 5; ++b) table.agents.push_back(std::floor(10 * random(3000 + b)) + 1);
    const auto change = [&](size_t from, size_t to, size_t bin) {
      return random(4000 + from * 31 + to * 7 + bin) < 0.7;
    };
    double least_cost = 1e9;
    double least_error = 1e9;
    const double budget = 12;
    for (size_t code = 0; code < 243; ++code) {
      size_t rest = code;
      double cost = 0;
      double error = 0;
      bool allowed = true;
      bool smooth = true;
      size_t last = 0;
      for (size_t b = 0; b < 5; ++b, rest /= 3) {
        const size_t c = rest % 3;
        cost += table.agents[b] * table.cost[c][b];
        error += table.agents[b] * table.error[c][b];
        allowed = allowed && table.allowed[c][b];
        smooth = smooth && (b == 0 || c == last || change(last, c, b));
        last = c;
      }
      if (allowed && smooth) least_cost = std::min(least_cost, cost);
      if (smooth && cost <= budget) least_error = std::min(least_error, error);
    }
    EXPECT_NEAR(cheapest_plan(table, change)->cost, least_cost, 1e-9) << seed;
    const auto within = plan_within_budget(table, budget, change);
    EXPECT_EQ(within.has_value(), least_error < 1e9) << seed;
    if (!within) continue;
    EXPECT_LE(within->plan.cost, budget) << seed;
    EXPECT_LE(within->bound, least_error + 1e-9) << seed;
    EXPECT_GE(within->plan.error, least_error - 1e-9) << seed;
  }
}

TEST(SwitchPlan, CertaintyCountsTheResamplesThatAgree) {
  const std::vector<double> heights{100, 50, 25, 12};
  const auto plan = [](std::vector<size_t> path) { return std::optional(SwitchPlan{std::move(path), 0, 0}); };
  std::vector<std::optional<SwitchPlan>> resampled(96, plan({0, 0, 1, 1}));
  for (int i = 0; i < 3; ++i) resampled.push_back(plan({0, 0, 0, 0}));
  resampled.push_back(std::nullopt);
  const SwitchCertainty sure = certainty_of({0, 1, 2}, resampled, heights);
  EXPECT_DOUBLE_EQ(sure.share, 0.96);
  EXPECT_TRUE(sure.decided());
  EXPECT_DOUBLE_EQ(sure.height_px->low, 25);
  EXPECT_DOUBLE_EQ(sure.height_px->high, 25);
  resampled.push_back(std::nullopt);
  resampled.push_back(std::nullopt);
  EXPECT_FALSE(certainty_of({0, 1, 2}, resampled, heights).decided());
  EXPECT_FALSE(certainty_of({1, 2, 3}, resampled, heights).height_px);
}

}  // namespace
}  // namespace crowdbench::bench
