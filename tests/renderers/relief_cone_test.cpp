// Cone maps against height fields whose cones are known by arithmetic, and against rays walked one by one.
#include "renderers/relief/relief_cone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "solids.h"

namespace crowdbench::renderers {
namespace {

struct Field {
  size_t n = 0;
  std::vector<uint16_t> depth;
  explicit Field(size_t side) : n(side), depth(side * side * 2) {
    for (size_t i = 0; i < depth.size(); i += 2) depth[i] = 65535;
  }
  void set(size_t u, size_t v, double front, double back) {
    depth[(v * n + u) * 2] = static_cast<uint16_t>(front * 65535 + 0.5);
    depth[(v * n + u) * 2 + 1] = static_cast<uint16_t>(back * 65535 + 0.5);
  }
};

// A code is the square root in 255 steps, rounded down: at ratio r a step is 2 sqrt(r) / 255 wide.
void expect_ratio(uint8_t code, double ratio) {
  EXPECT_LE(cone_ratio(code), ratio + 1e-12);
  EXPECT_GT(cone_ratio(code), ratio - 2 * std::sqrt(ratio) / 255 - 1e-12) << ratio;
}

// One rod that stands in an empty map, at u = 20 of 64, from depth 0.25 to 0.75.
TEST(ReliefCone, ThinRod) {
  constexpr size_t n = 64;
  Field field(n);
  for (size_t v = 0; v < n; ++v) field.set(20, v, 0.25, 0.75);
  const auto cones = derive_cones(field.depth.data(), n);
  for (const size_t away : {2U, 5U, 10U, 20U, 40U}) {
    const TexelCones& c = cones[32 * n + 20 + away];
    const double across = static_cast<double>(away) / n;
    // Apex at depth 1. A ray comes out of the rod's far side at once, at its top or, where it cannot get there so
    // high, as high as it can: it rises at least as much as it goes across.
    const double out = std::max(0.25, across - 1.0 / n);
    expect_ratio(c.approach_up, std::min(1.0, across / (1 - out)));
    // Apex at depth 0: the rod's end, 0.75, is what the cone must not hold.
    expect_ratio(c.leave_up, std::min(1.0, across / 0.75));
    // Rays down see the same, mirrored.
    EXPECT_EQ(c.approach_down, c.approach_up);
    EXPECT_EQ(c.leave_down, c.leave_up);
  }
  // Over the rod itself: beyond it there is nothing; toward it, no ray leaves the column of texels before its surface.
  const TexelCones& on = cones[32 * n + 20];
  EXPECT_EQ(on.leave_up, 255);
  EXPECT_EQ(on.leave_down, 255);
}

// A wedge that rises toward high u, solid down to the far side: a ray that goes in never comes out, so every cone is as
// wide as they get. (A cone without surfaces would be as narrow as the slope.)
TEST(ReliefCone, WedgeIsEnteredAtMostOnce) {
  constexpr size_t n = 64;
  Field field(n);
  for (size_t v = 0; v < n; ++v)
    for (size_t u = 0; u < n; ++u) field.set(u, v, 0.9 - 0.8 * static_cast<double>(u) / n, 1.0);
  for (const TexelCones& c : derive_cones(field.depth.data(), n)) {
    EXPECT_EQ(c.approach_up, 255);
    EXPECT_EQ(c.leave_up, 255);
  }
}

// Property: a ray that goes from anywhere beside a texel's surface, as far as its cone allows, narrowed by a texel, and
// rises at least as much as it goes across, comes out of no surface. Leaving cones hold none at all. Walked texel by
// texel, exactly.
struct Walk {
  bool touched = false;  // was in a surface
  bool came_out = false;
};
Walk walk(const Field& field, double u, double v, double c, double du, double dv, double reach, bool down) {
  const auto n = static_cast<double>(field.n);
  Walk seen;
  bool inside = false;
  double t = 0;  // gained depth
  while (t < reach) {
    const double x = (u + du * t) * n;
    const double y = (v + dv * t) * n;
    // The texel ahead, and where the ray leaves it.
    const auto cell = [](double at, double along) {
      const double rounded = std::round(at);
      if (std::abs(at - rounded) < 1e-9) return along < 0 ? rounded - 1 : rounded;
      return std::floor(at);
    };
    const double i = cell(x, du);
    const double j = cell(y, dv);
    if (i < 0 || j < 0 || i >= n || j >= n || c + t >= 1) return seen;
    double next = reach;
    if (du != 0) next = std::min(next, t + ((du > 0 ? i + 1 : i) - x) / (du * n));
    if (dv != 0) next = std::min(next, t + ((dv > 0 ? j + 1 : j) - y) / (dv * n));
    next = std::max(next, t + 1e-12);
    const uint16_t* d = field.depth.data() + (static_cast<size_t>(j) * field.n + static_cast<size_t>(i)) * 2;
    const double front = down ? 1 - d[1] / 65535.0 : d[0] / 65535.0;
    const double back = down ? 1 - d[0] / 65535.0 : d[1] / 65535.0;
    const double enters = std::max(front, c + t);
    const double leaves = std::min(back, c + next);
    const bool meets = d[0] <= d[1] && enters <= leaves;
    if (inside && !(meets && enters <= c + t)) seen.came_out = true;
    if (meets) {
      seen.touched = true;
      inside = leaves >= c + next;
      if (!inside) seen.came_out = true;
    } else {
      inside = false;
    }
    t = next;
  }
  return seen;
}

Field field_of(const scene::Character& character, int axis, int n) {
  const ReliefModel model = bake_relief(character, {.map_size = n});
  Field field(static_cast<size_t>(n));
  std::copy_n(model.depth_map(0, axis), field.depth.size(), field.depth.begin());
  return field;
}

TEST(ReliefCone, NoRayComesOutOfASurfaceInsideACone) {
  uint64_t draw = 0;
  const auto unit = [&] { return random_unit(1234, draw++, 1); };
  std::vector<Field> fields;
  for (const int axis : {0, 1, 2}) {
    fields.push_back(field_of(testing::sphere(0.5, 24), axis, 32));
    fields.push_back(field_of(testing::rod({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 0.05), axis, 32));
    fields.push_back(field_of(testing::tube(0.2, 0.5, 1.0, 32), axis, 32));
    fields.push_back(field_of(testing::fork(), axis, 32));
  }
  Field noise(32);
  for (size_t v = 0; v < 32; ++v)
    for (size_t u = 0; u < 32; ++u)
      if (unit() < 0.3) {
        const double a = unit();
        const double b = unit();
        noise.set(u, v, std::min(a, b), std::max(a, b));
      }
  fields.push_back(noise);
  int approached = 0;
  int touched = 0;
  int left = 0;
  for (const Field& field : fields) {
    const auto n = static_cast<double>(field.n);
    const auto cones = derive_cones(field.depth.data(), field.n);
    for (int ray = 0; ray < 20000; ++ray) {
      const auto i = static_cast<size_t>(unit() * n);
      const auto j = static_cast<size_t>(unit() * n);
      const size_t texel = j * field.n + i;
      const bool down = unit() < 0.5;
      const bool empty = field.depth[2 * texel] > field.depth[2 * texel + 1];
      const double front =
          empty ? 1 : (down ? 1 - field.depth[2 * texel + 1] / 65535.0 : field.depth[2 * texel] / 65535.0);
      const double back =
          empty ? 0 : (down ? 1 - field.depth[2 * texel] / 65535.0 : field.depth[2 * texel + 1] / 65535.0);
      const double u = (static_cast<double>(i) + unit()) / n;
      const double v = (static_cast<double>(j) + unit()) / n;
      const double c = unit();
      double du = 2 * unit() - 1;
      double dv = 2 * unit() - 1;
      const double flat = unit();
      du *= flat;
      dv *= flat;
      const double slope = std::max(std::abs(du), std::abs(dv));
      if (c < front) {
        const double ratio = cone_ratio(down ? cones[texel].approach_down : cones[texel].approach_up);
        const double reach = (ratio * (front - c) - 1 / n) / (slope + ratio + 1e-12);
        if (reach > 0) {
          const Walk seen = walk(field, u, v, c, du, dv, reach, down);
          EXPECT_FALSE(seen.came_out) << i << ' ' << j << " from " << c << " by " << reach;
          ++approached;
          touched += seen.touched ? 1 : 0;
        }
      }
      if (c > back) {
        const double ratio = cone_ratio(down ? cones[texel].leave_down : cones[texel].leave_up);
        const double room = ratio * (c - back) - 1 / n;
        if (room > 0) {
          const double reach = slope > ratio ? room / (slope - ratio) : 2;
          EXPECT_FALSE(walk(field, u, v, c, du, dv, reach, down).touched) << i << ' ' << j << " from " << c;
          ++left;
        }
      }
    }
  }
  EXPECT_GT(approached, 20000);
  EXPECT_GT(touched, 500) << "relaxed: rays do go into surfaces";
  EXPECT_GT(left, 20000);
}

// In the atlas every level has the cones of its own depths, at its own place.
TEST(ReliefCone, AtlasHoldsEveryLevel) {
  const ReliefModel model = bake_relief(testing::fork(), {.map_size = 32});
  const AtlasPlan plan = plan_atlas(model);
  const Atlas atlas = fill_atlas(model, plan);
  const std::vector<uint8_t> picture = derive_cones(model, plan, atlas);
  ASSERT_EQ(picture.size(), atlas.depth.size() * 2);
  for (uint32_t level = 0; level < atlas_levels(32); ++level) {
    const size_t n = size_t{32} >> level;
    const AtlasPlace place = atlas_place(plan, 0, 32, level);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto at = [&](size_t u, size_t v) {
        return ((place.top + v) * static_cast<size_t>(plan.width) + place.left + axis * 32 + u) * 2;
      };
      Field field(n);
      for (size_t v = 0; v < n; ++v)
        for (size_t u = 0; u < n; ++u)
          std::copy_n(atlas.depth.begin() + static_cast<std::ptrdiff_t>(at(u, v)), 2,
                      field.depth.begin() + static_cast<std::ptrdiff_t>((v * n + u) * 2));
      const auto cones = derive_cones(field.depth.data(), n);
      for (size_t v = 0; v < n; ++v)
        for (size_t u = 0; u < n; ++u) {
          const TexelCones& c = cones[v * n + u];
          const uint8_t* there = picture.data() + 2 * at(u, v);
          EXPECT_EQ(there[0], c.approach_up) << level << ' ' << axis;
          EXPECT_EQ(there[1], c.leave_up) << level << ' ' << axis;
          EXPECT_EQ(there[2], c.approach_down) << level << ' ' << axis;
          EXPECT_EQ(there[3], c.leave_down) << level << ' ' << axis;
        }
    }
  }
}

}  // namespace
}  // namespace crowdbench::renderers
