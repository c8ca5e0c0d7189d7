// The bake against solids whose depth is known: no OpenGL, no mesh renderer.
#include "renderers/relief/relief_bake.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderers/relief/relief_atlas.h"
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

// A frustum of radius 0.3 to 0.5 and height 1, along its axis (1): its wall rises 5 in 1, so texel centres next to each
// other lie up to five texels apart in depth. One surface crosses between them, hence their intervals must meet.
TEST(ReliefBake, SteepWallsAreWholeInEveryMap) {
  const ReliefModel m = bake_relief(testing::tube(0.3, 0.5, 1.0, 128), {.map_size = 64});
  ASSERT_EQ(m.boxes.size(), 1U);
  int pairs = 0;
  int wide = 0;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u + 1 < 64; ++u) {
      const uint16_t* a = depth_at(m, 0, 1, u, v);
      const uint16_t* b = depth_at(m, 0, 1, u + 1, v);
      if (a[0] > a[1] || b[0] > b[1]) continue;
      ++pairs;
      const int gap = std::max(int{a[0]}, int{b[0]}) - std::min(int{a[1]}, int{b[1]});
      // One code is what rounding leaves.
      wide += gap > 1 ? 1 : 0;
    }
  }
  EXPECT_GT(pairs, 400);
  EXPECT_EQ(wide, 0);
  // The ring has no gap either: on every line through the middle both walls are there.
  for (const int line : {20, 32, 44}) {
    int walls = 0;
    bool inside = false;
    for (int u = 0; u < 64; ++u) {
      const uint16_t* d = depth_at(m, 0, 1, u, line);
      const bool covered = d[0] <= d[1];
      walls += covered && !inside ? 1 : 0;
      inside = covered;
    }
    EXPECT_EQ(walls, 2) << line;
  }
}

// A plate that rises both ways: diagonal neighbours share one corner of it, the highest of one and the lowest of the
// other, equal but for rounding. A ray may step from one to the other, so these must meet as well.
TEST(ReliefBake, DiagonalNeighboursOfASlopingPlateMeet) {
  Character c = box({1.0F, 1.0F, 0.0F});
  // Turned and sheared, so that a depth at a corner is rounded differently on its two sides.
  c.mesh.indices = {0, 2, 1, 1, 2, 3};
  c.mesh.primitives[0].index_count = 6;
  for (glm::vec3& p : c.mesh.positions) p = {p.x + 0.3F * p.y, p.y - 0.1F * p.x, 0.7F * p.x + 0.9F * p.y};
  const ReliefModel m = bake_relief(c, {.map_size = 64});
  int apart = 0;
  int pairs = 0;
  for (int v = 0; v + 1 < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      for (const int to : {u - 1, u + 1}) {
        if (to < 0 || to >= 64) continue;
        const uint16_t* a = depth_at(m, 0, 2, u, v);
        const uint16_t* b = depth_at(m, 0, 2, to, v + 1);
        if (a[0] > a[1] || b[0] > b[1]) continue;
        ++pairs;
        apart += std::max(a[0], b[0]) - std::min(a[1], b[1]) > 1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(pairs, 5000);
  EXPECT_EQ(apart, 0);
}

// Seen along a wall that is exactly upright, no texel centre is covered: the map holds the wall all the same.
TEST(ReliefBake, UprightWallIsNotLost) {
  const ReliefModel m = bake_relief(testing::tube(0.5, 0.5, 1.0, 64), {.map_size = 32});
  int covered = 0;
  for (int v = 0; v < 32; ++v)
    for (int u = 0; u < 32; ++u) {
      const uint16_t* d = depth_at(m, 0, 1, u, v);
      if (d[0] > d[1]) continue;
      ++covered;
      EXPECT_NEAR(std::hypot(u + 0.5 - 16, v + 0.5 - 16), 15.5, 1.5) << u << ' ' << v;
      EXPECT_LT(d[0], 65535 * 0.5 / 32 + 2) << "as low as the wall";
      EXPECT_GT(d[1], 65535 * 31.5 / 32 - 2) << "as high";
    }
  EXPECT_GT(covered, 90) << "a circle of 31 texels across is 97 around";
}

// Property: whatever a map stores lies within what the three axes' bounds leave of the box, at every level. A surface
// outside would be cut away.
TEST(ReliefAtlas, BoundsHoldEverySurface) {
  for (const Character& c : {sphere(0.5, 32), testing::tube(0.2, 0.5, 1.0, 48), testing::fork()}) {
    const ReliefModel m = bake_relief(c, {.map_size = 32});
    const AtlasPlan plan = plan_atlas(m);
    const Atlas atlas = fill_atlas(m, plan);
    const auto n = size_t{32};
    for (uint32_t level = 0; level < atlas_levels(32); ++level) {
      const size_t half = n >> (level + 1);
      const size_t aside = level == 0 ? 0 : n - (n >> (level - 1));
      const size_t top = (plan.top[0] + (level == 0 ? 0 : n)) / 2;
      const auto within = [&](int axis, double u, double v, double depth) {
        const auto cell = [&](double x) {
          return std::min(static_cast<size_t>(x * static_cast<double>(half)), half - 1);
        };
        const size_t at = ((top + cell(v)) * static_cast<size_t>(plan.width / 2) +
                           (plan.left[0] + static_cast<size_t>(axis) * n + aside) / 2 + cell(u)) *
                          2;
        return depth * 255 >= atlas.bounds[at] && depth * 255 <= atlas.bounds[at + 1];
      };
      int tested = 0;
      int outside = 0;
      for (int axis = 0; axis < 3; ++axis)
        for (int v = 0; v < 32; ++v)
          for (int u = 0; u < 32; ++u) {
            const uint16_t* d = depth_at(m, 0, axis, u, v);
            if (d[0] > d[1]) continue;
            for (const int side : {0, 1}) {
              std::array<double, 3> p{};
              p[static_cast<size_t>((axis + 1) % 3)] = (u + 0.5) / 32;
              p[static_cast<size_t>((axis + 2) % 3)] = (v + 0.5) / 32;
              p[static_cast<size_t>(axis)] = d[side] / 65535.0;
              // A candidate of the search lies up to half a texel of the level beside the surface.
              for (const double du : {-0.5, 0.0, 0.5}) {
                for (const double dv : {-0.5, 0.0, 0.5}) {
                  std::array<double, 3> q = p;
                  const auto beside = [&](double& x, double by) {
                    x = std::clamp(x + by * (1 << level) / 32, 0.0, 1.0);
                  };
                  beside(q[static_cast<size_t>((axis + 1) % 3)], du);
                  beside(q[static_cast<size_t>((axis + 2) % 3)], dv);
                  for (size_t other = 0; other < 3; ++other)
                    outside +=
                        within(static_cast<int>(other), q[(other + 1) % 3], q[(other + 2) % 3], q[other]) ? 0 : 1;
                }
              }
              ++tested;
            }
          }
      EXPECT_GT(tested, 100);
      EXPECT_EQ(outside, 0) << "level " << level;
    }
  }
}

// Between the prongs of a fork both other axes' maps are empty: that is known to be air, at the finest level.
TEST(ReliefAtlas, BoundsLeaveAirBetweenSurfacesOut) {
  const ReliefModel m = bake_relief(testing::fork(), {.map_size = 64});
  const AtlasPlan plan = plan_atlas(m);
  const Atlas atlas = fill_atlas(m, plan);
  // Axis 0 runs from prong to prong: its own map is solid in between.
  const uint16_t* along = depth_at(m, 0, 0, 32, 32);
  EXPECT_LT(along[0], 0.1 * 65535);
  EXPECT_GT(along[1], 0.9 * 65535);
  // Axis 2 looks through: (u, v) = (x, y), the middle of the gap.
  const size_t at =
      ((plan.top[0] / 2 + 16) * static_cast<size_t>(plan.width / 2) + (plan.left[0] + 2 * 64) / 2 + 16) * 2;
  EXPECT_GT(atlas.bounds[at], atlas.bounds[at + 1]);
}

// The code in the middle of a face's map at level 1, in the picture.
int code_at_level_1(const ReliefModel& m) {
  const AtlasPlan plan = plan_atlas(m);
  const Atlas atlas = fill_atlas(m, plan);
  const auto n = static_cast<size_t>(m.boxes[0].texels);
  const size_t middle = (plan.top[0] + n + n / 4) * 2 * static_cast<size_t>(plan.width) + 2 * plan.left[0] + n / 4;
  return atlas.colour[middle * 4];
}

// A texture of black and white squares, as many as there are texels of the map, is linear 0.5 at the next level, code
// 188; a mean of codes would be 128.
TEST(ReliefAtlas, CoarserColoursFilterTexturesInLinearLight) {
  Character checked = box({1, 1, 1});
  scene::Texture& checks = checked.images.emplace_back();
  checks.image = Image8(16, 16, 4);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 4; ++c) checks.image.at(x, y)[c] = c == 3 || (x + y) % 2 == 0 ? 255 : 0;
  checked.materials[0].base_colour = {1, 1, 1, 1};
  checked.materials[0].base_colour_image = 0;
  checked.mesh.uvs.clear();
  for (const glm::vec3& p : checked.mesh.positions) checked.mesh.uvs.emplace_back(p.x + p.z, p.y + p.z);
  EXPECT_NEAR(code_at_level_1(bake_relief(checked, {.map_size = 16})), 188, 1);
}

// Of two materials without textures every texel of every level shows one, as every pixel of the mesh does.
TEST(ReliefAtlas, CoarserColoursMixNoMaterials) {
  Character two = box({1, 1, 1});
  two.materials.push_back(two.materials[0]);
  two.materials[0].base_colour = {1, 1, 1, 1};
  two.materials[1].base_colour = {0, 0, 0, 1};
  const scene::Primitive whole = two.mesh.primitives[0];
  two.mesh.primitives.clear();
  for (uint32_t t = 0; t < whole.index_count / 3; ++t) {
    scene::Primitive& one = two.mesh.primitives.emplace_back(whole);
    one.first_index = whole.first_index + 3 * t;
    one.index_count = 3;
    one.material = static_cast<int>(t % 2);
  }
  const ReliefModel model = bake_relief(two, {.map_size = 16});
  size_t black = 0;
  size_t white = 0;
  for (size_t i = 0; i < model.colour.size(); i += 4) {
    black += model.colour[i] == 0 ? 1 : 0;
    white += model.colour[i] == 255 ? 1 : 0;
  }
  EXPECT_EQ(black + white, model.colour.size() / 4);
  EXPECT_GT(std::min(black, white), model.colour.size() / 16) << "every face has a triangle of each";
}

TEST(ReliefBake, NominalBytesAreThePublishedFigures) {
  EXPECT_EQ(relief_nominal_bytes(53, 128), 41'680'896U);
  EXPECT_EQ(relief_nominal_bytes(40, 64), 7'864'320U);
}

}  // namespace
}  // namespace crowdbench::renderers
