#include "renderers/surfel/surfel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderers/surfel/surfel_cloud.h"
#include "renderers/surfel/surfel_level.h"
#include "renderers/surfel/surfel_order.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;
using testing::walker;

// Eleven places on a line, 0 .. 10: the far end, the middle, and the quarters.
TEST(SurfelOrder, TakesTheFarthestPlaceAsByHand) {
  std::vector<SurfacePlace> line;
  for (int i = 0; i <= 10; ++i) line.push_back({{static_cast<float>(i), 0, 0}, {0, 1, 0}});
  const SurfelOrder o = order_places(line, 4);
  EXPECT_EQ(o.order, (std::vector<uint32_t>{0, 10, 5, 2}));
  EXPECT_EQ(o.radius, (std::vector<float>{10, 5, 2, 2}));
  EXPECT_EQ(o.nearest, (std::vector<uint32_t>{0, 0, 3, 3, 2, 2, 2, 2, 1, 1, 1}));
  EXPECT_EQ(order_places(line, 50).order.size(), 11U);
  EXPECT_EQ(order_places(std::vector<SurfacePlace>(3, line[0]), 3).order.size(), 1U) << "one place three times";
}

TEST(SurfelOrder, DiscsCoverWhatFacesAsTheyDo) {
  const SurfacePlace up{{0, 0, 0}, {0, 1, 0}};
  EXPECT_FLOAT_EQ(disc_distance(up, {{3, 0, 0}, {0, 1, 0}}), 3);
  EXPECT_FLOAT_EQ(disc_distance(up, {{3, 0, 0}, {0.8F, 0.6F, 0}}), 5);
  EXPECT_FLOAT_EQ(disc_distance(up, {{3, 0, 0}, {0, -1, 0}}), 30) << "the other side of a thin thing";
}

// What the radius promises, of every beginning.
TEST(SurfelCloud, EveryBeginningReachesTheWholeSurface) {
  std::vector<SurfacePlace> places;
  for (int i = 0; i < 4000; ++i) {
    const double z = 1 - (2 * i + 1) / 4000.0;
    const double a = 2.399963229728653 * i;
    const glm::vec3 n(std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z);
    places.push_back({n, n});
  }
  const SurfelOrder o = order_places(places, 500);
  ASSERT_EQ(o.order.size(), 500U);
  for (const size_t n : {20U, 100U, 500U}) {
    float worst = 0;
    for (const SurfacePlace& p : places) {
      float best = 1e9F;
      for (size_t k = 0; k < n; ++k) best = std::min(best, disc_distance(places[o.order[k]], p));
      worst = std::max(worst, best);
    }
    EXPECT_FLOAT_EQ(worst, o.radius[n - 1]) << n;
  }
  EXPECT_LT(o.radius[499], 0.55F * o.radius[99]) << "five times the points, less than half the radius";
}

TEST(SurfelCloud, LiesOnTheSurfaceAndKeepsItsMaterials) {
  const scene::Cast cast = cast_of(testing::card(2, 1, {0.5F, 0.25F, 0.125F, 1.0F}));
  const SurfelCloud cloud = make_surfel_cloud(*cast.characters[0], *cast.banks[0], 200);
  ASSERT_EQ(cloud.surfels.size(), 200U);
  int left = 0;
  for (const Surfel& s : cloud.surfels) {
    EXPECT_EQ(s.normal, glm::vec3(0, 0, 1));
    EXPECT_NEAR(s.position.z, 0, 1e-6);
    EXPECT_NEAR(s.colour.g, 0.25, 1e-6);
    EXPECT_FLOAT_EQ(s.weights.x, 1);
    left += s.position.x < 0 ? 1 : 0;
  }
  EXPECT_NEAR(left, 100, 12) << "evenly by area";
  scene::Character gone = *cast.characters[0];
  gone.materials[0].base_colour.a = 0.2F;
  gone.materials[0].alpha_cutoff = 0.5F;
  EXPECT_TRUE(make_surfel_cloud(gone, *cast.banks[0], 200).surfels.empty());
}

TEST(SurfelLevels, AreTheFewestWhoseDiscsAreSmallEnough) {
  std::vector<float> radius(200);
  for (size_t i = 0; i < 200; ++i) radius[i] = 1.0F / static_cast<float>(i + 1);
  const std::vector<SurfelLevel> levels = surfel_levels(radius);
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[0].points, 64U);
  EXPECT_EQ(levels[1].points, 128U);
  EXPECT_EQ(levels[2].points, 200U);
  EXPECT_FLOAT_EQ(static_cast<float>(levels[1].radius), 1.0F / 128);
  const SurfelRule rule{.size = 2, .cover = 1.5};
  EXPECT_EQ(surfel_level(levels, rule, 80), 0U) << "80 / 64 x 1.5 = 1.9 pixels";
  EXPECT_EQ(surfel_level(levels, rule, 90), 1U);
  EXPECT_EQ(surfel_level(levels, rule, 1e6), 2U) << "no more than there are";
  EXPECT_TRUE(surfel_levels({}).empty());
}

class SurfelGl : public GlTest {};

// From near, where discs are pixels wide, to far, where few points are drawn: no holes, and outlines within a pixel or
// two.
TEST_F(SurfelGl, ClosesTheSurfaceAtEveryDistance) {
  const auto mesh = make(walker(), "mesh");
  const auto surfel = make(walker(), "surfel:points=2048");
  Renderer renderer(context(), walker());
  for (const double distance : {3.0, 6.0, 12.0}) {
    int holes = 0;
    int inside = 0;
    for (int k = 0; k < 4; ++k) {
      scene::Frame frame = frame_of_one(distance, 1.0, 200, 200, 38);
      add_agent(frame, walker(), {0, 0, 0}, 3, 0.23 * k, 0.27F * static_cast<float>(k));
      const testing::Difference d =
          testing::difference(renderer.capture(frame, *mesh), renderer.capture(frame, *surfel));
      holes += d.holes;
      inside += d.inside;
      EXPECT_GT(d.iou, 0.8) << distance;
    }
    EXPECT_GT(inside, 30);
    EXPECT_LE(holes, inside / 500) << distance;
  }
}

}  // namespace
}  // namespace crowdbench::renderers
