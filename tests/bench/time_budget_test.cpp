#include "bench/experiments/time_budget.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace crowdbench::bench
