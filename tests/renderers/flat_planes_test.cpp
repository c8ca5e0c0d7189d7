// Where flat impostors stand and how deep: their planes, nailboards, the blend of three views, and parallel layers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/tile_capture.h"
#include "renderers/impostor/views/view_grid.h"
#include "renderers/layered/layered.h"
#include "scene/cast/cast.h"
#include "scene/pose/hidden.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/cache_folder.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_from;
using testing::iou;
using testing::make;
using testing::same_ids;
using testing::walker;
using FlatGl = testing::GlTest;

constexpr double kRadiansADegree = std::numbers::pi / 180;

TEST(FlatBake, PlanesRunThroughTheBody) {
  // A square sheet z = 0.3 x + 0.5 y about (1, 2, 3): the fit from the front is the sheet itself.
  std::vector<glm::vec3> corners;
  for (const float y : {-1.0F, 1.0F})
    for (const float x : {-1.0F, 1.0F}) corners.emplace_back(1 + x, 2 + y, 3 + 0.3F * x + 0.5F * y);
  const SurfaceMoments sheet = surface_moments(corners, {0, 1, 2, 1, 3, 2});
  EXPECT_NEAR(glm::distance(sheet.mean, glm::dvec3(1, 2, 3)), 0, 1e-6);
  EXPECT_NEAR(sheet.covariance[0][0], 1.0 / 3, 1e-6) << "variance of a uniform side of 2";
  const TilePlane front = fit_plane(sheet, {1, 2, 2}, ViewBasis{});
  EXPECT_NEAR(front.slope_x, 0.3, 1e-3);
  EXPECT_NEAR(front.slope_y, 0.5, 1e-3);
  EXPECT_NEAR(front.height, 1, 1e-3) << "the capture plane lies one metre behind it";
  // A vertical line seen from elevation e lies on a plane of slope tan(e), so that it stays upright from everywhere.
  const std::vector<glm::vec3> pole = {{-0.01F, 0, 0}, {0.01F, 0, 0}, {0.01F, 2, 0}, {-0.01F, 2, 0}};
  const double e = 40 * kRadiansADegree;
  const ViewBasis above{{1, 0, 0}, {0, std::cos(e), -std::sin(e)}, {0, std::sin(e), std::cos(e)}};
  EXPECT_NEAR(fit_plane(surface_moments(pole, {0, 1, 2, 0, 2, 3}), {0, 1, 0}, above).slope_y, std::tan(e), 1e-3);
  // From straight above its slope would be without end; it is held.
  const ViewBasis top{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  EXPECT_LE(std::abs(fit_plane(surface_moments(pole, {0, 1, 2, 0, 2, 3}), {0, 1, 0}, top).slope_y), 2);
}

// The lowest pixels of the figure: where it stands.
struct Foot {
  double x = 0, y = 0;
};

Foot foot_of(const Capture& c) {
  for (int y = c.ids.height - 1; y >= 0; --y) {
    double sum = 0;
    int n = 0;
    for (int x = 0; x < c.ids.width; ++x)
      if (*c.ids.at(x, y) != 0) {
        sum += x;
        ++n;
      }
    if (n > 0) return {sum / n, static_cast<double>(y)};
  }
  return {};
}

TEST_F(FlatGl, FeetStayWhereTheyStandFromAbove) {
  // A thin post, so that only the impostor's plane can move its foot. Stored: azimuths every 60 degrees, elevations 0,
  // 45 and 90. Seen four pixels a texel, so that the rounding of silhouettes to pixels is a quarter of one.
  scene::Character post = testing::two_bones();
  post.clips.clear();
  post.motion.clear();
  constexpr double kHalf = 0.02;
  for (glm::vec3& p : post.mesh.positions) p = {p.x * 0.2F, p.y, p.z * 0.2F};
  const scene::Cast cast = cast_of(std::move(post));
  const auto mesh = make(cast, "mesh");
  const auto fitted = make(cast, "flat:views=sphere-6x3,texels=128");
  const auto facing = make(cast, "flat:views=sphere-6x3,texels=128,plane=facing");
  Renderer renderer(context(), cast);
  constexpr double kPixelsAMetre = 480 / 1.75;
  const double texel_px = fitted->texel_metres(0) * kPixelsAMetre;
  EXPECT_NEAR(texel_px, 4, 0.5);
  const auto slide = [&](Representation& flat, double azimuth, double elevation) {
    scene::Frame frame =
        frame_from(cast, {.azimuth = azimuth, .elevation = elevation, .around = glm::dvec3(0, 0.9, 0)});
    frame.width = frame.height = 800;
    const Foot a = foot_of(renderer.capture(frame, *mesh));
    const Foot b = foot_of(renderer.capture(frame, flat));
    return std::hypot(a.x - b.x, a.y - b.y);
  };
  EXPECT_LE(slide(*fitted, 60, 45), texel_px + 1);
  // Beside a stored view: one texel and the foot's offset from the capture axis times the sine of the angular error.
  for (const auto& [azimuth, elevation] : {std::pair{84.0, 45.0}, {60.0, 60.0}, {75.0, 30.0}}) {
    const double error = 25 * kRadiansADegree;  // at most, for these three
    const double allowed = texel_px + kHalf * std::sqrt(2.0) * std::sin(error) * kPixelsAMetre + 1;
    EXPECT_LE(slide(*fitted, azimuth, elevation), allowed) << azimuth << ", " << elevation;
    EXPECT_GT(slide(*facing, azimuth, elevation), allowed) << "a plane across the view leans, and this test can see it";
  }
}

// A post with a small foot beside it, on the ground and `kFootOut` metres from the post's axis; only the foot is red.
constexpr double kFootOut = 0.36;

scene::Character post_with_foot() {
  scene::Character post = testing::two_bones();
  post.clips.clear();
  post.motion.clear();
  post.content_hash = "post with foot";
  post.mesh.colours.resize(post.mesh.positions.size());
  for (size_t i = 0; i < post.mesh.positions.size(); ++i) {
    glm::vec3& p = post.mesh.positions[i];
    const bool foot = post.mesh.joints[i].x == 0;
    post.mesh.colours[i] = foot ? glm::vec4(1, 0, 0, 1) : glm::vec4(0, 0, 0, 1);
    if (foot)
      p = {0.30F + 0.4F * p.x, 0.08F * p.y, 0.2F + 0.4F * p.z};
    else
      p = {0.3F * p.x, 2.25F * (p.y - 1), 0.3F * p.z};
  }
  return post;
}

struct RedCentre {
  double x = 0, y = 0;
  int pixels = 0;
};

RedCentre red_centre(const Capture& c) {
  RedCentre red;
  for (int y = 0; y < c.ids.height; ++y)
    for (int x = 0; x < c.ids.width; ++x) {
      const uint8_t* p = c.colour.at(x, y);
      if (*c.ids.at(x, y) == 0 || p[0] < 3 * p[1] + 40) continue;
      red.x += x;
      red.y += y;
      ++red.pixels;
    }
  red.x /= std::max(red.pixels, 1);
  red.y /= std::max(red.pixels, 1);
  return red;
}

TEST_F(FlatGl, AFootSlidesLessThanItsOffsetTimesTheAngularError) {
  CROWDBENCH_SKIP_SANITIZED("FeetStayWhereTheyStandFromAbove");
  const scene::Cast cast = cast_of(post_with_foot());
  const auto mesh = make(cast, "mesh");
  const std::string bake = "flat:views=sphere-12x7,texels=128";  // 30 degrees by 15
  const std::vector<std::string> names = {"nearest", "nailboard", "blend of 3", "facing plane"};
  const std::vector<std::string> options = {"", ",depth=nailboard", ",blend=3", ",plane=facing"};
  std::vector<std::unique_ptr<Representation>> ways;
  for (const std::string& o : options) ways.push_back(make(cast, bake + o));
  const ViewGrid grid = parse_view_grid("sphere-12x7", 0, "views");
  const double texel = ways[0]->texel_metres(0);
  const auto& bank = *cast.banks[0];
  const glm::dvec3 centre =
      enclosing_sphere({scene::shown_positions(cast.characters[0]->mesh, bank.palette(bank.sample(0, 0)))}).centre;
  const glm::dvec3 foot{0.30, 0.04, 0.2};
  Renderer renderer(context(), cast);
  std::vector<double> sums(ways.size());
  int between = 0;
  bool leaning = false;
  int rows = 0;
  int within_centre = 0;
  int within_both = 0;
  fmt::print("  az   el  dist  error  allowed  at centre  perspective |");
  for (const std::string& n : names) fmt::print(" {:>12}", n);
  fmt::print("   (mm; texel {:.1f})\n", texel * 1000);
  for (const double distance : {13.06, 40.0})
    for (const double elevation : {0.0, 7.0, 37.0, 60.0})
      for (const double azimuth : {0.0, 11.0, 60.0, 75.0, 150.0, 315.0}) {
        // 480 pixels to 1.75 metres at the centre, from any distance.
        scene::Frame frame = frame_from(cast, {.azimuth = azimuth, .elevation = elevation, .around = centre});
        frame.width = frame.height = 800;
        frame.camera.fov_y = 2 * std::atan(800 * 1.75 / 480 / 2 / distance);
        const glm::dvec3 d = glm::normalize(frame.camera.eye - frame.camera.target);
        frame.camera.eye = frame.camera.target + distance * d;
        frame.origin = frame.camera.eye;
        frame.agents[0].clear();
        add_agent(frame, cast, {0, 0, 0}, 1);
        const RedCentre expected = red_centre(renderer.capture(frame, *mesh));
        ASSERT_GT(expected.pixels, 50);
        // The tile is orthographic: what counts is the angle between its axis and the foot's own ray, which near the
        // eye is not nothing at stored views either.
        const double error = view_error(grid, d);
        const glm::dvec3 axis = grid.basis(grid.pick(d).view).to_eye;
        const glm::dvec3 ray = glm::normalize(frame.camera.eye - foot);
        const double at_foot = glm::length(glm::cross(axis, ray));
        const bool stored = error < 1e-3;
        const double out = std::hypot(foot.x - centre.x, foot.z - centre.z);
        const double allowed = texel + std::max(out, kFootOut) * at_foot;
        // The same with the angle at the centre, and what perspective alone moves a point by that stands `height` in
        // front of the capture plane and `across` beside the axis: in the picture it is at across D / (D - height).
        const double at_centre = texel + std::max(out, kFootOut) * std::sin(error);
        const double height = glm::dot(foot - centre, d);
        const double across = glm::length(foot - centre - height * d);
        const double perspective = across * std::abs(height) / (distance - height);
        fmt::print("{:>4} {:>4} {:>5} {:>6.1f} {:>8.1f} {:>10.1f} {:>12.1f} |", azimuth, elevation, distance,
                   error / kRadiansADegree, allowed * 1000, at_centre * 1000, perspective * 1000);
        for (size_t i = 0; i < ways.size(); ++i) {
          const RedCentre got = red_centre(renderer.capture(frame, *ways[i]));
          const double slide = std::hypot(got.x - expected.x, got.y - expected.y) * 1.75 / 480;
          fmt::print(" {:>12.1f}", slide * 1000);
          if (!stored) sums[i] += slide;
          leaning = leaning || (i == 3 && slide > allowed);
          if (i == 0) {
            ++rows;
            within_centre += slide <= at_centre ? 1 : 0;
            within_both += slide <= at_centre + perspective ? 1 : 0;
          }
          if (i < 3) {
            EXPECT_LE(slide, allowed) << names[i];
            if (stored && distance > 20) {
              EXPECT_LE(slide, texel) << names[i];
            }
          }
        }
        between += stored ? 0 : 1;
        fmt::print("\n");
      }
  fmt::print("mean between stored views:");
  for (size_t i = 0; i < ways.size(); ++i) fmt::print(" {} {:.1f} mm;", names[i], sums[i] / between * 1000);
  fmt::print("\n");
  fmt::print("nearest: {} of {} within a texel and the sine of the angle at the centre, {} with perspective added\n",
             within_centre, rows, within_both);
  EXPECT_EQ(within_both, rows);
  EXPECT_TRUE(leaning) << "a plane across the view leans, and this test can see it";
  EXPECT_LT(sums[2], sums[0]);
}

// Two walkers in each other's way, side by side and `apart` metres from each other, both seen exactly from a stored
// view (their headings make up for standing beside the axis) turned by `off` degrees; 120 pixels tall at 30 degrees.
scene::Frame interpenetrating(double azimuth_a, double azimuth_b, double elevation, double apart, double off) {
  scene::Frame frame = frame_from(walker(), {.elevation = elevation, .fov = 30});
  frame.agents[0].clear();
  const double level = std::hypot(frame.camera.eye.x, frame.camera.eye.z);
  const double turned = std::asin(apart / 2 / level) / (2 * std::numbers::pi);
  const double back = level * (1 - std::cos(2 * std::numbers::pi * turned));  // as far from the eye as the centre is
  for (const auto& [side, azimuth, phase, id] : {std::tuple{-1, azimuth_a, 0.0, 1U}, {1, azimuth_b, 0.5, 2U}}) {
    const double heading = -side * turned - (azimuth + off) / 360;
    add_agent(frame, walker(), {side * apart / 2, 0, back}, id, phase,
              static_cast<float>(heading - std::floor(heading)));
  }
  return frame;
}

TEST_F(FlatGl, NailboardsOfInterpenetratingAgentsShowTheIdsOfTheirMeshes) {
  CROWDBENCH_SKIP_SANITIZED("FlatGl.TheBlendOfThreeKeepsIdsDepthsAndTheFloor");
  const auto mesh = make(walker(), "mesh");
  const std::string bake = "flat:views=sphere-16x8,frames=2,texels=128";
  const auto nailboard = make(walker(), bake + ",depth=nailboard");
  const auto flat = make(walker(), bake);
  Renderer renderer(context(), walker());
  struct Sums {
    double least = 1, mean = 0;
    int cases = 0;
    void add(double v) {
      least = std::min(least, v);
      mean += v;
      ++cases;
    }
  };
  for (const double off : {0.0, 11.25}) {  // of 22.5 degrees between stored views
    Sums with;
    Sums without;
    for (const double elevation : {0.0, 90.0 / 7})
      for (const double azimuth : {0.0, 45.0, 90.0, 180.0, 292.5})
        for (const double between : {0.0, 90.0})
          for (const double apart : {0.12, 0.3}) {
            const auto frame = interpenetrating(azimuth, azimuth + between, elevation, apart, off);
            const Capture reference = renderer.capture(frame, *mesh);
            with.add(same_ids(reference, renderer.capture(frame, *nailboard)));
            without.add(same_ids(reference, renderer.capture(frame, *flat)));
          }
    with.mean /= with.cases;
    without.mean /= without.cases;
    fmt::print("{}: same ids, nailboard mean {:.4f} least {:.4f}; flat depth mean {:.4f} least {:.4f}\n",
               off == 0 ? "stored views" : "half-way between views", with.mean, with.least, without.mean,
               without.least);
    if (off == 0) {
      EXPECT_GE(with.least, 0.97);
      EXPECT_LT(without.least, 0.9) << "planes cannot show bodies that pass through each other";
    } else {
      EXPECT_GT(with.mean, without.mean);
    }
  }
}

TEST_F(FlatGl, NailboardDepthIsTheMeshesWithinATexel) {
  const auto mesh = make(walker(), "mesh");
  const auto nailboard = make(walker(), "flat:views=sphere-6x4,frames=2,texels=128,depth=nailboard");
  Renderer renderer(context(), walker());
  for (const double far : {0.0, 100.0})  // both forms of the projection
    for (const auto& [azimuth, elevation] : {std::pair{0.0, 0.0}, {60.0, 30.0}, {240.0, 60.0}}) {
      auto frame = frame_from(walker(), {.azimuth = azimuth, .elevation = elevation, .phase = 0.5, .fov = 3});
      frame.camera.far = far;
      const Capture a = renderer.capture(frame, *mesh);
      const Capture b = renderer.capture(frame, *nailboard);
      std::vector<double> errors;
      for (size_t i = 0; i < a.ids.data.size(); ++i)
        if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
          errors.push_back(std::abs(static_cast<double>(a.depth.data[i]) - static_cast<double>(b.depth.data[i])));
      ASSERT_GT(errors.size(), 1000U);
      std::sort(errors.begin(), errors.end());
      // The plane alone is up to 0.2 m off.
      EXPECT_LT(errors[errors.size() / 2], nailboard->texel_metres(0)) << azimuth << ", " << elevation;
      EXPECT_LT(errors[errors.size() * 9 / 10], 3 * nailboard->texel_metres(0)) << azimuth << ", " << elevation;
    }
}

TEST_F(FlatGl, TheBlendOfThreeIsTheNearestAtAStoredViewAndBetterBetween) {
  CROWDBENCH_SKIP_SANITIZED("FlatGl.TheBlendOfThreeKeepsIdsDepthsAndTheFloor");
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  for (const char* grid : {"sphere-12x7", "cube-5", "hemi-9"}) {
    const std::string bake = fmt::format("flat:views={},frames=1,texels=128", grid);
    const auto one = make(walker(), bake);
    const auto three = make(walker(), bake + ",blend=3");
    // From the front and from above, where all grids but the cube's (near enough) have a view. From afar, as the eye's
    // direction to the capture centre and to the middle of the bounds differ.
    for (const double elevation : {0.0, 90.0}) {
      const auto frame = frame_from(walker(), {.elevation = elevation, .fov = 0.5});
      const Capture a = renderer.capture(frame, *one);
      const Capture b = renderer.capture(frame, *three);
      EXPECT_GT(iou(a, b), 0.98) << grid << " from elevation " << elevation;
    }
    double nearest = 0;
    double blended = 0;
    for (const double elevation : {5.0, 22.0, 41.0})
      for (const double azimuth : {13.0, 47.0, 101.0, 163.0, 222.0, 290.0}) {
        const auto frame = frame_from(walker(), {.azimuth = azimuth, .elevation = elevation, .fov = 3});
        const Capture reference = renderer.capture(frame, *mesh);
        nearest += iou(reference, renderer.capture(frame, *one)) / 18;
        blended += iou(reference, renderer.capture(frame, *three)) / 18;
      }
    EXPECT_GT(blended, nearest + 0.005) << grid;
    EXPECT_GT(blended, 0.9) << grid;
  }
}

TEST_F(FlatGl, TheBlendOfThreeKeepsIdsDepthsAndTheFloor) {
  const std::string bake = "flat:views=sphere-12x7,frames=1,texels=96,blend=3";
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), bake);
  const auto nailboard = make(walker(), bake + ",depth=nailboard");
  const auto floor = make(walker(), bake + ",floor=1");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(walker(), {.azimuth = 22, .elevation = 10, .heading = 0.1F, .fov = 3});
  const Capture reference = renderer.capture(frame, *mesh);
  const Capture a = renderer.capture(frame, *flat);
  const Capture b = renderer.capture(frame, *nailboard);
  const Capture c = renderer.capture(frame, *floor);
  EXPECT_EQ(a.ids, c.ids);
  EXPECT_EQ(a.depth, c.depth);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.colour, b.colour) << "one agent in front of nothing: depth changes nothing";
  double off = 0;
  double moved = 0;
  int pixels = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (reference.ids.data[i] == 0 || b.ids.data[i] == 0) continue;
    off += std::abs(static_cast<double>(reference.depth.data[i]) - static_cast<double>(b.depth.data[i]));
    moved += std::abs(static_cast<double>(reference.depth.data[i]) - static_cast<double>(a.depth.data[i]));
    ++pixels;
  }
  ASSERT_GT(pixels, 500);
  EXPECT_LT(off / pixels, 0.03) << "metres";
  EXPECT_LT(off, 0.5 * moved);
}

// Half-way between stored views, and where a view is stored, which perspective alone moves. Depths are the surface's.
TEST_F(FlatGl, ParallaxShowsWhatTheEyeSeesBetweenStoredViews) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  const std::string bake = "flat:views=sphere-12x7,frames=1,texels=96";
  for (const char* blend : {"", ",blend=3"}) {
    const auto plain = make(walker(), bake + blend);
    const auto moved = make(walker(), bake + blend + ",parallax=3");
    const auto deep = make(walker(), bake + blend + ",parallax=3,depth=nailboard");
    double without = 0;
    double with = 0;
    double off = 0;
    int pixels = 0;
    for (const double elevation : {0.0, 7.5, 22.5})
      for (const double azimuth : {15.0, 105.0, 225.0}) {
        const auto frame = frame_from(walker(), {.azimuth = azimuth, .elevation = elevation, .fov = 3});
        const Capture reference = renderer.capture(frame, *mesh);
        const Capture shown = renderer.capture(frame, *moved);
        const Capture nailboard = renderer.capture(frame, *deep);
        without += iou(reference, renderer.capture(frame, *plain)) / 9;
        with += iou(reference, shown) / 9;
        EXPECT_EQ(shown.colour, nailboard.colour) << "one agent in front of nothing: depth changes nothing";
        for (size_t i = 0; i < shown.ids.data.size(); ++i) {
          if (reference.ids.data[i] == 0 || nailboard.ids.data[i] == 0) continue;
          off += std::abs(static_cast<double>(reference.depth.data[i]) - static_cast<double>(nailboard.depth.data[i]));
          ++pixels;
        }
      }
    fmt::print("between views{}: IoU {:.3f}, with parallax {:.3f}; depths off by {:.3f} m\n", blend, without, with,
               off / pixels);
    EXPECT_GT(with, without + 0.01) << blend;
    ASSERT_GT(pixels, 3000);
    EXPECT_LT(off / pixels, 0.03) << "metres";
  }
}

// Views 45 degrees apart, at elevations of 0 and 90 degrees; one bake for all.
class LayeredGl : public testing::GlTest {
 protected:
  static Capture draw(const std::string& spec, double azimuth) {
    const scene::Frame frame = testing::frame_from(walker(), {.azimuth = azimuth, .elevation = 8});
    Renderer renderer(context(), walker());
    return renderer.capture(frame, *testing::make(walker(), spec, {.use_cache = true}));
  }
  static testing::Difference against_mesh(const std::string& spec, double azimuth) {
    return testing::difference(draw("mesh", azimuth), draw(spec, azimuth));
  }
  support::CacheFolder bakes_;
};

const std::string kLayeredTiles = "views=sphere-8x2,frames=2";

TEST_F(LayeredGl, OneLayerIsTheFlatImpostor) {
  EXPECT_EQ(draw("layered:slices=1," + kLayeredTiles, 20), draw("flat:" + kLayeredTiles, 20));
}

// Every texel is in a layer: from a stored view they close, and each has the depth of its own.
TEST_F(LayeredGl, LayersHoldAllThatIsStored) {
  const testing::Difference flat = against_mesh("flat:" + kLayeredTiles, 0);
  const testing::Difference layered = against_mesh("layered:" + kLayeredTiles, 0);
  EXPECT_NEAR(layered.drawn, flat.drawn, 0.04 * flat.drawn);
  EXPECT_LE(layered.holes, flat.holes + 2);
  EXPECT_LT(layered.mean_depth, 0.6 * flat.mean_depth);
}

// Between stored views layers move against each other as the surface does.
TEST_F(LayeredGl, BetweenViewsLayersAreNearerToTheMesh) {
  double flat = 0;
  double layered = 0;
  for (const double azimuth : {15.0, 110.0, 250.0}) {
    flat += against_mesh("flat:" + kLayeredTiles, azimuth).iou / 3;
    layered += against_mesh("layered:" + kLayeredTiles, azimuth).iou / 3;
  }
  EXPECT_GT(layered, flat + 0.01);
}

TEST_F(LayeredGl, OverlapClosesCracks) {
  const auto holes = [&](const char* overlap) {
    int sum = 0;
    for (const double azimuth : {20.0, 112.0, 245.0})
      sum += against_mesh("layered:overlap=" + std::string(overlap) + "," + kLayeredTiles, azimuth).holes;
    return sum;
  };
  EXPECT_GT(holes("0"), holes("0.5") + 5);
}

TEST_F(LayeredGl, TrianglesAreThoseOfAllLayers) {
  const auto flat = testing::make(walker(), "flat:" + kLayeredTiles, {.use_cache = true});
  const auto layered = testing::make(walker(), "layered:slices=5," + kLayeredTiles, {.use_cache = true});
  EXPECT_EQ(layered->triangles(0), 5 * flat->triangles(0));
  EXPECT_EQ(layered->footprint().texture_bytes, flat->footprint().texture_bytes) << "the same tiles";
}

}  // namespace
}  // namespace crowdbench::renderers
