#include "core/random.h"

#include <gtest/gtest.h>

namespace crowdbench {
namespace {

constexpr uint64_t kAll = ~uint64_t{0};

// Worked out with arbitrary-precision integers from the definition; a change here changes every crowd.
TEST(Random, BitsArePinned) {
  EXPECT_EQ(mix64(0), 0U);
  EXPECT_EQ(mix64(1), 0x5692161d100b05e5U);
  EXPECT_EQ(random_bits(0, 0, 0), 0x28eb909d7246b6c3U);
  EXPECT_EQ(random_bits(1, 0, 0), 0x6fea8d9b1fddf002U);
  EXPECT_EQ(random_bits(0, 1, 0), 0x1b96049b2eadd697U);
  EXPECT_EQ(random_bits(0, 0, 1), 0xdb4c6a60cbc92fedU);
  EXPECT_EQ(random_bits(kAll, kAll, kAll), 0x94d325947213b286U);
}

TEST(Random, UnitIsTheTopBitsAsAFraction) {
  EXPECT_EQ(random_unit(0, 0, 0), 0.15984443515687974);
  EXPECT_EQ(random_unit(1, 2, 3), 0.7408045888185352);
}

TEST(Random, BelowIsTheHighHalfOfTheProduct) {
  EXPECT_EQ(random_below(0, 0, 0, 10), 1U);
  EXPECT_EQ(random_below(0, 0, 1, 10), 8U);
  EXPECT_EQ(random_below(kAll, kAll, kAll, 10), 5U);
  EXPECT_EQ(random_below(7, 8, 9, 1), 0U);
}

TEST(Random, MeanAndVarianceAreThoseOfAUniformNumber) {
  constexpr int n = 100'000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < n; ++i) {
    const double u = random_unit(3, static_cast<uint64_t>(i), 4);
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  const double mean = sum / n;
  EXPECT_NEAR(mean, 0.5, 5 * 0.2887 / 316.2);  // five standard errors
  EXPECT_NEAR(squares / n - mean * mean, 1.0 / 12, 5 * 0.0745 / 316.2);
}

TEST(Random, SeedsIndicesAndPurposesDoNotCorrelate) {
  // Neighbouring counters must look unrelated: the correlation of n pairs has a standard error of 1 / sqrt(n).
  constexpr int n = 40'000;
  const auto correlation = [](auto a, auto b) {
    double sum = 0;
    for (uint64_t i = 0; i < n; ++i) sum += (a(i) - 0.5) * (b(i) - 0.5);
    return sum / n * 12;
  };
  const auto unit = [](uint64_t seed, uint64_t shift, uint64_t purpose) {
    return [=](uint64_t i) { return random_unit(seed, i + shift, purpose); };
  };
  EXPECT_LT(std::abs(correlation(unit(1, 0, 1), unit(1, 1, 1))), 5.0 / 200);
  EXPECT_LT(std::abs(correlation(unit(1, 0, 1), unit(2, 0, 1))), 5.0 / 200);
  EXPECT_LT(std::abs(correlation(unit(1, 0, 1), unit(1, 0, 2))), 5.0 / 200);
}

}  // namespace
}  // namespace crowdbench
