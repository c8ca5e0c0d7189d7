#include "scene/character/alpha_coverage.h"

#include <gtest/gtest.h>

#include <vector>

namespace crowdbench::scene {
namespace {

std::vector<uint8_t> texels_of(const std::vector<uint8_t>& alpha) {
  std::vector<uint8_t> rgba;
  for (const uint8_t a : alpha) rgba.insert(rgba.end(), {1, 2, 3, a});
  return rgba;
}

TEST(AlphaCoverage, ThresholdDividesTheFactorOut) {
  Material material;
  EXPECT_EQ(alpha_threshold(material), 0.0F);
  material.alpha_cutoff = 0.25F;
  material.base_colour.a = 0.5F;
  EXPECT_EQ(alpha_threshold(material), 0.5F);
  material.base_colour.a = 0.0F;
  EXPECT_GT(alpha_threshold(material), 1.0F);
}

TEST(AlphaCoverage, IsTheFractionThatPasses) {
  EXPECT_EQ(alpha_coverage(texels_of({0, 127, 128, 255}), 0.5F), 0.5);
  EXPECT_EQ(alpha_coverage(texels_of({0, 127, 128, 255}), 2.0F), 0.0);
}

// A strand of a quarter of the width averages to 64: nothing would be left at a half.
TEST(AlphaCoverage, ALevelIsScaledToTheCoverageOfTheFirst) {
  std::vector<uint8_t> faint = texels_of({64, 10, 20, 30});
  scale_alpha_to(faint, 0.5F, 0.25);
  EXPECT_EQ(alpha_coverage(faint, 0.5F), 0.25);
  EXPECT_EQ(faint[3], 128);
  EXPECT_EQ(faint[0], 1);
  std::vector<uint8_t> dense = texels_of({250, 240, 230, 140});
  scale_alpha_to(dense, 0.5F, 0.5);
  EXPECT_EQ(alpha_coverage(dense, 0.5F), 0.5);
  std::vector<uint8_t> none = texels_of({250, 240, 230, 140});
  scale_alpha_to(none, 0.5F, 0.0);
  EXPECT_EQ(alpha_coverage(none, 0.5F), 0.0);
}

}  // namespace
}  // namespace crowdbench::scene
