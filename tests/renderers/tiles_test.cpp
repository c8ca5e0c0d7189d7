#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/colour.h"
#include "core/random.h"
#include "renderers/impostor/tiles/half_plane.h"
#include "renderers/impostor/tiles/level_order.h"
#include "renderers/impostor/tiles/outline.h"
#include "renderers/impostor/tiles/packing.h"
#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/tiles/tile_textures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

// Coverage of a shape sampled 4x4 a texel; albedo, normal, slot and depth constant unless a test sets them.
template <typename Inside>
std::vector<CapturedTexel> draw_shape(const TileRect& rect, Inside inside) {
  std::vector<CapturedTexel> texels(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height));
  for (int y = 0; y < rect.height; ++y)
    for (int x = 0; x < rect.width; ++x) {
      int hits = 0;
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) hits += inside(rect.x + x + (i + 0.5) / 4, rect.y + y + (j + 0.5) / 4) ? 1 : 0;
      CapturedTexel& t = texels[static_cast<size_t>(y * rect.width + x)];
      t.albedo = {200, 100, 50, static_cast<uint8_t>(std::lround(hits * 255 / 16.0))};
      t.surface = {128, 128, 3, 128};
    }
  return texels;
}

// A figure of sticks: thin limbs are what minification loses.
bool stick_figure(double x, double y) {
  const auto near_segment = [&](double x0, double y0, double x1, double y1, double r) {
    const double dx = x1 - x0;
    const double dy = y1 - y0;
    const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    return std::hypot(x - x0 - t * dx, y - y0 - t * dy) < r;
  };
  return near_segment(0, 0, 0, 40, 7) || std::hypot(x, y - 54) < 8 || near_segment(0, 36, -22, 8, 3) ||
         near_segment(0, 36, 24, 14, 3) || near_segment(-2, 0, -12, -58, 4) || near_segment(2, 0, 16, -56, 4);
}

double covered_area(const Tile& tile, int k = 16) {
  int hits = 0;
  for (int y = (tile.rect.y - 1) * k; y < (tile.rect.y + tile.rect.height + 1) * k; ++y)
    for (int x = (tile.rect.x - 1) * k; x < (tile.rect.x + tile.rect.width + 1) * k; ++x)
      hits += filtered_alpha(tile, (x + 0.5) / k, (y + 0.5) / k) >= 0.5 ? 1 : 0;
  return static_cast<double>(hits) / (k * k);
}

std::vector<Tile> figure_levels() {
  const TileRect rect{-40, -64, 80, 128};
  return build_tile_levels(rect, draw_shape(rect, stick_figure), 7);
}

TEST(Packing, NothingOverlapsAndNothingSticksOut) {
  std::vector<PackSize> sizes;
  for (uint64_t i = 0; i < 500; ++i)
    sizes.push_back({static_cast<int>(random_below(1, i, 1, 60)), static_cast<int>(random_below(1, i, 2, 90))});
  const Packing p = pack_tiles(sizes, 256);
  std::vector<std::vector<uint8_t>> used(static_cast<size_t>(p.layers),
                                         std::vector<uint8_t>(static_cast<size_t>(p.width * p.height)));
  int64_t texels = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    const bool nothing = sizes[i].width == 0 || sizes[i].height == 0;
    ASSERT_EQ(p.places[i].layer < 0, nothing);
    if (nothing) continue;
    ASSERT_GE(p.places[i].x, 0);
    ASSERT_LE(p.places[i].x + sizes[i].width, p.width);
    ASSERT_LE(p.places[i].y + sizes[i].height, p.height);
    for (int y = 0; y < sizes[i].height; ++y)
      for (int x = 0; x < sizes[i].width; ++x) {
        uint8_t& at = used[static_cast<size_t>(p.places[i].layer)]
                          [static_cast<size_t>((p.places[i].y + y) * p.width + p.places[i].x + x)];
        ASSERT_EQ(at, 0);
        at = 1;
        ++texels;
      }
  }
  EXPECT_GT(static_cast<double>(texels) / (static_cast<double>(p.width) * p.height * p.layers), 0.8);
}

TEST(Packing, GroupsHaveLayersOfTheirOwnAndTheirPlacesDoNotDependOnWhatFollows) {
  // Two to a shelf of 64, two shelves to a layer of 60: five of the first group take two layers.
  std::vector<PackSize> sizes(8, PackSize{30, 28});
  sizes[6] = {};  // nothing to place
  const std::vector<int> groups = {0, 0, 0, 0, 0, 3, 3, 4};
  const Packing p = pack_in_order(sizes, groups, 64, 60);
  EXPECT_EQ(p.layers, 4);
  const std::vector<std::array<int, 3>> expected = {{0, 0, 0}, {30, 0, 0}, {0, 28, 0}, {30, 28, 0},
                                                    {0, 0, 1}, {0, 0, 2},  {0, 0, -1}, {0, 0, 3}};
  for (size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ((std::array{p.places[i].x, p.places[i].y, p.places[i].layer}), expected[i]) << i;
  EXPECT_EQ(pack_in_order(std::vector<PackSize>{{70, 10}}, std::vector<int>{0}, 64, 4).width, 72) << "widened";
  EXPECT_EQ(pack_in_order(std::vector<PackSize>{{70, 10}}, std::vector<int>{0}, 64, 4).height, 12);
}

TEST(Packing, WidensForALargeTileAndCutsALowLayer) {
  const std::vector<PackSize> sizes = {{300, 20}, {10, 30}};
  const Packing p = pack_tiles(sizes, 128);
  EXPECT_EQ(p.width, 300);
  EXPECT_EQ(p.layers, 1);
  EXPECT_EQ(p.height, 52);
  EXPECT_EQ(pack_tiles(std::vector<PackSize>{}, 128).layers, 0);
}

TEST(Tile, SignedCodesHaveAnExactZeroAndExactEnds) {
  EXPECT_EQ(decode_signed(encode_signed(0)), 0);
  EXPECT_EQ(decode_signed(encode_signed(1)), 1);
  EXPECT_EQ(decode_signed(encode_signed(-1)), -1);
  for (double v = -1; v <= 1; v += 0.01) EXPECT_NEAR(decode_signed(encode_signed(v)), v, 0.5 / 127 + 1e-12);
}

TEST(Tile, TrimmingKeepsEveryCoveredTexelAndNoEmptyBorder) {
  const TileRect rect{-50, -70, 100, 140};
  const auto texels = draw_shape(rect, stick_figure);
  const Tile tile = build_tile_levels(rect, texels, 1)[0];
  int x0 = 1000, x1 = -1000, y0 = 1000, y1 = -1000;
  for (int y = 0; y < rect.height; ++y)
    for (int x = 0; x < rect.width; ++x)
      if (texels[static_cast<size_t>(y * rect.width + x)].albedo[3] > 0) {
        x0 = std::min(x0, rect.x + x);
        x1 = std::max(x1, rect.x + x);
        y0 = std::min(y0, rect.y + y);
        y1 = std::max(y1, rect.y + y);
      }
  EXPECT_EQ(tile.rect, (TileRect{x0, y0, x1 - x0 + 1, y1 - y0 + 1}));
}

TEST(Tile, EveryLevelKeepsTheSilhouettesArea) {
  const TileRect rect{-40, -64, 80, 128};
  const auto texels = draw_shape(rect, stick_figure);
  double area = 0;
  for (const CapturedTexel& t : texels) area += t.albedo[3] / 255.0;
  double scale = 1;
  for (const Tile& tile : figure_levels()) {
    EXPECT_NEAR(covered_area(tile) * scale / area, 1, 0.03)
        << "level texels " << tile.rect.width << " x " << tile.rect.height;
    scale *= 4;
  }
}

// What plain box-filtered levels do, so that the test above is known to be able to fail.
TEST(Tile, PlainLevelsWouldLoseTheFigure) {
  const TileRect rect{-40, -64, 80, 128};
  const auto texels = draw_shape(rect, stick_figure);
  double area = 0;
  std::vector<double> alpha;
  for (const CapturedTexel& t : texels) {
    alpha.push_back(t.albedo[3] / 255.0);
    area += alpha.back();
  }
  int passing = 0;
  for (int y = 0; y < 128; y += 32)
    for (int x = 0; x < 64; x += 32) {
      double sum = 0;
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) sum += alpha[static_cast<size_t>((y + j) * 80 + x + i + 8)];
      passing += sum / 1024 >= 0.5;
    }
  EXPECT_LT(passing * 1024, 0.5 * area);
}

TEST(Tile, ColoursAreMeansInLinearLight) {
  // Two texels, one bright (linear 1) and one dark (linear 0), fully covered: their mean is linear 0.5.
  const TileRect rect{0, 0, 2, 2};
  std::vector<CapturedTexel> texels(4);
  for (size_t i = 0; i < 4; ++i) {
    const auto v = static_cast<uint8_t>(i % 2 == 0 ? 255 : 0);
    texels[i].albedo = {v, v, v, 255};
    texels[i].surface = {128, 128, static_cast<uint8_t>(i == 0 ? 7 : 4), 128};
  }
  const auto levels = build_tile_levels(rect, texels, 2);
  ASSERT_EQ(levels[1].rect, (TileRect{0, 0, 1, 1}));
  const size_t centre = 4 * 4;               // (1, 1) of 3 x 3
  EXPECT_EQ(levels[1].albedo[centre], 180);  // sqrt(0.5) * 255 = 180.3
  EXPECT_EQ(levels[1].surface[centre + 2], 4) << "three quarters of it is slot 4; ids are never averaged";
}

TEST(Tile, EmissionIsAMeanOfWhatIsCovered) {
  const TileRect rect{0, 0, 2, 2};
  std::vector<CapturedTexel> texels(4);
  for (CapturedTexel& t : texels) t.albedo[3] = 255;
  for (const Tile& t : build_tile_levels(rect, texels, 2)) EXPECT_TRUE(t.emission.empty()) << "nothing glows";
  // Two that give off all of the peak, one nothing, one is not covered: two thirds of the peak.
  texels[0].emission = texels[1].emission = {255, 0, 0};
  texels[3].albedo[3] = 0;
  const auto levels = build_tile_levels(rect, texels, 2);
  ASSERT_EQ(levels[0].emission.size(), 4U * 16);
  const size_t first = 4 * (4 + 1);  // (0, 0) of 2 x 2, within the gutters
  EXPECT_EQ(levels[0].emission[first], 255);
  EXPECT_EQ(levels[0].emission[first - 4], linear_to_srgb8(0.5)) << "the gutter beside it, and beside the dark texel";
  const size_t centre = 4 * 4;  // (1, 1) of 3 x 3
  EXPECT_EQ(levels[1].emission[centre], linear_to_srgb8(2.0 / 3));
  EXPECT_EQ(levels[1].emission[centre + 1], 0);
}

TEST(Tile, NormalsAreRenormalised) {
  const TileRect rect{0, 0, 2, 1};
  std::vector<CapturedTexel> texels(2);
  // (0.8, 0, 0.6) and (-0.8, 0, 0.6): the mean points at the viewer.
  texels[0].albedo = texels[1].albedo = {255, 255, 255, 255};
  texels[0].surface = {encode_signed(0.8), 128, 0, encode_signed(0.5)};
  texels[1].surface = {encode_signed(-0.8), 128, 0, encode_signed(0.25)};
  const auto levels = build_tile_levels(rect, texels, 2);
  const size_t centre = 4 * 4;
  EXPECT_NEAR(decode_signed(levels[1].surface[centre]), 0, 0.01);
  EXPECT_NEAR(decode_signed(levels[1].surface[centre + 1]), 0, 0.01);
  EXPECT_NEAR(decode_signed(levels[1].surface[centre + 3]), 0.375, 0.01);
}

TEST(Tile, NeighboursOfCoveredTexelsCarryTheirColour) {
  const TileRect rect{-8, -8, 16, 16};
  const Tile tile =
      build_tile_levels(rect, draw_shape(rect, [](double x, double y) { return std::hypot(x, y) < 5.3; }), 1)[0];
  // Bilinear fetches that pass the test touch only texels next to covered ones.
  int beside = 0;
  for (int row = 0; row < tile.rows(); ++row)
    for (int column = 0; column < tile.stride(); ++column) {
      const double x = tile.rect.x + column - 0.5;
      const double y = tile.rect.y + row - 0.5;
      bool touched = false;
      for (double v = -0.95; v < 1; v += 0.1)
        for (double u = -0.95; u < 1; u += 0.1) touched |= filtered_alpha(tile, x + u, y + v) >= 0.5;
      const size_t o = 4 * static_cast<size_t>(row * tile.stride() + column);
      if (!touched) continue;
      ++beside;
      EXPECT_EQ(tile.albedo[o], 200);
      EXPECT_EQ(tile.surface[o + 2], 3);
    }
  EXPECT_GT(beside, 100);
}

TEST(Tile, NothingCoveredGivesEmptyTiles) {
  const TileRect rect{-2, -2, 4, 4};
  const std::vector<Tile> levels = build_tile_levels(rect, std::vector<CapturedTexel>(16), 3);
  ASSERT_EQ(levels.size(), 3U);
  for (const Tile& t : levels) {
    EXPECT_EQ(t.rect.width, 0);
    EXPECT_TRUE(t.albedo.empty());
    for (const glm::vec2& p : tile_outline(t, 4)) EXPECT_EQ(p, glm::vec2(0, 0));
    for (const glm::vec2& p : tile_triangle(t)) EXPECT_EQ(p, glm::vec2(0, 0));
  }
}

// Strip triangles 0 1 2, 1 2 3, ...
bool strip_holds(const std::vector<glm::vec2>& strip, const glm::dvec2& p) {
  for (size_t i = 0; i + 2 < strip.size(); ++i) {
    const glm::dvec2 a = strip[i], b = strip[i + 1], c = strip[i + 2];
    const auto side = [&](const glm::dvec2& u, const glm::dvec2& v) {
      return (v.x - u.x) * (p.y - u.y) - (v.y - u.y) * (p.x - u.x);
    };
    const double ab = side(a, b), bc = side(b, c), ca = side(c, a);
    if ((ab >= -1e-6 && bc >= -1e-6 && ca >= -1e-6) || (ab <= 1e-6 && bc <= 1e-6 && ca <= 1e-6)) return true;
  }
  return false;
}

double strip_area(const std::vector<glm::vec2>& strip) {
  double area = 0;
  for (size_t i = 0; i + 2 < strip.size(); ++i)
    area += std::abs(polygon_area({glm::dvec2(strip[i]), glm::dvec2(strip[i + 1]), glm::dvec2(strip[i + 2])}));
  return area;
}

TEST(Outline, NeverCutsACoveredPointAndStaysWithinTheGutters) {
  for (const int corners : {4, 6, 8}) {
    int level = 0;
    for (const Tile& tile : figure_levels()) {
      const auto strip = tile_outline(tile, corners);
      ASSERT_EQ(strip.size(), static_cast<size_t>(corners));
      for (const glm::vec2& p : strip) {
        EXPECT_GE(p.x, tile.rect.x - 1.0001);
        EXPECT_LE(p.x, tile.rect.x + tile.rect.width + 1.0001);
        EXPECT_GE(p.y, tile.rect.y - 1.0001);
        EXPECT_LE(p.y, tile.rect.y + tile.rect.height + 1.0001);
      }
      constexpr int k = 5;
      int covered = 0;
      for (int y = (tile.rect.y - 1) * k; y < (tile.rect.y + tile.rect.height + 1) * k; ++y)
        for (int x = (tile.rect.x - 1) * k; x < (tile.rect.x + tile.rect.width + 1) * k; ++x) {
          const glm::dvec2 p{(x + 0.5) / k, (y + 0.5) / k};
          if (filtered_alpha(tile, p.x, p.y) >= 0.5) {
            ASSERT_TRUE(strip_holds(strip, p)) << corners << " corners, level " << level << ", " << p.x << " " << p.y;
            ++covered;
          }
        }
      EXPECT_GT(covered, 10) << "level " << level;
      ++level;
    }
  }
}

// Cells of 4 x 4 texels that the triangles of a strip touch, a cell once for every triangle, on average over the
// places where a grid of cells may lie.
double blocks_touched(const std::vector<glm::vec2>& strip) {
  double blocks = 0;
  for (size_t i = 0; i + 2 < strip.size(); ++i) {
    const glm::vec2 a = strip[i], b = strip[i + 1], c = strip[i + 2];
    const glm::vec2 size = glm::max(a, glm::max(b, c)) - glm::min(a, glm::min(b, c));
    blocks += strip_area({a, b, c}) / 16 + static_cast<double>(size.x + size.y) / 4 + 1;
  }
  return blocks;
}

TEST(Outline, ATriangleHoldsAllThatIsCoveredAndItsGutterIsEmpty) {
  const TileRect board{-8, -20, 16, 40};
  std::vector<Tile> tiles = figure_levels();
  // A rectangle: no three of its own sides close around it.
  tiles.push_back(build_tile_levels(board, draw_shape(board, [](double, double) { return true; }), 1)[0]);
  for (size_t i = 0; i < tiles.size(); ++i) {
    const Tile& tile = tiles[i];
    const auto triangle = tile_triangle(tile);
    ASSERT_EQ(triangle.size(), 3U);
    constexpr int k = 5;
    int covered = 0;
    for (int y = (tile.rect.y - 1) * k; y < (tile.rect.y + tile.rect.height + 1) * k; ++y)
      for (int x = (tile.rect.x - 1) * k; x < (tile.rect.x + tile.rect.width + 1) * k; ++x) {
        const glm::dvec2 p{(x + 0.5) / k, (y + 0.5) / k};
        if (filtered_alpha(tile, p.x, p.y) >= 0.5) {
          ASSERT_TRUE(strip_holds(triangle, p)) << i << ": " << p.x << " " << p.y;
          ++covered;
        }
      }
    EXPECT_GT(covered, 10) << i;
    // What the rest of the triangle shows: samples clamped to the centres of the gutter's texels.
    const double left = tile.rect.x - 0.5, right = tile.rect.x + tile.rect.width + 0.5;
    const double below = tile.rect.y - 0.5, above = tile.rect.y + tile.rect.height + 0.5;
    for (double y = below; y <= above; y += 0.25)
      for (const double x : {left, right}) ASSERT_LT(filtered_alpha(tile, x, y), 0.5) << i << ": " << x << " " << y;
    for (double x = left; x <= right; x += 0.25)
      for (const double y : {below, above}) ASSERT_LT(filtered_alpha(tile, x, y), 0.5) << i << ": " << x << " " << y;
  }
}

TEST(Outline, ATriangleTouchesFewerBlocksThanTwo) {
  const std::vector<Tile> levels = figure_levels();
  ASSERT_GT(levels.size(), 2U);
  for (size_t level = 2; level < levels.size(); ++level)
    EXPECT_LT(blocks_touched(tile_triangle(levels[level])), blocks_touched(tile_outline(levels[level], 4)))
        << "level " << level;
}

TEST(Outline, EightCornersShadeLessThanTheRectangle) {
  const Tile tile = figure_levels()[0];
  const double rectangle = static_cast<double>(tile.rect.width) * tile.rect.height;
  const double four = strip_area(tile_outline(tile, 4));
  const double eight = strip_area(tile_outline(tile, 8));
  EXPECT_LE(four, rectangle + 2 * 0.08 * 2 * (tile.rect.width + tile.rect.height)) << "the margin around the hull";
  EXPECT_LT(eight, 0.85 * rectangle);
  EXPECT_LT(eight, four);
}

TEST(Outline, ADiscInEightCornersIsAnOctagon) {
  const TileRect rect{-24, -24, 48, 48};
  const Tile disc =
      build_tile_levels(rect, draw_shape(rect, [](double x, double y) { return std::hypot(x, y) < 20; }), 1)[0];
  // The circumscribed octagon of radius r has 8 tan(22.5 degrees) r^2.
  const double octagon = 8 * std::tan(std::numbers::pi / 8) * 20 * 20;
  EXPECT_NEAR(strip_area(tile_outline(disc, 8)), octagon, 0.05 * octagon);
}

// ---- polygons cut by half-planes

using Polygon = std::vector<glm::dvec2>;

TEST(HalfPlane, CutsTheUnitSquare) {
  const Polygon square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_EQ(cut_by_half_plane(square, {1, 0}, 0.25), (Polygon{{0, 0}, {0.25, 0}, {0.25, 1}, {0, 1}}));
  EXPECT_EQ(cut_by_half_plane(square, {4, 0}, 1), (Polygon{{0, 0}, {0.25, 0}, {0.25, 1}, {0, 1}}))
      << "outward need not be of unit length";
  EXPECT_EQ(cut_by_half_plane(square, {1, 1}, 0.5), (Polygon{{0, 0}, {0.5, 0}, {0, 0.5}}));
  EXPECT_EQ(cut_by_half_plane(square, {1, 0}, 1), square) << "what lies on the line is kept";
  EXPECT_EQ(cut_by_half_plane(square, {1, 0}, 0), (Polygon{{0, 0}, {0, 1}}));
  EXPECT_TRUE(cut_by_half_plane(square, {1, 0}, -0.5).empty());
  EXPECT_TRUE(cut_by_half_plane({}, {1, 0}, 1).empty());
}

// ---- levels of tiles, and the order of drawing

// An eye at the origin that looks along -z, through which a texel of level 0 spans a pixel at a depth of 1 m.
scene::Frame frame_of_depths(const std::vector<float>& depths) {
  scene::Frame frame;
  frame.camera.eye = {0, 0, 0};
  frame.camera.target = {0, 0, -1};
  frame.camera.fov_y = std::numbers::pi / 2;
  frame.height = 512;
  frame.agents.resize(1);
  for (const float depth : depths) frame.agents[0].emplace_back().position = {0, 0, -depth};
  return frame;
}
constexpr double kTexel = 2.0 / 512;

using Indices = std::vector<uint32_t>;
Indices listed(std::span<const uint32_t> agents) { return {agents.begin(), agents.end()}; }

TEST(LevelOrder, ALevelCoversAtMostRootTwoPixelsAndTheNearestGoFirst) {
  // Level l fits where 2^l is at most root 2 times the depth: from 1.42 m on level 1, from 2.83 m on level 2.
  const scene::Frame frame = frame_of_depths({3, 1, 100, 1.5F, 0.5F, -2});
  LevelOrder order;
  order.sort(frame, frame.agents[0], Indices{0, 1, 2, 3, 4, 5}, {}, kTexel, 3);
  EXPECT_EQ(order.agents(), 6U);
  EXPECT_EQ(listed(order.at_level(0)), (Indices{5, 4, 1})) << "behind the eye is as near as can be";
  EXPECT_EQ(listed(order.at_level(1)), Indices{3});
  EXPECT_EQ(listed(order.at_level(2)), (Indices{0, 2})) << "the coarsest there is";
  EXPECT_EQ(listed(order.all()), (Indices{5, 4, 1, 3, 0, 2}));
  order.sort(frame, frame.agents[0], Indices{2, 0}, {}, kTexel, 1);
  EXPECT_EQ(listed(order.at_level(0)), (Indices{0, 2}));
  order.sort(frame, frame.agents[0], {}, {}, kTexel, 2);
  EXPECT_EQ(order.agents(), 0U);
  EXPECT_TRUE(order.at_level(1).empty());
}

TEST(LevelOrder, TheDepthIsThatOfTheCaptureCentreAtTheAgentsScaleAndHeading) {
  scene::Frame frame = frame_of_depths({3, 3, 3});
  frame.agents[0][1].heading = {0, -1};  // turned round: its centre, 1 m before it, lies farther away
  frame.agents[0][2].scale = 0.5F;       // half as large: a texel of half a pixel, 2.5 m away
  LevelOrder order;
  order.sort(frame, frame.agents[0], Indices{0, 1, 2}, {0, 0, 1}, kTexel, 4);
  EXPECT_EQ(listed(order.at_level(1)), Indices{0}) << "2 m: root 2 times 2 is below 4";
  EXPECT_EQ(listed(order.at_level(2)), (Indices{2, 1})) << "5 and 4 m of full size: below 8; the nearer one first";
}

// ---- pages on the GPU

class TileTexturesGl : public testing::GlTest {};

TEST_F(TileTexturesGl, LayersFollowEachOtherAndAreReadWithoutWrapping) {
  std::vector<uint8_t> texels(2 * 3 * 4 * 2);
  for (size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<uint8_t>(5 * i);
  const gl::Texture pages = upload_layers(testing::context(), GL_RGBA8, GL_RGBA, 3, 2, 2, texels);
  EXPECT_EQ(pages.levels(), 1);
  EXPECT_EQ(pages.layers(), 2);
  EXPECT_EQ(pages.bytes(), texels.size());
  std::vector<uint8_t> read(texels.size());
  pages.read(0, GL_RGBA, GL_UNSIGNED_BYTE, read.data(), read.size());
  EXPECT_EQ(read, texels);
  for (const unsigned filter : {GL_LINEAR, GL_NEAREST}) {
    const gl::Sampler sampler = page_sampler(testing::context(), filter);
    const auto is = [&](unsigned parameter) {
      int value = 0;
      glGetSamplerParameteriv(sampler.name(), parameter, &value);
      return static_cast<unsigned>(value);
    };
    EXPECT_EQ(is(GL_TEXTURE_MIN_FILTER), filter);
    EXPECT_EQ(is(GL_TEXTURE_MAG_FILTER), filter);
    EXPECT_EQ(is(GL_TEXTURE_WRAP_S), static_cast<unsigned>(GL_CLAMP_TO_EDGE));
    EXPECT_EQ(is(GL_TEXTURE_WRAP_T), static_cast<unsigned>(GL_CLAMP_TO_EDGE));
  }
}

}  // namespace
}  // namespace crowdbench::renderers
