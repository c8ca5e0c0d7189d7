#include "renderers/surfel/surfel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderers/surfel/surfel_area.h"
#include "renderers/surfel/surfel_border.h"
#include "renderers/surfel/surfel_cloud.h"
#include "renderers/surfel/surfel_grid.h"
#include "renderers/surfel/surfel_level.h"
#include "renderers/surfel/surfel_order.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/renderers/solids.h"
#include "tests/support/sanitized.h"

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
  const SurfelCloud cloud = make_surfel_cloud(*cast.characters[0], *cast.banks[0], 200, 1.5);
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
  EXPECT_TRUE(make_surfel_cloud(gone, *cast.banks[0], 200, 1.5).surfels.empty());
}

// The same points whichever corner of a triangle comes first.
TEST(SurfelCloud, TakesCornersInOneOrder) {
  const scene::Cast plain = cast_of(scene::make_mannequin({.triangles = 500}));
  scene::Character turned = *plain.characters[0];
  for (auto corner = turned.mesh.indices.begin(); corner != turned.mesh.indices.end(); corner += 3)
    std::rotate(corner, corner + 1, corner + 3);
  const SurfelCloud a = make_surfel_cloud(*plain.characters[0], *plain.banks[0], 500, 1.5);
  const SurfelCloud b = make_surfel_cloud(turned, *plain.banks[0], 500, 1.5);
  ASSERT_EQ(a.surfels.size(), b.surfels.size());
  for (size_t i = 0; i < a.surfels.size(); ++i) {
    EXPECT_EQ(a.surfels[i].position, b.surfels[i].position) << i;
    EXPECT_EQ(a.surfels[i].colour, b.surfels[i].colour) << i;
  }
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
  EXPECT_EQ(surfel_level(levels, rule, 80, 2), 0U) << "80 / 64 x 1.5 = 1.9 pixels";
  EXPECT_EQ(surfel_level(levels, rule, 90, 2), 1U);
  EXPECT_EQ(surfel_level(levels, rule, 1e6, 2), 2U) << "no more than there are";
  EXPECT_TRUE(surfel_levels({}).empty());
}

TEST(SurfelLevels, UnevenOnesAreLeftOut) {
  std::vector<SurfelLevel> levels = {{64, 0.1}, {128, 0.1}, {4096, 0.1}};
  const SurfelRule rule{.size = 2, .cover = 1};
  levels[0].uneven = levels[2].uneven = 0.2;
  EXPECT_EQ(surfel_level(levels, rule, 1, 2), 1U);
  levels[1].uneven = 0.2;
  EXPECT_EQ(surfel_level(levels, rule, 1, 2), 2U) << "so many points are enough";
}

// Levels that would make a figure too large are left out where their discs are closed, not where they are thin; closed
// discs count as large as they are drawn.
TEST(SurfelLevels, ThoseThatReachTooFarOverOutlinesAreLeftOut) {
  std::vector<SurfelLevel> levels = {{64, 0.1}, {128, 0.05}, {256, 0.025}};
  const SurfelRule rule{.size = 1, .cover = 2};
  levels[0].over = 0.06;
  levels[1].over = 0.03;
  EXPECT_EQ(surfel_level(levels, rule, 4, 2), 0U) << "8 pixels tall: thin";
  levels[0].radius = levels[1].radius = 0.005;
  EXPECT_EQ(surfel_level(levels, rule, 18, 2), 0U) << "36 pixels tall: half way to closed, 0.03 too much";
  EXPECT_EQ(surfel_level(levels, rule, 32, 2), 1U);
  levels[1].radius = 0.05;
  EXPECT_EQ(surfel_level(levels, rule, 32, 2), 2U) << "0.05 x 2 x 32 = 3.2 pixels";
  levels[1].closed = 0.3;
  EXPECT_EQ(surfel_level(levels, rule, 32, 2), 1U);
}

TEST(SurfaceGrid, FindsWhatLiesWithinACell) {
  const std::vector<SurfacePlace> places = {{{0, 0, 0}}, {{0.9F, 0, 0}}, {{-0.9F, -0.2F, 0.3F}}, {{5, 0, 0}}};
  const SurfaceGrid grid(places, 1);
  std::vector<uint32_t> found;
  grid.near({0.1F, 0, 0}, [&](uint32_t i) { found.push_back(i); });
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<uint32_t>{0, 1, 2}));
}

// A square of two triangles ends at its sides and not at its diagonal, though that has vertices of its own on each.
TEST(SurfelBorder, IsWhereNoOtherTriangleIs) {
  scene::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2, 3, 4, 5};
  using Three = std::array<bool, 3>;
  EXPECT_EQ(find_borders(mesh), (std::vector<Three>{{true, true, false}, {false, true, true}}));
  mesh.indices = {0, 1, 2, 3, 4, 5, 2, 1, 0, 5, 4, 3};
  EXPECT_EQ(find_borders(mesh)[0], (Three{true, true, false})) << "the same from behind is the same square";
}

// A surfel 2 from the edge of a strip: discs up to 3 wide reach 2 to it, and with the factor that misses as many places
// of the surface as it reaches beyond.
TEST(SurfelBorder, ReachesAreFittedByCounting) {
  const auto at = [](float x) { return SheetPlace{{{x, 0, 0}, {0, 1, 0}}, 0}; };
  const std::vector<SheetPlace> surfels = {at(0)};
  const std::vector<SheetPlace> beside = {at(2), at(2.5F), at(3.5F)};
  SurfelLevel level{1, 1.5};
  const std::vector<float> reaches = find_reaches(surfels, beside, std::span(&level, 1));
  ASSERT_EQ(reaches.size(), 1U);
  EXPECT_FLOAT_EQ(reaches[0], 2);
  SheetPlace other = at(1);
  other.primitive = 1;
  EXPECT_TRUE(std::isinf(find_reaches(surfels, std::vector<SheetPlace>{other}, std::span(&level, 1))[0]));
  // On the other side the strip goes on.
  const std::vector<SheetPlace> on = {at(0), at(-1), at(-2.2F), at(-2.7F), at(-2.8F)};
  EXPECT_FLOAT_EQ(fit_reach(surfels, reaches, on, beside, 3), 1.25F) << "reaches two beside, misses two on it";
  EXPECT_FLOAT_EQ(fit_reach(surfels, reaches, on, {}, 3), 1);
}

// Discs without gaps reach over a ball's outline; of a card they end with it already.
TEST(SurfelArea, IsTheCharactersOwn) {
  const scene::Cast card = cast_of(testing::card(2, 1, {0.5F, 0.25F, 0.125F, 1.0F}));
  EXPECT_FLOAT_EQ(longest_side(*card.banks[0]), 2);
  const scene::Cast ball = cast_of(testing::sphere(0.5, 32));
  for (const SurfelLevel& level : make_surfel_cloud(*ball.characters[0], *ball.banks[0], 256, 1.5).levels) {
    EXPECT_LT(level.thin, 0.95) << level.points;
    EXPECT_GT(level.thin, 0.1) << level.points;
    EXPECT_LT(level.uneven, 0.1) << level.points;
    EXPECT_GE(level.closed, level.thin) << level.points;
    EXPECT_LE(level.closed, 1) << level.points;
    EXPECT_GE(level.over, 0) << level.points;
  }
}

class SurfelGl : public GlTest {};

// Of a character that the battery does not show, from its side: 400 of them cover what as many pictures of a large one
// do.
TEST_F(SurfelGl, FiguresOfAPixelAndATenthCoverTheirArea) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}), 10.0);
  const auto surfel = make(cast, "surfel:points=4096");
  Renderer renderer(context(), cast);
  const auto covered = [](const Capture& c) {
    return static_cast<double>(
        std::count_if(c.ids.data.begin(), c.ids.data.end(), [](uint32_t id) { return id != 0; }));
  };
  constexpr float kSideways = 0.25F;
  scene::Frame large = frame_of_one(1000.0, 0.9, 480, 480, 0.12);
  add_agent(large, cast, {0, 0, 0}, 1, 0.2, kSideways);
  const double metre = 480 / (2 * 1000 * std::tan(0.06 * 3.14159265358979 / 180));
  const double area = covered(renderer.capture(large, *make(cast, "mesh"))) / (metre * metre);
  struct Size {
    double pixels;
    int samples;  // along a pixel
  };
  for (const auto& [pixels, samples] : {Size{6, 3}, Size{1, 5}, Size{0.1, 21}}) {
    constexpr int kPixels = 96;
    const double of_pixel = 1.75 / pixels;  // metres
    const double distance = of_pixel * kPixels / (2 * std::tan(0.5 * 3.14159265358979 / 180));
    scene::Frame frame = frame_of_one(distance, 0, kPixels, kPixels, 1.0);
    const int across = pixels > 2 ? 8 : 20;
    for (int i = 0; i < across * across; ++i) {
      const double step = (kPixels - 12.0) / across * of_pixel;
      add_agent(frame, cast,
                {(i % across - across / 2) * step + 0.37 * (i * 37 % 101) / 101 * of_pixel,
                 (i / across - across / 2) * step + 0.61 * (i * 61 % 103) / 103 * of_pixel, 0},
                static_cast<uint32_t>(i + 1), 0.2, kSideways);
    }
    const Target target(context(), kPixels * samples, kPixels * samples, {.ids = true});
    renderer.draw(frame, *surfel, target);
    const double wanted = across * across * area * samples * samples / (of_pixel * of_pixel);
    EXPECT_NEAR(covered(target.read()) / wanted, 1, 0.05) << pixels << " pixels tall";
  }
}

// What discs together cover of a figure against what its mesh does, and how much of its inside they leave open: over
// eight views, from all sides and to 30 degrees above.
struct Area {
  double ratio = 0, holes = 0;
};
Area area_of(const scene::Cast& cast, Representation& surfel, double pixels) {
  const auto mesh = make(cast, "mesh");
  Renderer renderer(context(), cast);
  const double tall = static_cast<double>(longest_side(*cast.banks[0]));
  const int side = static_cast<int>(2 * pixels) + 8;
  double covered[2] = {0, 0};
  double holes = 0;
  for (int k = 0; k < 8; ++k) {
    const double distance = 12 * tall;
    scene::Frame frame = frame_of_one(distance, 0, side, side, 1);
    frame.camera.fov_y = 2 * std::atan(0.5 * side * tall / (pixels * distance));
    const double elevation = 10.0 * (k % 4) * 3.14159265358979 / 180;
    frame.camera.eye = {0, 0.5 * tall + distance * std::sin(elevation), distance * std::cos(elevation)};
    frame.camera.target = {0, 0.5 * tall, 0};
    frame.origin = frame.camera.eye;
    add_agent(frame, cast, {0.37 * k * tall / pixels, 0, 0}, 3, 0.23 * k, 0.27F * static_cast<float>(k));
    const Capture a = renderer.capture(frame, *mesh);
    const Capture b = renderer.capture(frame, surfel);
    covered[0] += static_cast<double>(testing::covered(a));
    covered[1] += static_cast<double>(testing::covered(b));
    for (int y = 1; y + 1 < side; ++y)
      for (int x = 1; x + 1 < side; ++x)
        if (*b.ids.at(x, y) == 0 && *a.ids.at(x, y) != 0 && *a.ids.at(x - 1, y) != 0 && *a.ids.at(x + 1, y) != 0 &&
            *a.ids.at(x, y - 1) != 0 && *a.ids.at(x, y + 1) != 0)
          ++holes;
  }
  return {covered[1] / covered[0], holes / covered[0]};
}

// Limbs, edges at right angles, and a ball: within a twelfth of the area at every size, and closed but for a pixel or
// two.
TEST_F(SurfelGl, FiguresOf20To240PixelsCoverTheirArea) {
  CROWDBENCH_SKIP_SANITIZED("SurfelGl.ClosesTheSurfaceAtEveryDistance");
  struct Shown {
    const char* name;
    scene::Cast cast;
  };
  const Shown all[] = {{"mannequin", cast_of(scene::make_mannequin({.triangles = 2200}), 10.0)},
                       {"boxes", cast_of(testing::two_bones())},
                       {"ball", cast_of(testing::sphere(0.5, 32))}};
  for (const Shown& shown : all) {
    const auto surfel = make(shown.cast, "surfel");
    for (const double pixels : {20.0, 30.0, 56.0, 240.0}) {
      const Area area = area_of(shown.cast, *surfel, pixels);
      EXPECT_NEAR(area.ratio, 1, 0.08) << shown.name << ", " << pixels << " pixels tall";
      EXPECT_LE(area.holes, pixels < 30 ? 0.02 : 0.01) << shown.name << ", " << pixels << " pixels tall";
    }
  }
}

// A disc whose centre lies outside of the picture reaches in.
TEST_F(SurfelGl, ReachesOverThePicturesBorder) {
  const scene::Cast cast = cast_of(testing::card(4, 4, {0.5F, 0.25F, 0.125F, 1.0F}));
  Renderer renderer(context(), cast);
  const scene::Frame frame = [&] {
    scene::Frame one = frame_of_one(1.0, 2.0, 60, 60, 20);
    add_agent(one, cast, {0, 0, 0}, 1);
    return one;
  }();
  const Capture capture = renderer.capture(frame, *make(cast, "surfel:points=256"));
  EXPECT_EQ(std::count(capture.ids.data.begin(), capture.ids.data.end(), 0U), 0);
}

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
