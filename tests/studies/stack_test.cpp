#include "studies/stimuli/stack.h"

#include <gtest/gtest.h>

namespace crowdbench::studies {
namespace {

Image8 filled(int width, int height, int channels, uint8_t value) {
  Image8 image(width, height, channels);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<uint8_t>(value + i);
  return image;
}

TEST(Stack, PutsTopBarAndBottomInPlace) {
  // 2x1, RGBA above RGB, a bar of two rows: worked out by hand. Alpha (values 13, 17) is left out.
  const Image8 top = filled(2, 1, 4, 10);
  const Image8 bottom = filled(2, 1, 3, 100);
  const Image8 out = stack_vertically(top, bottom, {2, {1, 2, 3}});
  ASSERT_EQ(out.width, 2);
  ASSERT_EQ(out.height, 4);
  ASSERT_EQ(out.channels, 3);
  const std::vector<uint8_t> expected = {10,  11,  12,  14,  15,  16,           // top
                                         1,   2,   3,   1,   2,   3,  1, 2, 3,  // bar
                                         1,   2,   3,                           //
                                         100, 101, 102, 103, 104, 105};
  EXPECT_EQ(out.data, expected);
}

TEST(Stack, OddWidthGainsAColumnOfTheBarsColour) {
  const Image8 half = filled(3, 5, 3, 50);
  const Image8 out = stack_vertically(half, half, {4, {9, 8, 7}});
  ASSERT_EQ(out.width, 4);
  ASSERT_EQ(out.height, 14);
  for (int y = 0; y < out.height; ++y) {
    EXPECT_EQ(out.at(3, y)[0], 9);
    EXPECT_EQ(out.at(3, y)[2], 7);
  }
  EXPECT_EQ(out.at(2, 4)[1], half.at(2, 4)[1]);
  EXPECT_EQ(out.at(2, 13)[1], half.at(2, 4)[1]);
}

TEST(Stack, EveryStackHasEvenSides) {
  for (int width = 1; width < 5; ++width) {
    for (int height = 1; height < 5; ++height) {
      const StackSize size = stack_size(width, height);
      EXPECT_EQ(size.width % 2, 0);
      EXPECT_EQ(size.height % 2, 0);
      EXPECT_GE(size.width, width);
      EXPECT_EQ(size.height, 2 * height + 8);
    }
  }
}

TEST(Side, IsPinnedAndFair) {
  // A change of these changes which half of every published clip is which.
  std::string first_sixteen;
  for (uint64_t seed = 1; seed <= 16; ++seed) first_sixteen += first_on_top(seed) ? 'A' : 'B';
  EXPECT_EQ(first_sixteen, "BABBABAAABABAABA");
  // 1,000 fair coins: 500 +- 5 standard deviations of 15.8.
  int tops = 0;
  for (uint64_t pair = 0; pair < 1000; ++pair) tops += first_on_top(7, pair);
  EXPECT_NEAR(tops, 500, 79);
}

}  // namespace
}  // namespace crowdbench::studies
