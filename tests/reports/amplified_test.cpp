#include "reports/model/amplified.h"

#include <gtest/gtest.h>

namespace crowdbench::reports {
namespace {

TEST(Amplified, MakesSmallDifferencesBrightAndSaysByHowMuch) {
  Image8 a(10, 10, 4);
  Image8 b = a;
  b.at(3, 4)[0] = 5;
  b.at(3, 4)[3] = 200;  // alpha is no colour
  const auto made = amplified_difference(a, b);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->factor, 32) << "5 times 64 is more than 255";
  EXPECT_EQ(made->largest, 5);
  EXPECT_EQ(made->picture.channels, 3);
  EXPECT_EQ(made->picture.at(3, 4)[0], 160);
  EXPECT_EQ(made->picture.at(3, 4)[1], 0);
  EXPECT_EQ(made->picture.at(4, 4)[0], 0);
}

TEST(Amplified, CutsNoMoreThanOneInAHundredOfWhatDiffers) {
  Image8 a(100, 3, 3);
  Image8 b = a;
  for (uint8_t& value : b.data) value = 10;
  b.data[0] = 255;
  const auto made = amplified_difference(a, b);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->factor, 16) << "one of 900 is cut; twice as much would cut the tens";
  EXPECT_EQ(made->picture.data[0], 255);
  EXPECT_EQ(made->picture.data[1], 160);
  for (size_t i = 0; i < 20; ++i) b.data[i] = 200;
  EXPECT_EQ(amplified_difference(a, b)->factor, 1) << "20 of 900 would be cut";
}

TEST(Amplified, IsNothingOfEqualOrUnlikePictures) {
  const Image8 a(4, 4, 3);
  EXPECT_FALSE(amplified_difference(a, a));
  EXPECT_FALSE(amplified_difference(a, Image8(4, 5, 3)));
  EXPECT_FALSE(amplified_difference(a, Image8(4, 4, 4)));
  EXPECT_FALSE(amplified_difference(Image8(4, 4, 1), Image8(4, 4, 1)));
}

}  // namespace
}  // namespace crowdbench::reports
