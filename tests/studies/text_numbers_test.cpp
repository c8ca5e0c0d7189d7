#include "studies/analysis/text_numbers.h"

#include <gtest/gtest.h>

namespace crowdbench::studies::text {
namespace {

TEST(TextNumbers, AreWordedAsByHand) {
  EXPECT_EQ(counted(1, "trial", "trials"), "1 trial");
  EXPECT_EQ(counted(12, "trial", "trials"), "12 trials");
  EXPECT_EQ(named(""), "all");
  EXPECT_EQ(named("near"), "near");
  EXPECT_EQ(percent(29, 100), "29 %");
  EXPECT_EQ(percent(0, 0), "-");
  EXPECT_EQ(p_text(0.0123), "0.012");
  EXPECT_EQ(p_text(0.0001), "< 0.001");
  EXPECT_EQ(number(std::nullopt), "-");
  EXPECT_EQ(number(12.34567), "12.35");
}

}  // namespace
}  // namespace crowdbench::studies::text
