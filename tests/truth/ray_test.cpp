// Rays against triangles: nothing passes between those that share an edge, and the hierarchy finds what trying all of
// them finds.
#include "truth/ray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/random.h"
#include "tests/support/sanitized.h"
#include "truth/bvh.h"

namespace crowdbench::truth {
namespace {

struct Solid {
  std::vector<glm::dvec3> positions;
  std::vector<uint32_t> indices;
};

const auto any = [](uint32_t, const TriangleHit&) { return true; };
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double uniform(uint64_t index, uint64_t purpose) { return random_unit(11, index, purpose); }

glm::dvec3 random_point(uint64_t index, uint64_t purpose) {
  return glm::dvec3(uniform(index, purpose), uniform(index, purpose + 1), uniform(index, purpose + 2)) * 2.0 - 1.0;
}

TEST(TruthRay, HitsWhereItShouldByHand) {
  const glm::dvec3 a(0, 0, -4);
  const glm::dvec3 b(2, 0, -4);
  const glm::dvec3 c(0, 2, -2);
  TriangleHit hit;
  // At x = 0.5, y = 0.5 of the plane z = y - 4: weights 1 - 0.25 - 0.25, 0.25, 0.25, depth 3.5.
  ASSERT_TRUE(Ray(glm::dvec3(0.5, 0.5, 0), glm::dvec3(0, 0, -1)).hits(a, b, c, hit));
  EXPECT_DOUBLE_EQ(hit.t, 3.5);
  EXPECT_DOUBLE_EQ(hit.weights.x, 0.5);
  EXPECT_DOUBLE_EQ(hit.weights.y, 0.25);
  EXPECT_DOUBLE_EQ(hit.weights.z, 0.25);
  EXPECT_FALSE(hit.back) << "counter-clockwise as the ray sees it";
  ASSERT_TRUE(Ray(glm::dvec3(0.5, 0.5, -8), glm::dvec3(0, 0, 2)).hits(a, b, c, hit));
  EXPECT_DOUBLE_EQ(hit.t, 2.25) << "in units of the direction";
  EXPECT_TRUE(hit.back);
  EXPECT_FALSE(Ray(glm::dvec3(1.5, 1.5, 0), glm::dvec3(0, 0, -1)).hits(a, b, c, hit));
  // Its corners and its edges are its own; seen edge-on it is not there.
  EXPECT_TRUE(Ray(glm::dvec3(0, 0, 0), glm::dvec3(0, 0, -1)).hits(a, b, c, hit));
  EXPECT_TRUE(Ray(glm::dvec3(1, 1, 0), glm::dvec3(0, 0, -1)).hits(a, b, c, hit));
  EXPECT_FALSE(Ray(glm::dvec3(-1, 0, -4), glm::dvec3(1, 0, 0)).hits(a, b, glm::dvec3(3, 0, -4), hit));
}

TEST(TruthRay, AnEdgeFunctionHasTheExactSign) {
  // (1 + e)(1 - e) against 1: both products round to 1, and the exact difference is -e^2.
  const double e = 0x1p-30;
  EXPECT_EQ((1 + e) * (1 - e), 1.0);
  EXPECT_EQ(edge_function(1 + e, 1 - e, 1, 1), -e * e);
  EXPECT_EQ(edge_function(1, 1, 1 + e, 1 - e), e * e);
  EXPECT_EQ(edge_function(3, 7, 7, 3), 0.0);
  EXPECT_EQ(edge_function(2, 5, 3, 3), 1.0);
}

// A sphere of triangles whose corners are no round numbers: long thin ones at its poles, 2 x rows x columns in all.
Solid sphere(int rows, int columns, const glm::dvec3& centre, double radius) {
  Solid out;
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double polar = M_PI * i / rows;
      const double around = 2 * M_PI * j / columns;
      // The poles are one point, whatever the sine of pi is.
      const double r = i == 0 || i == rows ? 0 : std::sin(polar);
      out.positions.push_back(centre +
                              radius * glm::dvec3(r * std::cos(around), std::cos(polar), r * std::sin(around)));
    }
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      for (const uint32_t corner : {at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)})
        out.indices.push_back(corner);
  return out;
}

// Rays from within, each at a corner or at a point of an edge of the solid: whatever they are off by, the solid is all
// round them. CROWDBENCH_TRUTH_RAYS says how many (1e7: 30 s).
TEST(TruthRay, NothingPassesBetweenTriangles) {
  const char* asked = std::getenv("CROWDBENCH_TRUTH_RAYS");
  const uint64_t rays = asked != nullptr ? std::stoull(asked) : support::kSanitized ? 20'000 : 200'000;
  // Near the origin, and so far out that coordinates have few bits left.
  const std::vector<Solid> solids = {sphere(12, 17, {0, 0, 0}, 1), sphere(5, 7, {1e5, -3e5, 7e4}, 0.25),
                                     sphere(2, 3, {0.1, 0.2, 0.3}, 1e-3)};
  const std::vector<glm::dvec3> centres = {{0, 0, 0}, {1e5, -3e5, 7e4}, {0.1, 0.2, 0.3}};
  const std::vector<double> radii = {1, 0.25, 1e-3};
  std::vector<Bvh> hierarchies;
  for (const Solid& solid : solids) hierarchies.emplace_back(solid.positions, solid.indices);
  uint64_t passed = 0;
  for (uint64_t i = 0; i < rays; ++i) {
    const size_t s = i % solids.size();
    const Solid& solid = solids[s];
    const auto triangle = static_cast<size_t>(random_bits(7, i, 0) % (solid.indices.size() / 3));
    const auto corner = static_cast<size_t>(random_bits(7, i, 1) % 3);
    const glm::dvec3 a = solid.positions[solid.indices[3 * triangle + corner]];
    const glm::dvec3 b = solid.positions[solid.indices[3 * triangle + (corner + 1) % 3]];
    const uint64_t place = random_bits(7, i, 2) % 4;  // a corner, the middle of an edge, or anywhere on it
    const double along = place == 0 ? 0.0 : place == 1 ? 0.5 : uniform(i, 20);
    const glm::dvec3 origin = centres[s] + 0.3 * radii[s] * random_point(i, 30) / 1.8;
    const Ray ray(origin, glm::mix(a, b, along) - origin);
    passed += hierarchies[s].closest(ray, 0, kInfinity, any).found() ? 0U : 1U;
  }
  EXPECT_EQ(passed, 0U) << "of " << rays;
}

// Small scenes of random triangles, some of them slivers and some at grazing angles: the same triangle and the same t,
// bit for bit.
TEST(TruthRay, TheHierarchyFindsWhatTryingAllFinds) {
  const int scenes = support::kSanitized ? 20 : 200;
  int hits = 0;
  for (int s = 0; s < scenes; ++s) {
    const auto seed = static_cast<uint64_t>(s);
    Solid solid;
    const uint64_t triangles = 1 + random_bits(3, seed, 0) % 60;
    for (uint64_t t = 0; t < triangles; ++t) {
      const uint64_t index = seed * 1000 + t;
      const glm::dvec3 middle = 3.0 * random_point(index, 0);
      const double size = std::exp2(-8 * uniform(index, 50));
      for (uint64_t k = 0; k < 3; ++k) {
        glm::dvec3 p = middle + size * random_point(index, 3 + 3 * k);
        if (t % 5 == 0) p.y = 0.5 * p.x;  // planes that rays run along
        if (t % 7 == 0 && k == 2) p = 0.5 * (solid.positions[solid.positions.size() - 1] + p);
        if (t % 11 == 0 && t > 0) p = solid.positions[3 * (t - 1) + k];  // the same triangle once more
        solid.positions.push_back(p);
        solid.indices.push_back(static_cast<uint32_t>(solid.indices.size()));
      }
    }
    const Bvh bvh(solid.positions, solid.indices);
    for (uint64_t r = 0; r < 500; ++r) {
      const uint64_t index = 1'000'000 + seed * 1000 + r;
      const glm::dvec3 origin = 4.0 * random_point(index, 0);
      glm::dvec3 target = 2.0 * random_point(index, 3);
      if (r % 3 == 0) target = solid.positions[random_bits(5, index, 9) % solid.positions.size()];
      glm::dvec3 direction = target - origin;
      if (r % 4 == 0) direction = {1, 0.5, 0};  // along those planes
      const Ray ray(origin, direction);
      const ClosestHit one = bvh.closest(ray, 0, kInfinity, any);
      const ClosestHit other = bvh.closest_of_all(ray, 0, kInfinity, any);
      ASSERT_EQ(one.triangle, other.triangle) << s << " " << r;
      ASSERT_EQ(one.hit.t, other.hit.t) << s << " " << r;
      hits += one.found() ? 1 : 0;
      // And with what masks refuse and with bounds.
      const auto odd = [](uint32_t triangle, const TriangleHit&) { return triangle % 2 == 1; };
      ASSERT_EQ(bvh.closest(ray, 0.5, 0.9, odd).triangle, bvh.closest_of_all(ray, 0.5, 0.9, odd).triangle);
    }
  }
  EXPECT_GT(hits, scenes * 100);
}

}  // namespace
}  // namespace crowdbench::truth
