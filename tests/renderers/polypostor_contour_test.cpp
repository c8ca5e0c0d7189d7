#include "renderers/polypostor/polypostor_contour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace crowdbench::renderers {
namespace {

// Rows as one reads them, the top one first; '#' is covered.
PartMask mask_of(const std::vector<std::string>& rows) {
  PartMask mask;
  mask.width = static_cast<int>(rows[0].size());
  mask.height = static_cast<int>(rows.size());
  for (size_t r = rows.size(); r-- > 0;)
    for (const char c : rows[r]) mask.on.push_back(c == '#' ? 3 : 0);
  return mask;
}
// In samples.
double area_of(const Polyline& contour) { return signed_area(contour) * kMaskSamples * kMaskSamples; }

TEST(PolypostorContour, OfOneSampleIsItsDiamond) {
  const Polyline c = trace_contour(mask_of({"...", ".#.", "..."}));
  ASSERT_EQ(c.size(), 4U);
  EXPECT_NEAR(area_of(c), 0.5, 1e-12) << "through the middles of its four sides, counter-clockwise";
  for (const glm::dvec2& p : c) EXPECT_NEAR(glm::distance(p * double{kMaskSamples}, glm::dvec2(1.5)), 0.5, 1e-12);
}

TEST(PolypostorContour, OfNothingIsNothing) {
  EXPECT_TRUE(trace_contour(mask_of({"...", "..."})).empty());
  EXPECT_TRUE(trace_contour(PartMask{}).empty());
}

TEST(PolypostorContour, PassesOverHoles) {
  const Polyline full = trace_contour(mask_of({"#####", "#####", "#####", "#####", "#####"}));
  const Polyline holed = trace_contour(mask_of({"#####", "#...#", "#...#", "#...#", "#####"}));
  EXPECT_EQ(full, holed);
  // A square of n samples: its corners are cut by a half times a half each.
  EXPECT_NEAR(area_of(full), 25 - 4 * 0.125, 1e-12);
  EXPECT_EQ(full.size(), 20U) << "the mask fills its border";
}

TEST(PolypostorContour, DiagonalNeighboursTouch) {
  const Polyline c = trace_contour(mask_of({"##..", "##..", "..##", "..##"}));
  EXPECT_EQ(c.size(), 16U) << "the borders of both squares, walked once";
}

TEST(PolypostorContour, BridgesTwoComponents) {
  const Polyline c = trace_contour(mask_of({"##....##", "##....##"}));
  double left = 1e9;
  double right = -1e9;
  for (const glm::dvec2& p : c) {
    left = std::min(left, p.x * kMaskSamples);
    right = std::max(right, p.x * kMaskSamples);
  }
  EXPECT_EQ(left, 0);
  EXPECT_EQ(right, 8) << "both are within one outline";
  EXPECT_NEAR(area_of(c), 4 + 4 + 4, 1.5) << "two squares and a bridge of four samples";
}

TEST(PolypostorContour, RasteriserCoversWhatLiesInside) {
  // A right triangle of legs 6 texels: half the square, give or take samples on the long side.
  const std::vector<glm::dvec2> t = {{0, 0}, {6, 0}, {0, 6}};
  const PartMask mask = rasterise(t);
  EXPECT_NEAR(covered_area(mask), 18, 1.1);
  EXPECT_EQ(facing_area(mask), covered_area(mask)) << "counter-clockwise faces the eye";
  const std::vector<glm::dvec2> back = {{0, 0}, {0, 6}, {6, 0}};
  EXPECT_EQ(facing_area(rasterise(back)), 0);
  EXPECT_EQ(covered_area(rasterise(back)), covered_area(mask));
}

TEST(PolypostorContour, OutwardPolygonsHoldTheirContour) {
  // Blobs of random discs, in all the budgets.
  for (uint64_t seed = 0; seed < 40; ++seed) {
    PartMask mask;
    mask.width = mask.height = 60;
    mask.on.assign(3600, 0);
    for (uint64_t disc = 0; disc < 3; ++disc) {
      const auto r = [&](uint64_t k) { return random_unit(seed, disc, k); };
      const double x = 10 + 40 * r(0);
      const double y = 10 + 40 * r(1);
      const double radius = 2 + 8 * r(2);
      for (int j = 0; j < 60; ++j)
        for (int i = 0; i < 60; ++i)
          if (std::hypot(i - x, j - y) < radius) mask.on[static_cast<size_t>(j * 60 + i)] = 3;
    }
    const Polyline contour = trace_contour(mask);
    for (const int corners : {4, 6, 8, 12}) {
      const Polyline polygon = outward_polygon(contour, corners, 0.5, 0.5);
      SCOPED_TRACE(::testing::Message() << seed << ", " << corners);
      EXPECT_LE(polygon.size(), static_cast<size_t>(corners));
      EXPECT_TRUE(is_simple(polygon));
      for (const glm::dvec2& p : contour) ASSERT_TRUE(contains(polygon, p));
    }
  }
}

TEST(PolypostorContour, OutwardPolygonsAreTight) {
  Polyline circle;
  for (int i = 0; i < 200; ++i) {
    const double angle = 2 * std::numbers::pi * i / 200;
    circle.push_back(10.0 * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  // The least polygon of n corners around a circle is regular, of n r^2 tan(pi / n).
  for (const int corners : {4, 6, 8, 12}) {
    const double least = corners * 100 * std::tan(std::numbers::pi / corners);
    EXPECT_LT(signed_area(outward_polygon(circle, corners, 0, 0.01)), 1.2 * least) << corners;
  }
}

TEST(PolypostorContour, SimplePolygonsAreToldFromKnots) {
  EXPECT_TRUE(is_simple({{0, 0}, {2, 0}, {2, 2}, {0, 2}}));
  EXPECT_FALSE(is_simple({{0, 0}, {2, 2}, {2, 0}, {0, 2}}));
}

TEST(PolypostorContour, SimplerLinesStayNear) {
  Polyline disc;
  for (int i = 0; i < 64; ++i) {
    const double angle = 2 * std::numbers::pi * i / 64;
    disc.emplace_back(10 * std::cos(angle), 10 * std::sin(angle));
  }
  const Polyline simpler = simplify(disc, 0.2);
  EXPECT_LT(simpler.size(), 32U);
  EXPECT_GE(simpler.size(), 8U);
  for (const glm::dvec2& p : disc) EXPECT_LE(nearest_point(simpler, p).distance, 0.2);
  const Polyline square = {{0, 0}, {2, 0}, {4, 0}, {4, 4}, {0, 4}};
  EXPECT_EQ(simplify(square, 0.1), (Polyline{{0, 0}, {4, 0}, {4, 4}, {0, 4}}));
}

}  // namespace
}  // namespace crowdbench::renderers
