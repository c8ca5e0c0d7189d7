#include "core/float_traps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace crowdbench {
namespace {

// Not known when compiled.
volatile double zero = 0;
volatile double infinite = std::numeric_limits<double>::infinity();

// Each run by a thread of parallel_for, which begins as its maker is, in a process that it ends.
TEST(FloatTrapsDeathTest, InvalidOperationsAndDivisionsByZeroEndWork) {
  if (!float_traps_work()) GTEST_SKIP() << "this build does not trap: only sanitizer builds do";
  const auto work = [](auto fault) {
    const FloatTraps traps;
    parallel_for(4, 2, [&](size_t) { zero = fault(); });
  };
  EXPECT_DEATH(work([] { return 1 / zero; }), "");
  EXPECT_DEATH(work([] { return zero / zero; }), "");
  EXPECT_DEATH(work([] { return infinite - infinite; }), "");
  EXPECT_DEATH(work([] { return static_cast<double>(static_cast<int>(infinite)); }), "");
}

TEST(FloatTraps, WhatIsMeantAndWhatWasGivenGoesOn) {
  const FloatTraps traps;
  double made = 0;
  {
    const FloatFaultsMeant meant;
    made = zero / zero;
  }
  EXPECT_TRUE(std::isnan(made));
  EXPECT_TRUE(std::isnan(made + 1)) << "a NaN is carried on";
  EXPECT_FALSE(made < 1);
  EXPECT_EQ(infinite + 1, infinite);
  EXPECT_EQ(std::numeric_limits<double>::max() * 2, infinite) << "overflow is not trapped";
}

}  // namespace
}  // namespace crowdbench
