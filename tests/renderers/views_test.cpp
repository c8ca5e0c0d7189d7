#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "renderers/impostor/views/view_grid.h"
#include "renderers/impostor/views/view_options.h"

namespace crowdbench::renderers {
namespace {

constexpr double kDegrees = std::numbers::pi / 180;

glm::dvec3 direction(double azimuth_deg, double elevation_deg) {
  const double a = azimuth_deg * kDegrees;
  const double e = elevation_deg * kDegrees;
  return {std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)};
}

ViewGrid grid(const std::string& text, double el_min_deg = 0) {
  return parse_view_grid(text, el_min_deg * kDegrees, "views");
}

// The nearest by comparing with all.
double least_angle(const ViewGrid& g, const glm::dvec3& d) {
  double best = 10;
  for (int v = 0; v < g.size(); ++v) {
    const glm::dvec3 s = g.basis(v).to_eye;
    best = std::min(best, std::atan2(glm::length(glm::cross(d, s)), glm::dot(d, s)));
  }
  return best;
}

TEST(ViewGrid, CountsViews) {
  EXPECT_EQ(grid("sphere-17x8").size(), 136);
  EXPECT_EQ(grid("cube-4").size(), 96);
  EXPECT_EQ(grid("hemi-12").size(), 144);
}

TEST(ViewGrid, TextAndParserAgree) {
  for (const char* text : {"sphere-17x8", "sphere-17x8-mirrored", "cube-4", "hemi-12"})
    EXPECT_EQ(grid(text).text(), text);
  for (const char* text : {"", "sphere", "sphere-", "sphere-17", "sphere-x8", "sphere-0x8", "sphere-17x8x", "cube-0",
                           "cube-1e3", "hemi-1", "octa-4", "sphere-17x8-mirror"})
    EXPECT_THROW(grid(text), Error) << text;
}

TEST(ViewGrid, AzimuthZeroIsTheFrontAndGrowsTowardsTheLeft) {
  const ViewGrid g = grid("sphere-4x2");
  EXPECT_NEAR(glm::distance(g.basis(0).to_eye, glm::dvec3(0, 0, 1)), 0, 1e-15);
  EXPECT_NEAR(glm::distance(g.basis(1).to_eye, glm::dvec3(1, 0, 0)), 0, 1e-15);  // the character's left is +X
  EXPECT_NEAR(glm::distance(g.basis(0).right, glm::dvec3(1, 0, 0)), 0,
              1e-15);  // seen from the front, its left is right
  for (int v = 4; v < 8; ++v) EXPECT_NEAR(g.basis(v).to_eye.y, 1, 1e-15) << "the last row is the pole";
}

TEST(ViewGrid, BasesAreRightHandedAndUpright) {
  for (const char* text : {"sphere-17x8", "sphere-9x5-mirrored", "cube-3", "hemi-7"}) {
    const ViewGrid g = grid(text);
    for (int v = 0; v < g.size(); ++v) {
      const ViewBasis b = g.basis(v);
      EXPECT_NEAR(glm::length(b.to_eye), 1, 1e-12);
      EXPECT_NEAR(glm::distance(glm::cross(b.right, b.up), b.to_eye), 0, 1e-12) << text << " view " << v;
      EXPECT_NEAR(b.right.y, 0, 1e-12) << "tiles do not roll";
      EXPECT_GE(b.up.y, -1e-12);
    }
  }
}

TEST(ViewGrid, SamplesPickThemselves) {
  for (const char* text : {"sphere-17x8", "sphere-9x5-mirrored", "cube-3", "hemi-7", "hemi-12"}) {
    const ViewGrid g = grid(text);
    for (int v = 0; v < g.size(); ++v) {
      if (!g.reachable(v)) continue;
      // All samples of the pole row, and of the rim of the half-octahedron, stand for one direction each; the angle is
      // what counts.
      EXPECT_LT(view_error(g, g.basis(v).to_eye), 1e-7) << text << " view " << v;
    }
  }
}

TEST(ViewGrid, SpherePickIsTheNearestOfAll) {
  for (const char* text : {"sphere-17x8", "sphere-5x3", "sphere-32x9", "sphere-8x1"}) {
    const ViewGrid g = grid(text);
    for (uint64_t i = 0; i < 4000; ++i) {
      const double y = random_unit(7, i, 1);
      const double azimuth = 360 * random_unit(7, i, 2);
      const glm::dvec3 d = direction(azimuth, std::asin(y) / kDegrees);
      EXPECT_NEAR(view_error(g, d), least_angle(g, d), 1e-9) << text << " " << d.x << " " << d.y << " " << d.z;
    }
  }
}

TEST(ViewGrid, CellPicksAreCloseToTheNearest) {
  for (const char* text : {"cube-4", "hemi-12"}) {
    const ViewGrid g = grid(text);
    double worst = 0;
    for (uint64_t i = 0; i < 4000; ++i) {
      const double y = random_unit(7, i, 1);
      const glm::dvec3 d = direction(360 * random_unit(7, i, 2), std::asin(y) / kDegrees);
      worst = std::max(worst, view_error(g, d) - least_angle(g, d));
    }
    EXPECT_LT(worst, 5 * kDegrees) << text;
  }
}

// Half a step in azimuth on the horizon and half a step in elevation, on the sphere's lowest cell: the farthest corner
// of a cell between rows 0 and 1 lies where it is as far from both rows' samples.
TEST(ViewGrid, LargestErrorAgreesWithGeometry) {
  const ViewGrid g = grid("sphere-16x1");
  // One row on the horizon: the pole is 90 degrees from every sample.
  EXPECT_NEAR(compute_view_errors(g).largest, 90 * kDegrees, 1.5 * kDegrees);
  const ViewGrid two = grid("sphere-12x7");  // 30 degrees by 15
  // The corner (15 degrees, e) at equal distance from rows 0 and 15: by symmetry of the great circle through the two
  // samples of one azimuth it lies at 7.5 degrees along it, and 15 degrees of azimuth away at that elevation.
  const double half_azimuth = 15 * kDegrees;
  double corner = 0;
  for (double e = 0; e < 15; e += 0.01) {
    const glm::dvec3 d = direction(15, e);
    const double low = std::acos(glm::dot(d, direction(0, 0)));
    const double high = std::acos(glm::dot(d, direction(0, 15)));
    corner = std::max(corner, std::min(low, high));
  }
  EXPECT_GT(corner, half_azimuth);
  EXPECT_NEAR(compute_view_errors(two, 200000).largest, corner, 0.1 * kDegrees);
}

TEST(ViewGrid, LowestElevationIsKeptTo) {
  const ViewGrid g = grid("sphere-8x4", -30);  // rows at -30, 10, 50, 90
  EXPECT_NEAR(std::asin(g.basis(0).to_eye.y), -30 * kDegrees, 1e-12);
  EXPECT_NEAR(std::asin(g.basis(8).to_eye.y), 10 * kDegrees, 1e-12);
  const ViewGrid level = grid("sphere-8x4");
  EXPECT_EQ(level.pick(direction(45, -60)), level.pick(direction(45, 0))) << "directions below are raised";
  const ViewGrid cube = grid("cube-4");
  int reachable = 0;
  for (int v = 0; v < cube.size(); ++v) reachable += cube.reachable(v);
  EXPECT_EQ(reachable, 16 + 4 * 8) << "the top and the upper halves of the sides";
  for (uint64_t i = 0; i < 4000; ++i) {
    const glm::dvec3 d = direction(360 * random_unit(3, i, 1), 180 * random_unit(3, i, 2) - 90);
    EXPECT_TRUE(cube.reachable(cube.pick(d).view));
    EXPECT_LT(grid("hemi-9").pick(d).view, 81);
  }
}

TEST(ViewGrid, AMirroredGridCoversTheTurnWithHalfOfIt) {
  const ViewGrid g = grid("sphere-17x8-mirrored");
  EXPECT_NEAR(std::atan2(g.basis(1).to_eye.x, g.basis(1).to_eye.z), 11.25 * kDegrees, 1e-12);
  EXPECT_NEAR(std::atan2(g.basis(16).to_eye.x, g.basis(16).to_eye.z), 180 * kDegrees, 1e-12);
  const ViewPick right = g.pick(direction(-50, 20));
  EXPECT_TRUE(right.mirrored);
  EXPECT_EQ(right.view, g.pick(direction(50, 20)).view);
  EXPECT_LT(compute_view_errors(g).largest, 9 * kDegrees);
}

TEST(ViewGrid, ABlendIsItsViewThereAndTheMeanOfThreeBetween) {
  for (const char* text : {"sphere-17x8", "sphere-9x5-mirrored", "cube-4", "cube-3", "hemi-12"}) {
    const ViewGrid g = grid(text);
    for (int v = 0; v < g.size(); ++v) {
      if (!g.reachable(v)) continue;
      const glm::dvec3 d = g.basis(v).to_eye;
      const ViewBlend b = g.blend(d);
      double there = 0;
      for (size_t i = 0; i < 3; ++i)
        if (glm::distance(g.basis(b.views[i]).to_eye, d) < 1e-9) there += b.weights[i];
      EXPECT_NEAR(there, 1, 1e-9) << text << " view " << v;
    }
    for (uint64_t i = 0; i < 4000; ++i) {
      const double y = random_unit(9, i, 1);
      glm::dvec3 d = direction(360 * random_unit(9, i, 2), std::asin(y) / kDegrees);
      const ViewBlend b = g.blend(d);
      if (b.mirrored) d.x = -d.x;
      double sum = 0;
      glm::dvec3 mean(0.0);
      for (size_t k = 0; k < 3; ++k) {
        ASSERT_TRUE(b.views[k] >= 0 && b.views[k] < g.size() && g.reachable(b.views[k])) << text;
        EXPECT_GE(b.weights[k], -1e-12);
        sum += b.weights[k];
        mean += b.weights[k] * g.basis(b.views[k]).to_eye;
      }
      EXPECT_NEAR(sum, 1, 1e-12);
      // A cube of even n has no views on the horizon: below its lowest row that row stands alone.
      if (text[0] == 'c' && d.y < 0.25 * std::max(std::abs(d.x), std::abs(d.z))) continue;
      // Linear weights on a curved grid: the mean of the views' directions is the direction, to a quarter of a step.
      const double off = std::atan2(glm::length(glm::cross(d, mean)), glm::dot(d, mean));
      EXPECT_LT(off, (text[0] == 'c' ? 9 : 6) * kDegrees) << text << " " << d.x << " " << d.y << " " << d.z;
    }
  }
}

// What a step of a hundredth of a degree may change: nothing but the weights, by little.
TEST(ViewGrid, ABlendChangesContinuously) {
  for (const char* text : {"sphere-17x8", "cube-4", "hemi-12"}) {
    const ViewGrid g = grid(text);
    double worst = 0;
    for (uint64_t i = 0; i < 20000; ++i) {
      const double y = 0.99 * random_unit(4, i, 1);
      const double azimuth = 360 * random_unit(4, i, 2);
      const double elevation = std::asin(y) / kDegrees;
      const auto a = g.blend(direction(azimuth, elevation));
      const auto b = g.blend(direction(azimuth + 0.01, elevation + 0.005));
      // Where three faces meet, the cells of a cube have no fourth corner.
      const glm::dvec3 d = glm::abs(direction(azimuth, elevation));
      if (text[0] == 'c' && std::min({d.x, d.y, d.z}) > 0.7 * std::max({d.x, d.y, d.z})) continue;
      std::vector<double> change(static_cast<size_t>(g.size()));
      for (size_t k = 0; k < 3; ++k) {
        change[static_cast<size_t>(a.views[k])] += a.weights[k];
        change[static_cast<size_t>(b.views[k])] -= b.weights[k];
      }
      for (const double c : change) worst = std::max(worst, std::abs(c));
    }
    EXPECT_LT(worst, 0.01) << text;
  }
}

TEST(ViewGrid, StepsBetweenNeighboursAndTheGridThatMeetsALimit) {
  EXPECT_NEAR(compute_view_steps(grid("sphere-17x8")).largest, 360.0 / 17 * kDegrees, 1e-9);
  EXPECT_NEAR(compute_view_steps(grid("sphere-17x8-mirrored")).largest, 90.0 / 7 * kDegrees, 1e-9)
      << "11.25 degrees of azimuth, 12.86 of elevation";
  // Four views at the quarters of the horizon, 90 degrees apart, and the pole.
  EXPECT_NEAR(compute_view_steps(grid("sphere-4x2")).mean, 90 * kDegrees, 1e-9);
  EXPECT_EQ(grid_for_step(grid("sphere-17x8"), 6 * kDegrees).text(), "sphere-60x16");
  EXPECT_EQ(grid_for_step(grid("sphere-17x8-mirrored"), 6 * kDegrees).text(), "sphere-31x16-mirrored");
  for (const char* text : {"sphere-17x8", "sphere-17x8-mirrored", "cube-4", "hemi-12"}) {
    const ViewGrid met = grid_for_step(grid(text), 10 * kDegrees);
    EXPECT_LE(compute_view_steps(met).largest, 10 * kDegrees * (1 + 1e-9)) << met.text();
    ViewGrid less = met;
    --(met.kind == GridKind::sphere ? less.azimuths : less.n);
    EXPECT_GT(compute_view_steps(less).largest, 10 * kDegrees) << less.text();
  }
}

TEST(ViewGrid, ZeroVectorPicksSomeView) {
  for (const char* text : {"sphere-17x8", "cube-4", "hemi-12"}) {
    const ViewGrid g = grid(text);
    const int view = g.pick({0, 0, 0}).view;
    EXPECT_GE(view, 0);
    EXPECT_LT(view, g.size());
  }
}

// ---- the grid as options

ViewGrid grid_of(const std::string& spec) {
  const RepresentationType stores{"stores", "", {views_option(), el_min_option()}, {}};
  return read_view_grid(OptionReader(stores, parse_spec(spec, {stores})));
}

TEST(ViewOptions, AreReadIntoTheGrid) {
  EXPECT_EQ(grid_of("stores").text(), "sphere-17x8");
  EXPECT_EQ(grid_of("stores").el_min, 0);
  const ViewGrid cube = grid_of("stores:views=cube-4,el_min=-30");
  EXPECT_EQ(cube.text(), "cube-4");
  EXPECT_NEAR(cube.el_min, -30 * kDegrees, 1e-15);
  EXPECT_NEAR(grid_of("stores:el_min=89").el_min, 89 * kDegrees, 1e-15);
  for (const char* spec : {"stores:el_min=89.5", "stores:el_min=-90", "stores:views=octa-4"})
    EXPECT_THROW((void)grid_of(spec), Error) << spec;
}

TEST(ViewOptions, AnotherGridTakesThePlaceOfTheFirst) {
  Spec spec;
  spec.name = "stores";
  spec.options = {{"views", "cube-4"}, {"el_min", "5"}};
  const std::vector<std::pair<std::string, std::string>> wanted = {{"el_min", "5"}, {"views", "hemi-12"}};
  EXPECT_EQ(with_view_grid(spec, grid("hemi-12")).options, wanted);
}

TEST(ViewOptions, ErrorsAreInDegrees) {
  // One view, from the front: directions all round and above are a right angle away on average, and up to half a turn.
  const auto facts = view_error_facts(grid("sphere-1x1"));
  ASSERT_EQ(facts.size(), 2U);
  EXPECT_EQ(facts[0].first, "view_error_deg_mean");
  EXPECT_NEAR(facts[0].second, 90, 0.5);
  EXPECT_EQ(facts[1].first, "view_error_deg_max");
  EXPECT_NEAR(facts[1].second, 180, 2);
}

}  // namespace
}  // namespace crowdbench::renderers
