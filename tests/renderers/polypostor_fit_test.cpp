#include "renderers/polypostor/polypostor_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/random.h"
#include "tests/renderers/polygons.h"

namespace crowdbench::renderers {
namespace {

using testing::turned;

// All monotone cyclic choices, one after another.
double brute_force(const Polyline& samples, const Polyline& predicted) {
  const size_t m = samples.size();
  const size_t n = predicted.size();
  double best = std::numeric_limits<double>::infinity();
  std::vector<size_t> at(n);
  const std::function<void(size_t, size_t, size_t)> place = [&](size_t i, size_t start, size_t offset) {
    at[i] = (start + offset) % m;
    if (i + 1 == n) {
      best = std::min(best, correspondence_cost(samples, predicted, at));
      return;
    }
    for (size_t next = offset + 1; next < m; ++next) place(i + 1, start, next);
  };
  for (size_t start = 0; start < m; ++start) place(0, start, 0);
  return best;
}

Polyline wobbly_circle(uint64_t seed, size_t count, double turn) {
  Polyline out;
  for (size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count) + turn;
    const double radius = 5 + 2 * random_unit(seed, i, 7);
    out.push_back(radius * glm::dvec2(std::cos(angle), 0.6 * std::sin(angle)));
  }
  return out;
}

TEST(PolypostorCorrespondence, IsTheLeastOfAll) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const Polyline samples = wobbly_circle(seed, 9, 0);
    const Polyline predicted = wobbly_circle(seed + 100, 4, 0.5 * static_cast<double>(seed));
    const Correspondence found = correspond(samples, predicted);
    EXPECT_NEAR(found.cost, brute_force(samples, predicted), 1e-9) << seed;
    EXPECT_NEAR(found.cost, correspondence_cost(samples, predicted, found.at), 1e-9)
        << "the cost is that of its choice";
  }
}

TEST(PolypostorCorrespondence, GoesRoundOnceInOrder) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Polyline samples = wobbly_circle(seed, 48, 0);
    const Correspondence found = correspond(samples, wobbly_circle(seed + 50, 8, 1.3 * static_cast<double>(seed)));
    size_t round = 0;
    for (size_t i = 0; i < found.at.size(); ++i) {
      const size_t step = (found.at[(i + 1) % 8] + 48 - found.at[i]) % 48;
      EXPECT_GT(step, 0U);
      round += step;
    }
    EXPECT_EQ(round, 48U) << "each later than the one before, and once round";
  }
}

TEST(PolypostorCorrespondence, StartsWhereverTheOutlineDoes) {
  const Polyline samples = wobbly_circle(3, 40, 0);
  const Polyline predicted = wobbly_circle(4, 7, 0.2);
  const Correspondence found = correspond(samples, predicted);
  for (const size_t shift : {1U, 13U, 39U}) {
    Polyline turned = samples;
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(shift), turned.end());
    const Correspondence again = correspond(turned, predicted);
    EXPECT_NEAR(again.cost, found.cost, 1e-9);
    for (size_t i = 0; i < 7; ++i) EXPECT_EQ((again.at[i] + shift) % 40, found.at[i]);
  }
}

TEST(PolypostorTriangulation, AvoidsWhatWouldFold) {
  // A square; in the second pose corner 1 is pushed past the diagonal 0-2, so that only the other diagonal works.
  const Polyline key = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const std::vector<Polyline> poses = {key, {{0, 0}, {1, 2.5}, {4, 4}, {0, 4}}};
  ASSERT_GT(signed_area(poses[1]), 0);
  const auto triangles = triangulate(key, poses);
  ASSERT_EQ(triangles.size(), 2U);
  for (const Polyline& pose : poses) EXPECT_EQ(inverted_triangles(pose, triangles), 0U);
  EXPECT_GT(inverted_triangles(poses[1], std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}), 0U)
      << "the other diagonal folds";
}

TEST(PolypostorTriangulation, CoversConcavePolygonsOnce) {
  const Polyline key = {{0, 0}, {6, 0}, {6, 6}, {3, 1}, {0, 6}};
  const auto triangles = triangulate(key, std::vector<Polyline>{key});
  ASSERT_EQ(triangles.size(), 3U);
  EXPECT_EQ(inverted_triangles(key, triangles), 0U);
  double area = 0;
  for (const Triangle& t : triangles) area += signed_area({key[t[0]], key[t[1]], key[t[2]]});
  EXPECT_NEAR(area, signed_area(key), 1e-12);
  EXPECT_TRUE(triangulate({{0, 0}, {1, 0}, {2, 0}}, {}).empty()) << "a line has none";
}

std::vector<glm::dvec2> triangles_of(const Polyline& quad) {
  return {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
}

TEST(PolypostorFit, ARigidSquareThatTurnsIsReproducedExactly) {
  const Polyline square = {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}};
  constexpr size_t kFrames = 12;
  const auto angle = [](size_t f) { return 2 * std::numbers::pi * static_cast<double>(f) / kFrames; };
  std::vector<Polyline> contours;
  for (size_t f = 0; f < kFrames; ++f)
    contours.push_back(trace_contour(rasterise(triangles_of(turned(square, angle(f))))));
  const auto carry = [&](const glm::dvec2& p) {
    Polyline out;
    for (size_t f = 0; f < kFrames; ++f) out.push_back(turned(p, angle(f)));
    return out;
  };
  const Fit fit = fit_part(contours[0], contours, 0, carry, {});
  ASSERT_GE(fit.polygon.size(), 4U);
  EXPECT_EQ(fit.repaired, 0U);
  for (size_t f = 0; f < kFrames; ++f) {
    const Polyline exact = turned(fit.polygon, angle(f));
    for (size_t i = 0; i < exact.size(); ++i) EXPECT_LT(glm::distance(fit.poses[f][i], exact[i]), 1e-9) << f;
    EXPECT_NEAR(fit.turns[f].x, std::cos(angle(f)), 1e-9);
    EXPECT_NEAR(fit.turns[f].y, std::sin(angle(f)), 1e-9);
  }
}

// The motion is known exactly but for a bulge on the right that nobody sees, and that no corner can follow: what is
// seen, on the left, is where the motion takes it.
TEST(PolypostorFit, WhatIsSeenDecides) {
  Polyline square;
  for (int i = 0; i < 40; ++i) {
    const double along = i % 10 * 2 - 10.0;
    const std::array<glm::dvec2, 4> sides = {glm::dvec2(along, -10), {10, along}, {-along, 10}, {-10, -along}};
    square.push_back(sides.at(static_cast<size_t>(i) / 10));
  }
  Polyline bulged = square;
  for (glm::dvec2& p : bulged)
    if (p.x > 9.9 && std::abs(p.y) < 7) p.x += 6 - std::abs(p.y) / 2;
  const std::vector<Polyline> contours = {square, bulged};
  const auto carry = [](const glm::dvec2& p) { return Polyline{p, p}; };
  const auto left_error = [&](const Onlooker& onlooker) {
    const Fit fit = fit_part(square, contours, 0, carry, {}, onlooker);
    double most = 0;
    for (const glm::dvec2& p : fit.outlines[1])
      if (p.x < 0) most = std::max(most, nearest_point(bulged, p).distance);
    return most;
  };
  const Onlooker left{[&](size_t f, const Polyline& moved) {
                        double sum = 0;
                        for (const glm::dvec2& p : moved)
                          if (p.x < 0) sum += nearest_point(contours[f], p).distance;
                        return sum;
                      },
                      [](size_t, const glm::dvec2& p) { return p.x < 5; }};
  EXPECT_LE(left_error(left), left_error({}));
  EXPECT_LT(left_error(left), 0.3);
}

TEST(PolypostorFit, FollowsTheOutlineWhereTheMotionIsUnknown) {
  // A bar that grows longer, while its carried points stay: the polygon must take the length from the outline.
  std::vector<Polyline> contours;
  for (const double half : {8.0, 9.5, 11.0}) {
    const Polyline bar = {{-half, -4}, {half, -4}, {half, 4}, {-half, 4}};
    contours.push_back(trace_contour(rasterise(triangles_of(bar))));
  }
  const Fit fit = fit_part(contours[0], contours, 0, [](const glm::dvec2& p) { return Polyline(3, p); }, {});
  for (size_t f = 0; f < 3; ++f) {
    EXPECT_LT(fit.errors[f], 0.25) << f;
    const auto [left, right] = std::minmax_element(fit.poses[f].begin(), fit.poses[f].end(),
                                                   [](const auto& a, const auto& b) { return a.x < b.x; });
    EXPECT_NEAR(right->x - left->x, 2 * (8 + 1.5 * static_cast<double>(f)), 2.5) << f;
    EXPECT_EQ(inverted_triangles(fit.poses[f], fit.triangles), 0U);
  }
}

TEST(PolypostorFit, NoTriangleIsInvertedWhateverTheOutlinesDo) {
  size_t repaired = 0;
  for (uint64_t seed = 0; seed < 25; ++seed) {
    std::vector<Polyline> contours;
    for (uint64_t f = 0; f < 6; ++f) contours.push_back(wobbly_circle(31 * seed + f, 30, 0));
    // The motion turns the wrong way, so that correspondences disagree with it.
    const auto carry = [&](const glm::dvec2& p) {
      Polyline out;
      for (size_t f = 0; f < 6; ++f) out.push_back(turned(p, -1.1 * static_cast<double>(f)));
      return out;
    };
    FitOptions options;
    options.corners = 10;
    options.quantum = 0.05;
    const Fit fit = fit_part(contours[seed % 6], contours, seed % 6, carry, options);
    ASSERT_FALSE(fit.triangles.empty());
    EXPECT_EQ(fit.triangles.size(), fit.polygon.size() - 2);
    for (const Polyline& pose : fit.poses) EXPECT_EQ(inverted_triangles(pose, fit.triangles), 0U) << seed;
    repaired += fit.repaired;
  }
  EXPECT_GT(repaired, 0U) << "or nothing was put to the test";
}

TEST(PolypostorFit, PartsThatVanishAreOnePointThere) {
  const Polyline square = {{-6, -6}, {6, -6}, {6, 6}, {-6, 6}};
  const Polyline contour = trace_contour(rasterise(triangles_of(square)));
  const Fit fit = fit_part(contour, std::vector<Polyline>{contour, {}, contour, {}}, 2,
                           [](const glm::dvec2& p) { return Polyline(4, p); }, {});
  ASSERT_GE(fit.polygon.size(), 4U);
  for (const size_t f : {1U, 3U})
    for (const glm::dvec2& p : fit.poses[f]) EXPECT_EQ(p, fit.poses[f][0]) << "draws nothing";
  EXPECT_LT(glm::length(fit.poses[1][0]), 1.0) << "in its middle";
  EXPECT_EQ(fit.poses[0], fit.poses[2]);
}

}  // namespace
}  // namespace crowdbench::renderers
