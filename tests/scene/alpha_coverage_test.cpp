#include "scene/character/alpha_coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
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

AlphaLevel level_of(int width, int height, const std::function<double(int x, int y)>& alpha) {
  AlphaLevel level{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) level.alpha.push_back(static_cast<uint8_t>(std::lround(255 * alpha(x, y))));
  return level;
}

AlphaLevel halved(const AlphaLevel& from) {
  return level_of(from.width / 2, from.height / 2, [&](int x, int y) {
    double sum = 0;
    for (const int at : {0, 1, from.width, from.width + 1})
      sum += from.alpha[static_cast<size_t>(2 * y * from.width + 2 * x + at)];
    return sum / 4 / 255;
  });
}

// Between a solid and a clear texel the edge lies where alpha passes the threshold: half way at 0.5, nearer to the
// clear one below.
TEST(AlphaCoverage, AreaIsAsItIsSampled) {
  const AlphaLevel half = level_of(8, 8, [](int x, int) { return x < 4 ? 1 : 0; });
  const AlphaSampling clamped{true, false, false};
  EXPECT_NEAR(CoverageKeeper(half, 0.5F, clamped, clamped).covered(), 4.0 / 8, 1e-3);
  EXPECT_NEAR(CoverageKeeper(half, 0.25F, clamped, clamped).covered(), 4.25 / 8, 1e-3);
  EXPECT_NEAR(CoverageKeeper(half, 0.25F, {true, true, true}, clamped).covered(), 4.5 / 8, 1e-3) << "both edges";
  EXPECT_NEAR(CoverageKeeper(half, 0.25F, {false, true, true}, clamped).covered(), 4.0 / 8, 1e-9);
  const AlphaLevel lying = level_of(8, 8, [](int, int y) { return y < 4 ? 1 : 0; });
  EXPECT_NEAR(CoverageKeeper(lying, 0.25F, clamped, clamped).covered(), 4.25 / 8, 1e-3);
}

// A thread of one texel in eight is a quarter of a texel's alpha two levels on: it keeps its eighth of the area there,
// and at the level of one grey, which cannot, the levels end.
TEST(AlphaCoverage, LevelsKeepTheAreaUntilTheyCannot) {
  struct Pattern {
    const char* name;
    std::function<double(int, int)> alpha;
    int levels;  // that can
  };
  const Pattern patterns[] = {{"thread", [](int x, int) { return x % 8 == 3 ? 1 : 0; }, 2},
                              {"stripes", [](int x, int) { return x / 4 % 2; }, 2},
                              {"checkers", [](int x, int y) { return (x / 2 + y / 2) % 2; }, 1},
                              {"checkers of a texel", [](int x, int y) { return (x + y) % 2; }, 0},
                              {"disc", [](int x, int y) { return std::hypot(x - 63.5, y - 63.5) < 50 ? 1 : 0; }, 4}};
  for (const Pattern& pattern : patterns) {
    AlphaLevel level = level_of(128, 128, pattern.alpha);
    const CoverageKeeper keeper(level, 0.5F, {}, {});
    int kept = 0;
    for (;; ++kept) {
      level = halved(level);
      AlphaLevel scaled = level;
      if (!keeper.keep(scaled)) {
        EXPECT_EQ(scaled.alpha, level.alpha) << pattern.name;
        break;
      }
      EXPECT_NEAR(CoverageKeeper(scaled, 0.5F, {}, {}).covered(), keeper.covered(), 0.03 * keeper.covered());
      if (level.width == 1) break;
    }
    EXPECT_EQ(kept, pattern.levels) << pattern.name;
  }
}

// The level covers as much as the first, but in another place.
TEST(AlphaCoverage, WhatIsElsewhereIsNotKept) {
  const auto solid_and_net = [](int x, int y) {
    return x < 64 ? (std::hypot(x - 32, y - 64) < 25 ? 1 : 0) : y / 2 % 2;
  };
  const CoverageKeeper keeper(level_of(128, 128, solid_and_net), 0.5F, {}, {});
  AlphaLevel blurred = level_of(64, 64, [](int x, int y) {
    return x < 32 ? (std::hypot(x - 16, y - 32) < 12.5 ? 1 : 0.7 / (1 + std::hypot(x - 16, y - 32) / 20)) : 0.3;
  });
  EXPECT_FALSE(keeper.keep(blurred));
}

}  // namespace
}  // namespace crowdbench::scene
