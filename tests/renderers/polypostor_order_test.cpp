// Planes of parts that are moved until what is drawn in front is what lies in front.
#include "renderers/polypostor/polypostor_order.h"

#include <gtest/gtest.h>

#include <vector>

namespace crowdbench::renderers {
namespace {

// Squares that face the eye, ten texels wide, of 1 metre each: by part, at these heights.
struct Squares {
  PolypostorPlan plan;
  PolypostorTier tier;
  std::vector<glm::dvec3> positions;

  explicit Squares(const std::vector<double>& heights) {
    plan.texel = 1;
    plan.eye = 1e6;
    plan.sphere.radius = 64;
    for (const double z : heights) add(z, false);
  }
  void add(double z, bool turned) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), {{0, 0, z}, {10, 0, z}, {10, 10, z}, {0, 10, z}});
    std::vector<uint32_t> corners = {first, first + 1, first + 2, first, first + 2, first + 3};
    if (turned) std::swap(corners[1], corners[2]), std::swap(corners[4], corners[5]);
    tier.corners.push_back(corners);
    tier.two_sided.push_back({0, 0});
  }
  std::vector<double> ordered(const std::vector<double>& heights) const {
    std::vector<TilePlane> planes;
    for (const double z : heights) planes.push_back({0, 0, z});
    order_planes(plan, tier, positions, planes);
    std::vector<double> out;
    for (const TilePlane& plane : planes) out.push_back(plane.height);
    return out;
  }
};

TEST(PolypostorOrder, PutsInFrontWhatLiesInFront) {
  const std::vector<double> planes = Squares({5, 2}).ordered({0, 2});
  EXPECT_GT(planes[0], planes[1]) << "the first part bulges beyond its own plane";
  EXPECT_LT(planes[0] - planes[1], 2 * depth_unit(Squares({}).plan)) << "and no farther than it takes";
}

TEST(PolypostorOrder, LeavesWhatIsRightAndWhatIsOutOfReach) {
  EXPECT_EQ(Squares({5, 2}).ordered({4, 1}), (std::vector<double>{4, 1}));
  EXPECT_EQ(Squares({5, 2}).ordered({-40, 2}), (std::vector<double>{-40, 2})) << "farther than units may move it";
}

TEST(PolypostorOrder, LeavesPartsThatShareTheirSurface) {
  EXPECT_EQ(Squares({3, 3}).ordered({0, 2}), (std::vector<double>{0, 2}));
}

TEST(PolypostorOrder, InsidesDoNotLieInFront) {
  Squares squares({2});
  squares.add(5, true);  // nearer to the eye, but seen from behind
  const std::vector<double> planes = squares.ordered({2, 4});
  EXPECT_GT(planes[0], planes[1]);
}

TEST(PolypostorOrder, MovesAlongTheRayFromTheEye) {
  const Squares squares({0});
  PolypostorPlan plan = squares.plan;
  plan.eye = 100;
  const glm::dvec3 p = on_plane(plan, {0.5, 0, 10}, {8, 4});
  EXPECT_NEAR(p.z, 10 + 0.5 * p.x, 1e-9) << "on the plane";
  EXPECT_NEAR(p.x * 100 / (100 - p.z), 8, 1e-9) << "seen where it is to be";
  EXPECT_NEAR(p.y * 100 / (100 - p.z), 4, 1e-9);
}

}  // namespace
}  // namespace crowdbench::renderers
