// The bake against solids whose depth is known: no OpenGL, no mesh renderer.
#include "renderers/relief/relief_bake.h"

#include <gtest/gtest.h>

#include <cmath>

#include "solids.h"

namespace crowdbench::renderers {
namespace {

using scene::Character;
using testing::box;
using testing::sphere;

const uint16_t* depth_at(const ReliefModel& m, size_t b, int axis, int u, int v) {
  const auto n = static_cast<size_t>(m.boxes[b].texels);
  return m.depth_map(b, axis) + (static_cast<size_t>(v) * n + static_cast<size_t>(u)) * 2;
}

TEST(ReliefBake, SphereDepthIsTheHeightField) {
  const ReliefModel m = bake_relief(sphere(0.5, 96), {.map_size = 64});
  ASSERT_EQ(m.boxes.size(), 1U);
  // The box spans n/(n-1) of the diameter: unit radius in box coordinates.
  const double radius = 0.5 * 63.0 / 64.0;
  int covered = 0;
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int v = 0; v < 64; ++v) {
      for (int u = 0; u < 64; ++u) {
        const double x = (u + 0.5) / 64 - 0.5;
        const double y = (v + 0.5) / 64 - 0.5;
        const double h2 = radius * radius - x * x - y * y;
        const uint16_t* d = depth_at(m, 0, axis, u, v);
        if (h2 < 0) {
          EXPECT_GT(d[0], d[1]) << "outside the disc is empty";
        } else if (h2 > 0.01) {
          ++covered;
          worst = std::max(worst, std::abs(d[0] / 65535.0 - (0.5 - std::sqrt(h2))));
          worst = std::max(worst, std::abs(d[1] / 65535.0 - (0.5 + std::sqrt(h2))));
        }
      }
    }
  }
  EXPECT_GT(covered, 3 * 2500);
  // The chord of a facet lies r (1 - cos(180/96 degrees)) / cos(slope) inside the sphere; slope is 78 degrees at most
  // here.
  EXPECT_LT(worst, 0.5 * (1 - std::cos(3.14159265 / 96)) * 2 / 0.2);
}

TEST(ReliefBake, TightBoxTouchesEveryFaceHalfATexelIn) {
  const ReliefModel m = bake_relief(box({1.0F, 2.0F, 0.5F}), {.map_size = 32});
  ASSERT_EQ(m.boxes.size(), 1U);
  EXPECT_NEAR(m.boxes[0].size.x, 1.0 * 32 / 31, 1e-12);
  EXPECT_NEAR(m.boxes[0].size.y, 2.0 * 32 / 31, 1e-12);
  EXPECT_NEAR(m.boxes[0].size.z, 0.5 * 32 / 31, 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int t : {0, 15, 31}) {
      const uint16_t* d = depth_at(m, 0, axis, t, t);
      EXPECT_NEAR(d[0] / 65535.0, 0.5 / 32, 1e-5);
      EXPECT_NEAR(d[1] / 65535.0, 1 - 0.5 / 32, 1e-5);
    }
  }
  // Colour and part of any covered texel are the material's.
  EXPECT_EQ(m.normal[3], 3);
  EXPECT_EQ(m.colour[3], 0) << "lit";
  EXPECT_NEAR(m.colour[0], 188, 1);  // sRGB of linear 0.5
}

TEST(ReliefBake, FlatBoxGetsAThickness) {
  Character c = box({1.0F, 1.0F, 0.0F});
  const ReliefModel m = bake_relief(c, {.map_size = 16});
  EXPECT_GE(m.boxes[0].size.z, 1e-3 * 0.999);
  EXPECT_LE(m.boxes[0].size.z, 2e-3);
  const uint16_t* d = depth_at(m, 0, 2, 8, 8);
  EXPECT_NEAR(d[0] / 65535.0, 0.5, 1e-4);
  EXPECT_NEAR(d[1] / 65535.0, 0.5, 1e-4);
}

TEST(ReliefBake, RulesDecideWhoCaptures) {
  // Two joints; one triangle with summed weights 2 and 1.
  Character c = box({1, 1, 1});
  c.skeleton.nodes.push_back({.name = "second"});
  c.skeleton.joints.push_back({.name = "second", .node = 1});
  c.mesh.indices = {0, 2, 1};
  c.mesh.primitives[0].index_count = 3;
  c.mesh.joints[1] = glm::u16vec4(1, 0, 0, 0);
  EXPECT_EQ(bake_relief(c, {.map_size = 16, .rule = TriangleRule::dominant}).boxes.size(), 1U);
  EXPECT_EQ(bake_relief(c, {.map_size = 16, .rule = TriangleRule::any}).boxes.size(), 2U);
  EXPECT_EQ(bake_relief(c, {.map_size = 16, .rule = TriangleRule::threshold, .threshold = 0.9}).boxes.size(), 2U);
  EXPECT_EQ(bake_relief(c, {.map_size = 16, .rule = TriangleRule::threshold, .threshold = 1.1}).boxes.size(), 1U);
}

TEST(ReliefBake, IsDeterministic) {
  const Character c = sphere(0.3, 24);
  const ReliefModel a = bake_relief(c, {.map_size = 32});
  const ReliefModel b = bake_relief(c, {.map_size = 32});
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.normal, b.normal);
}

TEST(ReliefBake, NominalBytesAreThePublishedFigures) {
  EXPECT_EQ(relief_nominal_bytes(53, 128), 41'680'896U);
  EXPECT_EQ(relief_nominal_bytes(40, 64), 7'864'320U);
}

}  // namespace
}  // namespace crowdbench::renderers
