#include "renderers/impostor/tiles/alpha_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/hash.h"

namespace crowdbench::renderers {
namespace {

// A shape sampled 3 x 3 a texel, as captures are.
template <typename There>
std::vector<CapturedTexel> capture(int width, int height, There there) {
  std::vector<CapturedTexel> texels(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int hits = 0;
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) hits += there(x + (i + 0.5) / 3, y + (j + 0.5) / 3) ? 1 : 0;
      CapturedTexel& t = texels[static_cast<size_t>(y * width + x)];
      t.albedo = {200, 100, 50, static_cast<uint8_t>(std::lround(hits * 255 / 9.0))};
      t.surface = {128, 128, 3, 128};
    }
  return texels;
}

// Texels of a rectangle whose filtered alpha passes, at points apart from the lattice (a lattice of points within a
// texel sees a strand of one texel or does not).
double passing_area(const Tile& tile, const TileRect& within) {
  constexpr int kSide = 20;
  int hits = 0;
  for (int y = within.y; y < within.y + within.height; ++y)
    for (int x = within.x; x < within.x + within.width; ++x)
      for (int i = 0; i < kSide * kSide; ++i) {
        const double u = (i + 0.5) / (kSide * kSide);
        const double v = std::fmod(0.6180339887498949 * i + 0.3 * x, 1.0);
        hits += filtered_alpha(tile, x + u, y + v) >= 0.5 ? 1 : 0;
      }
  return static_cast<double>(hits) / (kSide * kSide);
}
double passing_area(const Tile& tile) {
  return passing_area(tile, {tile.rect.x - 1, tile.rect.y - 1, tile.rect.width + 2, tile.rect.height + 2});
}

struct Pattern {
  const char* name;
  double size;  // of what is there, texels of level 0
  bool (*there)(double x, double y, double size);
};
bool checker(double x, double y, double size) {
  return (static_cast<int>(x / size) + static_cast<int>(y / size)) % 2 == 0;
}
bool net(double x, double y, double size) {
  return static_cast<int>(x / size) % 4 == 0 || static_cast<int>(y / size) % 4 == 0;
}
bool strand(double x, double, double size) { return x > 20.3 && x < 20.3 + size; }
bool strands(double x, double y, double size) { return std::fmod(x + 0.13 * y, 3 * size) < size; }
bool stripes(double x, double, double size) { return static_cast<int>(x / size) % 2 == 0; }

class ThinPatterns : public ::testing::TestWithParam<Pattern> {};

// Before texels were roughened, and points scattered where they decide too little, checkers of one texel covered 1.6
// to 1.9 times what is there, and a strand of one 1.1 to 1.5 times.
TEST_P(ThinPatterns, CoverWhatIsThereAtEveryLevel) {
  const Pattern& pattern = GetParam();
  constexpr int kWidth = 64;
  constexpr int kHeight = 96;
  const auto there = [&](double x, double y) { return pattern.there(x, y, pattern.size); };
  int level = 0;
  for (const Tile& tile : build_tile_levels({0, 0, kWidth, kHeight}, capture(kWidth, kHeight, there), 4)) {
    EXPECT_NEAR(passing_area(tile) / tile.coverage, 1, 0.035) << "level " << level;
    ++level;
  }
}

INSTANTIATE_TEST_SUITE_P(Tiles, ThinPatterns,
                         ::testing::Values(Pattern{"checkers_of_one", 1, checker},
                                           Pattern{"checkers_of_two", 2, checker},
                                           Pattern{"checkers_of_less", 0.7, checker}, Pattern{"net_of_one", 1, net},
                                           Pattern{"net_of_two", 2, net}, Pattern{"strand_of_one", 1, strand},
                                           Pattern{"strand_of_two", 2, strand},
                                           Pattern{"leaning_strands", 1.25, strands},
                                           Pattern{"stripes_of_one", 1, stripes}),
                         [](const auto& test) { return std::string(test.param.name); });

// What is level all over is spread all over: a quarter of it holds a quarter of what is there, whatever the quarter.
TEST(AlphaMap, LevelCoverageIsSpreadEvenly) {
  for (const double coverage : {0.3, 0.6}) {
    const auto all = [&](double x, double) { return std::fmod(x, 1.0) < coverage; };
    const Tile tile = build_tile_levels({0, 0, 64, 64}, capture(64, 64, all), 1)[0];
    for (const TileRect& quarter : {TileRect{0, 0, 32, 32}, {32, 0, 32, 32}, {0, 32, 32, 32}, {32, 32, 32, 32}})
      EXPECT_NEAR(passing_area(tile, quarter) / (tile.coverage / 4), 1, 0.12) << coverage;
  }
}

// Full coverage beside level coverage is not touched.
TEST(AlphaMap, FullTexelsStayFull) {
  std::vector<float> coverage(40 * 40, 0.5F);
  for (size_t y = 0; y < 40; ++y)
    for (size_t x = 0; x < 20; ++x) coverage[y * 40 + x] = 1;
  const StoredAlpha stored = solve_stored_alpha({0, 0, 40, 40}, coverage, 1200);
  int beside = 0;
  for (size_t y = 0; y < 40; ++y) {
    for (size_t x = 0; x < 20; ++x) ASSERT_EQ(stored.texels[y * 40 + x], 255) << x << " " << y;
    for (size_t x = 20; x < 40; ++x) beside += stored.texels[y * 40 + x] >= 128 ? 1 : 0;
  }
  EXPECT_NEAR(beside, 400, 80) << "of 800 half covered texels";
  EXPECT_LT(stored.empty, 128);
}

TEST(AlphaMap, NothingIsNothing) {
  const StoredAlpha stored = solve_stored_alpha({3, 4, 2, 1}, std::vector<float>{0, 0}, 0);
  EXPECT_EQ(stored.texels, (std::vector<uint8_t>{0, 0}));
  EXPECT_EQ(stored.empty, 0);
}

// A body of shapes wider than a texel keeps the bytes that it had before there were scattered points.
TEST(AlphaMap, OrdinaryFiguresAreStoredAsBefore) {
  const auto body = [](double x, double y) {
    return std::hypot(x - 24, y - 80) < 8 || std::hypot((x - 24) / 10, (y - 50) / 22) < 1 ||
           std::abs(x - 18 + 0.1 * y) < 3.6 || (std::abs(x - 32 - 0.07 * y) < 3.4 && y < 40);
  };
  Sha256 hash;
  for (const Tile& tile : build_tile_levels({-8, 0, 64, 96}, capture(64, 96, body), 4)) hash.values(tile.albedo);
  EXPECT_EQ(hash.hex(), "7e8ec1056fcdcf06333e4fb8bb3e5e90728ba8a664c06570bff14bfebeaf5cfb");
}

}  // namespace
}  // namespace crowdbench::renderers
