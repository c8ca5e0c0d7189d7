#include "bench/experiments/time_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

namespace crowdbench::bench {
namespace {

TEST(TimeBudget, IsSharedEvenlyByThePointsThatAreLeft) {
  double now = 50;
  TimeBudget budget(100, 5, [&] { return now; });
  EXPECT_DOUBLE_EQ(budget.left(), 100);
  EXPECT_LT(2 * budget.share(1000), 20) << "warm-up and turns together leave room for what else a point needs";
  EXPECT_DOUBLE_EQ(budget.share(3), 3) << "never more than a point may take anyway";
  const double first = budget.share(1000);
  now += 4;  // a quick point leaves the others more
  budget.point_done();
  EXPECT_GT(budget.share(1000), first);
  EXPECT_TRUE(budget.allows(96));
  EXPECT_FALSE(budget.allows(97));
  now += 200;
  EXPECT_EQ(budget.left(), 0);
  EXPECT_FALSE(budget.allows(0));
}

TEST(TimeBudget, WithoutALimitAllowsEverything) {
  TimeBudget budget(0, 2, [] { return 7.0; });
  EXPECT_TRUE(std::isinf(budget.left()));
  EXPECT_TRUE(budget.allows(1e9));
  EXPECT_EQ(budget.share(10), 10);
}

TEST(ExpectedTurn, FollowsTheLineOfTheLastTwo) {
  EXPECT_EQ(expected_turn_s({}, 100), 0);
  const std::vector<Turn> turns = {{1, 0.5}, {10, 0.6}, {100, 1.5}};
  EXPECT_NEAR(expected_turn_s(std::span(turns).first(1), 100), 5, 1e-12) << "between 0.5 and 50";
  EXPECT_NEAR(expected_turn_s(std::span(turns).first(2), 100), 1.6, 1e-12);
  EXPECT_NEAR(expected_turn_s(turns, 1000), 1.5 + 0.01 * 900, 1e-12);
  const std::vector<Turn> falling = {{1, 0.5}, {10, 0.4}};
  EXPECT_EQ(expected_turn_s(falling, 100), 0.4) << "more agents are not taken for faster";
}

TEST(ExpectedTurn, TheFirstOfAnOccupancyGoesByTheOneBefore) {
  const std::vector<Turn> before = {{1, 0.5}, {10, 0.6}, {100, 1.5}, {1000, 90}};
  EXPECT_NEAR(expected_turn_s({}, before, 100), 1.5, 1e-12);
  EXPECT_NEAR(expected_turn_s({}, before, 1), 0.5, 1e-12);
  EXPECT_NEAR(expected_turn_s({}, std::span(before).first(2), 100), 1.6, 1e-12);
  EXPECT_EQ(expected_turn_s({}, std::span(before).subspan(1), 1), 0) << "of more agents alone";
  const std::vector<Turn> turns = {{1, 0.2}};
  EXPECT_NEAR(expected_turn_s(turns, before, 1), 0.2, 1e-12);
}

}  // namespace
}  // namespace crowdbench::bench
