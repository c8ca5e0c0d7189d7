// Motion maps worked by hand: squares in front of a view that looks along -z.
#include "renderers/flat/flat_motion.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace crowdbench::renderers {
namespace {

// A square of metres [x, x + side] by [y, y + side] at height z, two triangles.
void add_square(std::vector<glm::vec3>& positions, float x, float y, float side, float z) {
  for (const auto& [i, j] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{0, 1}, std::pair{1, 1}})
    positions.emplace_back(x + side * static_cast<float>(i), y + side * static_cast<float>(j), z);
}
std::vector<uint32_t> square_indices(uint32_t squares) {
  std::vector<uint32_t> out;
  for (uint32_t s = 0; s < squares; ++s)
    for (const uint32_t i : {0U, 1U, 2U, 2U, 1U, 3U}) out.push_back(4 * s + i);
  return out;
}
// Texels of a tenth of a metre.
const MotionLattice kLattice{glm::dvec3(0.0), {}, 0.1};

Motion motion_of(const std::vector<uint8_t>& texels, const TileRect& rect, int x, int y, bool later) {
  const size_t at =
      4 * (static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x - rect.x)) +
      (later ? 2 : 0);
  return decode_motion(texels[at], texels[at + 1], 0.63);
}

TEST(FlatMotion, ASurfaceIsWhatLiesNearestAtATexelsMiddle) {
  std::vector<glm::vec3> positions;
  add_square(positions, 0, 0, 0.4F, 0);
  add_square(positions, 0.2F, 0, 0.2F, 0.5F);
  const ShownSurface shown = shown_surface(positions, square_indices(2), kLattice);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      ASSERT_TRUE(shown.covers(x, y)) << x << ", " << y;
      const size_t at = static_cast<size_t>(y - shown.rect.y) * static_cast<size_t>(shown.rect.width) +
                        static_cast<size_t>(x - shown.rect.x);
      const bool front = x >= 2 && y < 2;
      EXPECT_EQ(shown.triangle[at] / 2, front ? 1 : 0);
      EXPECT_FLOAT_EQ(shown.depth[at], front ? 0.5F : 0.0F);
    }
  EXPECT_FALSE(shown.covers(-1, 0));
  EXPECT_FALSE(shown.covers(4, 0));
  EXPECT_FALSE(shown.covers(1000, 1000));
}

// A square that goes to the right by unequal steps and up: texels say how far back and how far on, and those beside it
// say the same.
TEST(FlatMotion, TexelsLeadToBothFrames) {
  std::vector<glm::vec3> earlier, half_way, later;
  add_square(earlier, 0, 0, 0.4F, 0);
  add_square(half_way, 0.2F, 0.1F, 0.4F, 0);
  add_square(later, 0.5F, 0.3F, 0.4F, 0);
  const std::vector<uint32_t> indices = square_indices(1);
  const TileRect rect{-3, -2, 14, 12};
  const auto texels = motion_texels({earlier, half_way, later, indices}, kLattice, rect, 0.63);
  ASSERT_EQ(texels.size(), 14U * 12 * 4);
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      const Motion back = motion_of(texels, rect, x, y, false);
      const Motion on = motion_of(texels, rect, x, y, true);
      EXPECT_NEAR(back.metres.x, -0.2, 0.006);
      EXPECT_NEAR(back.metres.y, -0.1, 0.003);
      EXPECT_NEAR(on.metres.x, 0.3, 0.006);
      EXPECT_NEAR(on.metres.y, 0.2, 0.003);
      // The square is at 2 to 6 by 1 to 5; beyond its neighbours there is nothing.
      const bool air = x < 1 || x > 6 || y < 0 || y > 5;
      EXPECT_EQ(back.hidden, air) << x << ", " << y;
      EXPECT_EQ(on.hidden, air) << x << ", " << y;
    }
}

// A small square passes in front of a large one that stands still: what it uncovers was hidden before, what it will
// cover is hidden afterwards, and it is never hidden itself.
TEST(FlatMotion, WhatIsInFrontHidesWhatIsBehindInThatFrame) {
  std::vector<glm::vec3> earlier, half_way, later;
  for (auto* poses : {&earlier, &half_way, &later}) add_square(*poses, 0, 0, 1.2F, 0);
  add_square(earlier, 0, 0, 0.4F, 0.5F);
  add_square(half_way, 0.4F, 0, 0.4F, 0.5F);
  add_square(later, 0.8F, 0, 0.4F, 0.5F);
  const TileRect rect{0, 0, 12, 12};
  const auto texels = motion_texels({earlier, half_way, later, square_indices(2)}, kLattice, rect, 0.63);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) {
      const bool low = y < 4;
      const Motion back = motion_of(texels, rect, x, y, false);
      const Motion on = motion_of(texels, rect, x, y, true);
      const bool moving = low && x >= 4 && x < 8;
      EXPECT_NEAR(back.metres.x, moving ? -0.4 : 0, 0.006) << x << ", " << y;
      EXPECT_EQ(back.hidden, low && x < 4) << x << ", " << y;
      EXPECT_EQ(on.hidden, low && x >= 8) << x << ", " << y;
    }
}

TEST(FlatMotion, NothingShownSaysNothing) {
  const std::vector<glm::vec3> point(4, glm::vec3(0.0F));
  const auto texels = motion_texels({point, point, point, square_indices(1)}, kLattice, {-1, -1, 2, 2}, 0.63);
  for (size_t i = 0; i < texels.size(); i += 2) {
    const Motion none = decode_motion(texels[i], texels[i + 1], 0.63);
    EXPECT_EQ(none.metres, glm::dvec2(0.0));
    EXPECT_TRUE(none.hidden);
  }
  EXPECT_EQ(largest_step(point, point), 0);
  EXPECT_NEAR(largest_step({{0, 0, 0}, {1, 1, 1}}, {{3, 0, 4}, {1, 1, 1}}), 5, 1e-6);
}

}  // namespace
}  // namespace crowdbench::renderers
