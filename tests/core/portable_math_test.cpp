#include "core/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace crowdbench {
namespace {

TEST(PortableMath, QuarterTurnsAreExact) {
  const double expected[][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  for (int quarter = -8; quarter <= 8; ++quarter) {
    const SinCos value = sincos_turns(quarter * 0.25);
    EXPECT_EQ(value.sin, expected[(quarter + 8) % 4][0]);
    EXPECT_EQ(value.cos, expected[(quarter + 8) % 4][1]);
  }
}

TEST(PortableMath, AgreesWithTheLibraryWithin1e15) {
  // The angle in turns is exact; the library's argument is rounded, so the oracle works in long double.
  const long double turn = 6.283185307179586476925286766559L;
  for (uint64_t i = 0; i < 20'000; ++i) {
    const double turns = 2.0 * random_unit(5, i, 0) - 1.0;
    const SinCos value = sincos_turns(turns);
    EXPECT_LT(std::abs(static_cast<long double>(value.sin) - std::sin(turn * turns)), 1e-15L) << turns;
    EXPECT_LT(std::abs(static_cast<long double>(value.cos) - std::cos(turn * turns)), 1e-15L) << turns;
  }
}

TEST(PortableMath, WholeTurnsDoNotMatter) {
  for (const double turns : {0.125, 0.3, 0.77}) {
    const double far = turns + 1048576.0;  // rounds, and both sides must take the rounded angle
    const SinCos near = sincos_turns(far - 1048576.0);
    const SinCos value = sincos_turns(far);
    EXPECT_EQ(value.sin, near.sin);
    EXPECT_EQ(value.cos, near.cos);
  }
}

TEST(PortableMath, IsPinned) {
  EXPECT_EQ(sincos_turns(1.0 / 12).sin, 0.5 - 0x1p-54);
  EXPECT_NEAR(sincos_turns(0.125).sin, 0.70710678118654752, 1e-16);
}

}  // namespace
}  // namespace crowdbench
