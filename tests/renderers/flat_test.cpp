#include "renderers/flat/flat.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <span>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "renderers/bake_cache.h"
#include "renderers/flat/flat_bake.h"
#include "renderers/gl/objects.h"
#include "renderers/tiles/block_compression.h"
#include "scene/mannequin.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

constexpr double kDegrees = std::numbers::pi / 180;

// Code values, over the pixels that both cover.
int worst_colour_difference(const Capture& a, const Capture& b) {
  int worst = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i)
    if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
      for (size_t k = 0; k < 3; ++k)
        worst = std::max(worst, std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}));
  return worst;
}

std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec, bool use_cache = false,
                                     uint64_t budget = uint64_t{512} << 20) {
  MakeContext make{.context = context(), .cast = cast};
  make.use_cache = use_cache;
  make.progress = false;
  make.bake_budget = budget;
  return make_representation(make, parse_spec(spec));
}

// The small mannequin with its walk: asymmetric enough that a wrong view or frame shows.
const scene::Cast& walker() {
  static const scene::Cast cast = [] {
    scene::MannequinOptions options;
    options.triangles = 500;
    return cast_of(scene::make_mannequin(options));
  }();
  return cast;
}

// One agent at the origin, 120 pixels tall in 200 rows, seen from a direction about its middle.
scene::Frame frame_from(double azimuth, double elevation, double phase, const glm::dvec3& middle, float heading = 0,
                        double fov_deg = 15) {
  scene::Frame frame = frame_of_one(5, 1, 200, 200, fov_deg);
  const double distance = 1.75 * 200 / 120 / (2 * std::tan(frame.camera.fov_y / 2));
  const glm::dvec3 d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                     std::cos(azimuth) * std::cos(elevation)};
  frame.camera.target = middle;
  frame.camera.eye = middle + distance * d;
  frame.camera.up = {-std::sin(azimuth) * std::sin(elevation), std::cos(elevation),
                     -std::cos(azimuth) * std::sin(elevation)};
  frame.origin = frame.camera.eye;
  add_agent(frame, walker(), {0, 0, 0}, 1, phase, heading);
  return frame;
}

double iou(const Capture& a, const Capture& b) {
  int both = 0;
  int either = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    both += a.ids.data[i] != 0 && b.ids.data[i] != 0;
    either += a.ids.data[i] != 0 || b.ids.data[i] != 0;
  }
  return either == 0 ? 0 : static_cast<double>(both) / either;
}

size_t covered(const Capture& c) {
  size_t n = 0;
  for (const uint32_t id : c.ids.data) n += id != 0;
  return n;
}

glm::dvec3 middle_of(const scene::Cast& cast) {
  return 0.5 * (glm::dvec3(cast.banks[0]->bounds_min()) + glm::dvec3(cast.banks[0]->bounds_max()));
}

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
  const double e = 40 * kDegrees;
  const ViewBasis above{{1, 0, 0}, {0, std::cos(e), -std::sin(e)}, {0, std::sin(e), std::cos(e)}};
  EXPECT_NEAR(fit_plane(surface_moments(pole, {0, 1, 2, 0, 2, 3}), {0, 1, 0}, above).slope_y, std::tan(e), 1e-3);
  // From straight above its slope would be without end; it is held.
  const ViewBasis top{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  EXPECT_LE(std::abs(fit_plane(surface_moments(pole, {0, 1, 2, 0, 2, 3}), {0, 1, 0}, top).slope_y), 2);
}

TEST(FlatBake, BytesSurviveARoundTripAndDamageDoesNot) {
  FlatBake bake;
  bake.frames = 2;
  bake.views = 1;
  bake.clips = {{0, 2}};
  FlatLevel level;
  level.width = 4;
  level.height = 4;
  level.layers = 1;
  level.tiles.resize(2);
  level.tiles[1].slope_x = 0.25F;
  level.outlines.resize(8);
  level.albedo.assign(64, 7);
  level.surface.assign(64, 9);
  bake.levels = {level};
  const auto bytes = serialise(bake);
  const auto back = deserialise_flat(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(serialise(*back), bytes);
  EXPECT_EQ(back->levels[0].tiles[1].slope_x, 0.25F);
  for (size_t n = 0; n < bytes.size(); ++n) EXPECT_FALSE(deserialise_flat(std::span(bytes).first(n))) << n;
  bake.clips = {{1, 2}};  // a clip past the frames
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  bake.clips = {{0, 2}};
  ASSERT_TRUE(deserialise_flat(serialise(bake)));
  bake.part_bits = 4;  // blocks that are not there
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  FlatLevel& compressed = bake.levels[0];
  compressed.albedo.resize(16);
  compressed.surface.clear();
  compressed.normal.resize(16);
  compressed.parts.resize(8);
  EXPECT_TRUE(deserialise_flat(serialise(bake)));
  compressed.depth.resize(8);
  EXPECT_TRUE(deserialise_flat(serialise(bake)));
  bake.part_bits = 8;
  EXPECT_FALSE(deserialise_flat(serialise(bake))) << "ids of four bits";
  bake.part_bits = 4;
  bake.emission_peak = 2.5F;  // a map that is not there
  EXPECT_FALSE(deserialise_flat(serialise(bake)));
  compressed.emission.resize(8);
  const auto glowing = serialise(bake);
  ASSERT_TRUE(deserialise_flat(glowing));
  EXPECT_EQ(deserialise_flat(glowing)->emission_peak, 2.5F);
  EXPECT_EQ(deserialise_flat(glowing)->levels[0].emission.size(), 8U);
  for (size_t n = 0; n < glowing.size(); ++n) EXPECT_FALSE(deserialise_flat(std::span(glowing).first(n))) << n;
}

TEST(FlatBake, AccountingAgreesWithTheSource) {
  // 136 views of 85 texels, twelve a row, in 1024 x 1024 RGBA plus 1024 x 1024 RGB are 7 MiB; as blocks 1.5 MiB.
  ViewGrid grid;
  grid.azimuths = 17;
  grid.elevations = 8;
  const NominalFrame frame = nominal_frame(grid, 85);
  EXPECT_EQ(frame.side, 1024);
  EXPECT_EQ(frame.bytes, uint64_t{7} << 20);
  EXPECT_EQ(frame.compressed_bytes, uint64_t{3} << 19);
  EXPECT_EQ(nominal_frame(grid, 86).side, 2048) << "eleven a row are 121";
  grid.azimuths = 12;
  grid.elevations = 12;
  EXPECT_EQ(nominal_frame(grid, 85).side, 1024) << "144 views fill it";
  // Our own page of that size holds the same maps, the RGB one with a fourth channel.
  FlatLevel page;
  page.albedo.resize(1024 * 1024 * 4);
  page.surface.resize(1024 * 1024 * 4);
  EXPECT_EQ(page.texture_bytes() - uint64_t{1024} * 1024, frame.bytes);
}

class FlatGl : public GlTest {};

TEST_F(FlatGl, LooksAsTheMeshAtEveryStoredViewOfEveryGrid) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  const glm::dvec3 middle = middle_of(walker());
  struct Case {
    const char* grid;
    std::vector<std::pair<double, double>> views;  // azimuth, elevation, degrees
  };
  for (const auto& [grid, views] :
       std::initializer_list<Case>{{"sphere-6x4", {{0, 0}, {60, 0}, {120, 30}, {240, 60}, {300, 90}}},
                                   {"cube-3", {{0, 0}, {90, 0}, {33.690067, 0}, {180, 0}, {0, 90}}},
                                   {"hemi-5", {{0, 0}, {45, 0}, {270, 0}, {0, 90}}}}) {
    const auto flat = make(walker(), fmt::format("flat:views={},frames=2,texels=128", grid));
    for (const auto& [azimuth, elevation] : views)
      for (const double phase : {0.0, 0.5}) {
        // From afar: tiles are orthographic, and what is left over is theirs alone.
        const auto frame = frame_from(azimuth * kDegrees, elevation * kDegrees, phase, middle, 0, 3);
        const double agreement = iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat));
        EXPECT_GT(agreement, 0.93) << grid << " from " << azimuth << ", " << elevation << " at phase " << phase;
      }
  }
}

TEST_F(FlatGl, TurnsWithTheAgent) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-6x4,frames=2,texels=128");
  Renderer renderer(context(), walker());
  // An agent turned by a sixth seen from 90 degrees is the view from 30 before turning; the sample at 60 - 60 = 0.
  const auto frame = frame_from(60 * kDegrees, 30 * kDegrees, 0, middle_of(walker()), 1.0F / 6);
  EXPECT_GT(iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat)), 0.93);
}

TEST_F(FlatGl, ShowsTheNearestFrame) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-4x1,frames=4,texels=128");
  Renderer renderer(context(), walker());
  const glm::dvec3 middle = middle_of(walker());
  const auto flat_at = [&](double phase) {
    return renderer.capture(frame_from(90 * kDegrees, 0, phase, middle), *flat).ids;
  };
  EXPECT_EQ(flat_at(0.13), flat_at(0.25));
  EXPECT_EQ(flat_at(0.12), flat_at(0.0));
  EXPECT_EQ(flat_at(0.88), flat_at(0.0)) << "the last half frame belongs to the first";
  EXPECT_NE(flat_at(0.25), flat_at(0.0));
  const auto quarter = frame_from(90 * kDegrees, 0, 0.25, middle);
  EXPECT_GT(iou(renderer.capture(quarter, *mesh), renderer.capture(quarter, *flat)), 0.93);
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
    scene::Frame frame = frame_from(azimuth * kDegrees, elevation * kDegrees, 0, {0, 0.9, 0});
    frame.width = frame.height = 800;
    frame.agents[0].clear();
    add_agent(frame, cast, {0, 0, 0}, 1);
    const Foot a = foot_of(renderer.capture(frame, *mesh));
    const Foot b = foot_of(renderer.capture(frame, flat));
    return std::hypot(a.x - b.x, a.y - b.y);
  };
  EXPECT_LE(slide(*fitted, 60, 45), texel_px + 1);
  // Beside a stored view: one texel and the foot's offset from the capture axis times the sine of the angular error.
  for (const auto& [azimuth, elevation] : {std::pair{84.0, 45.0}, {60.0, 60.0}, {75.0, 30.0}}) {
    const double error = 25 * kDegrees;  // at most, for these three
    const double allowed = texel_px + kHalf * std::sqrt(2.0) * std::sin(error) * kPixelsAMetre + 1;
    EXPECT_LE(slide(*fitted, azimuth, elevation), allowed) << azimuth << ", " << elevation;
    EXPECT_GT(slide(*facing, azimuth, elevation), allowed) << "a plane across the view leans, and this test can see it";
  }
}

// Two walkers in each other's way, side by side and `apart` metres from each other, both seen exactly from a stored
// view (their headings make up for standing beside the axis) turned by `off` degrees; 120 pixels tall at 30 degrees.
scene::Frame interpenetrating(double azimuth_a, double azimuth_b, double elevation, double apart, double off) {
  scene::Frame frame = frame_from(0, elevation * kDegrees, 0, middle_of(walker()), 0, 30);
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

// Share of the pixels covered in both pictures that show the same agent.
double same_ids(const Capture& a, const Capture& b) {
  int same = 0;
  int both = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    if (a.ids.data[i] == 0 || b.ids.data[i] == 0) continue;
    ++both;
    same += a.ids.data[i] == b.ids.data[i];
  }
  return static_cast<double>(same) / both;
}

TEST_F(FlatGl, NailboardsOfInterpenetratingAgentsShowTheIdsOfTheirMeshes) {
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
      auto frame = frame_from(azimuth * kDegrees, elevation * kDegrees, 0.5, middle_of(walker()), 0, 3);
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
      enclosing_sphere({posed_positions(cast.characters[0]->mesh, bank.palette(bank.sample(0, 0)))}).centre;
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
        scene::Frame frame = frame_from(azimuth * kDegrees, elevation * kDegrees, 0, centre);
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
                   error / kDegrees, allowed * 1000, at_centre * 1000, perspective * 1000);
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

TEST_F(FlatGl, TheBlendOfThreeIsTheNearestAtAStoredViewAndBetterBetween) {
  const auto mesh = make(walker(), "mesh");
  Renderer renderer(context(), walker());
  const glm::dvec3 middle = middle_of(walker());
  for (const char* grid : {"sphere-12x7", "cube-5", "hemi-9"}) {
    const std::string bake = fmt::format("flat:views={},frames=1,texels=128", grid);
    const auto one = make(walker(), bake);
    const auto three = make(walker(), bake + ",blend=3");
    // From the front and from above, where all grids but the cube's (near enough) have a view. From afar, as the eye's
    // direction to the capture centre and to the middle of the bounds differ.
    for (const double elevation : {0.0, 90.0}) {
      const auto frame = frame_from(0, elevation * kDegrees, 0, middle, 0, 0.5);
      const Capture a = renderer.capture(frame, *one);
      const Capture b = renderer.capture(frame, *three);
      EXPECT_GT(iou(a, b), 0.98) << grid << " from elevation " << elevation;
    }
    double nearest = 0;
    double blended = 0;
    for (const double elevation : {5.0, 22.0, 41.0})
      for (const double azimuth : {13.0, 47.0, 101.0, 163.0, 222.0, 290.0}) {
        const auto frame = frame_from(azimuth * kDegrees, elevation * kDegrees, 0, middle, 0, 3);
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
  const auto frame = frame_from(22 * kDegrees, 10 * kDegrees, 0, middle_of(walker()), 0.1F, 3);
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

TEST_F(FlatGl, ACardIsShadedAsTheMeshShadesIt) {
  for (const glm::vec4& colour : {glm::vec4(0.5F, 0.25F, 0.1F, 1), glm::vec4(0.02F, 0.9F, 0.4F, 1)}) {
    const scene::Cast cast = cast_of(testing::card(1, 1, colour));
    const auto mesh = make(cast, "mesh");
    const auto flat = make(cast, "flat:views=sphere-1x1,texels=64");
    Renderer renderer(context(), cast);
    scene::Frame frame = frame_of_one(3, 0.5, 96, 96);
    scene::Outfit outfit;
    for (glm::vec4& c : outfit.colours) c = glm::vec4(0.7F, 1.0F, 0.3F, 1);
    frame.outfits.push_back(outfit);
    add_agent(frame, cast, {0, 0, 0}, 1);
    frame.agents[0][0].outfit = 1;
    const Capture a = renderer.capture(frame, *mesh);
    const Capture b = renderer.capture(frame, *flat);
    EXPECT_GT(iou(a, b), 0.95);
    EXPECT_LE(worst_colour_difference(a, b), 1) << "grey levels";
  }
}

TEST_F(FlatGl, CoverageOfACrowdIsKeptWhenAgentsAreSpecks) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-8x2,frames=4,texels=64");
  Renderer renderer(context(), walker());
  for (const double tall : {24.0, 6.0, 2.0}) {  // pixels
    scene::Frame frame = frame_of_one(10, 1, 320, 240, 30);
    const double distance = 1.75 * 240 / (tall * 2 * std::tan(15 * kDegrees));
    frame.camera.eye = {0, 1, distance};
    frame.origin = frame.camera.eye;
    const int columns = 40;
    for (int i = 0; i < 1200; ++i) {
      // A lattice that does not beat with the pixels, all within the view.
      const double x = ((i % columns) - columns / 2 + 0.37 * (i / columns % 3)) * distance * 0.65 / columns;
      const double y = ((i / columns) - 15) * distance * 0.5 / 31;
      add_agent(frame, walker(), {x, y, 0.1 * (i % 7)}, static_cast<uint32_t>(i + 1), (i % 4) * 0.25,
                static_cast<float>(i % 8) / 8);
    }
    const auto expected = static_cast<double>(covered(renderer.capture(frame, *mesh)));
    const auto got = static_cast<double>(covered(renderer.capture(frame, *flat)));
    ASSERT_GT(expected, 500);
    EXPECT_NEAR(got / expected, 1, 0.03) << tall << " pixels tall";
  }
}

// Figures that overlap: shapes must be kept too, since blobs of the same area would cover more of the picture.
TEST_F(FlatGl, AHundredThousandAgentsCoverWhatTheirMeshesCover) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-8x2,frames=4,texels=64");
  Renderer renderer(context(), walker());
  scene::Frame frame = frame_of_one(10, 1, 640, 480, 30);
  constexpr int kAgents = 100000;
  constexpr double kTall = 1.5;  // pixels
  const double distance = 1.75 * 480 / (kTall * 2 * std::tan(15 * kDegrees));
  frame.camera.eye = {0, 1, distance};
  frame.origin = frame.camera.eye;
  const double metre = kTall / 1.75;  // pixels
  for (int i = 0; i < kAgents; ++i) {
    const double x = 600 / metre * (random_unit(7, static_cast<uint64_t>(i), 1) - 0.5);
    const double y = 440 / metre * (random_unit(7, static_cast<uint64_t>(i), 2) - 0.5);
    add_agent(frame, walker(), {x, y, 0.05 * (i % 50)}, static_cast<uint32_t>(i + 1), (i % 4) * 0.25,
              static_cast<float>(i % 8) / 8);
  }
  const auto expected = static_cast<double>(covered(renderer.capture(frame, *mesh)));
  const auto got = static_cast<double>(covered(renderer.capture(frame, *flat)));
  ASSERT_GT(expected, 0.1 * 640 * 480);
  EXPECT_NEAR(got / expected, 1, 0.02) << got << " of " << expected;
}

TEST_F(FlatGl, CoverageOfADenseCrowdIsKept) {
  const auto mesh = make(walker(), "mesh");
  const auto flat = make(walker(), "flat:views=sphere-8x2,frames=4,texels=128");
  Renderer renderer(context(), walker());
  scene::Frame frame = frame_of_one(10, 1, 320, 240, 30);
  const double distance = 1.75 * 240 / (4 * 2 * std::tan(15 * kDegrees));  // four pixels tall
  frame.camera.eye = {0, 1, distance};
  frame.origin = frame.camera.eye;
  const double metre = 240 / (2 * distance * std::tan(15 * kDegrees));  // pixels
  for (int i = 0; i < 4000; ++i) {
    const double x = 280 / metre * (random_unit(5, static_cast<uint64_t>(i), 1) - 0.5);
    const double y = (80 * (i / 1000) + 20 * random_unit(5, static_cast<uint64_t>(i), 2) - 150) / metre;
    add_agent(frame, walker(), {x, y, 0.05 * (i % 50)}, static_cast<uint32_t>(i + 1), (i % 4) * 0.25,
              static_cast<float>(i % 8) / 8);
  }
  const auto expected = static_cast<double>(covered(renderer.capture(frame, *mesh)));
  const auto got = static_cast<double>(covered(renderer.capture(frame, *flat)));
  ASSERT_GT(expected, 5000);
  EXPECT_NEAR(got / expected, 1, 0.02);
}

TEST_F(FlatGl, TheFloorCoversTheSamePixels) {
  const auto flat = make(walker(), "flat:views=sphere-4x1,frames=2,texels=64");
  const auto floor = make(walker(), "flat:views=sphere-4x1,frames=2,texels=64,floor=1");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(0, 0, 0, middle_of(walker()));
  const Capture a = renderer.capture(frame, *flat);
  const Capture b = renderer.capture(frame, *floor);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_NE(a.colour, b.colour);
}

TEST_F(FlatGl, AListShowsTheStoredColours) {
  const std::string bake = "flat:views=sphere-4x1,frames=2,texels=64";
  const auto flat = make(walker(), bake);
  const auto list = make(walker(), bake + ",shade=list");
  Renderer renderer(context(), walker());
  scene::Frame frame = frame_from(0, 0, 0, middle_of(walker()));
  const Capture lit = renderer.capture(frame, *flat);
  EXPECT_NE(renderer.capture(frame, *list).colour, lit.colour);
  // White clothes in light from everywhere: what is lit is the stored colour too.
  frame.light.ambient = 1;
  frame.light.diffuse = 0;
  for (scene::Outfit& outfit : frame.outfits) outfit.colours.fill(glm::vec4(1.0F));
  const Capture a = renderer.capture(frame, *flat);
  const Capture b = renderer.capture(frame, *list);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.depth, b.depth);
  for (const char* option : {",depth=nailboard", ",blend=3", ",floor=1"})
    EXPECT_THROW(make(walker(), bake + ",shade=list" + option), Error) << option;
}

TEST_F(FlatGl, ManyLayersAreSplitOverSeveralArrays) {
  for (const std::string options : {"", ",depth=nailboard", ",compress=bc"}) {
    const std::string spec = "flat:views=sphere-8x4,frames=2,texels=64" + options;
    const auto whole = make(walker(), spec);
    const auto split = make(walker(), spec + ",layers=1");
    EXPECT_EQ(split->footprint().texture_bytes, whole->footprint().texture_bytes);
    EXPECT_GT(split->footprint().buffer_bytes, whole->footprint().buffer_bytes) << "there is something to split";
    Renderer renderer(context(), walker());
    // Both kinds of outlines, all elevations: agents around the eye, from 2 m under it to 14.
    scene::Frame frame = frame_of_one(10, 1, 320, 240, 60);
    frame.camera.eye = {0, 4, 0};
    frame.camera.target = {0, 0, -8};
    frame.origin = frame.camera.eye;
    for (int i = 0; i < 60; ++i) {
      const double away = 2 + 0.4 * i;
      add_agent(frame, walker(), {away * 0.5 * std::sin(2.4 * i), -0.1 * (i % 5), -away}, static_cast<uint32_t>(i + 1),
                (i % 4) * 0.25, static_cast<float>(i % 8) / 8);
    }
    const Capture a = renderer.capture(frame, *whole);
    const Capture b = renderer.capture(frame, *split);
    ASSERT_GT(covered(a), 2000U);
    EXPECT_EQ(a.ids, b.ids) << spec;
    EXPECT_EQ(a.colour, b.colour) << spec;
    EXPECT_EQ(a.depth, b.depth) << spec;
  }
  EXPECT_THROW(make(walker(), "flat:views=sphere-8x4,frames=2,texels=64,blend=3,layers=1"), Error)
      << "a fragment reads three tiles of any layers";
}

TEST_F(FlatGl, ASquareQuadShowsTheSamePicture) {
  const auto trimmed = make(walker(), "flat:views=sphere-4x2,frames=1,texels=64");
  const auto square = make(walker(), "flat:views=sphere-4x2,frames=1,texels=64,quad=square");
  Renderer renderer(context(), walker());
  const auto frame = frame_from(90 * kDegrees, 0, 0, middle_of(walker()));
  EXPECT_GT(iou(renderer.capture(frame, *trimmed), renderer.capture(frame, *square)), 0.995);
  EXPECT_GT(square->footprint().texture_bytes, 2 * trimmed->footprint().texture_bytes);
}

TEST_F(FlatGl, AStillBankIsBakedExactly) {
  const auto character = walker().characters[0];
  scene::Cast still;
  still.characters = {character};
  still.banks = {std::make_shared<const scene::PoseBank>(
      scene::PoseBank::exact(*character, character->placement.default_clip, 0.2))};
  still.shares = {1.0};
  const auto mesh = make(still, "mesh");
  const auto flat = make(still, "flat:views=sphere-4x1,texels=128");
  Renderer renderer(context(), still);
  scene::Frame frame = frame_from(90 * kDegrees, 0, 0, middle_of(still));
  frame.agents[0].clear();
  add_agent(frame, still, {0, 0, 0}, 1, 0.7);
  EXPECT_GT(iou(renderer.capture(frame, *mesh), renderer.capture(frame, *flat)), 0.93);
}

// The same bake as texels and as blocks, both read back from the driver, which decodes the blocks itself: what
// compression costs every map, over the texels that pass the alpha test.
TEST_F(FlatGl, CompressionKeepsEveryMapWithinItsTolerance) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  FlatBakeOptions options = flat_bake_options(parse_spec("flat:views=sphere-5x2,frames=2,texels=128"));
  const auto bake = [&](bool compressed) {
    options.compressed = compressed;
    options.depth = true;
    return bake_flat(context(), cast.characters[0], cast.banks[0], options, uint64_t{1} << 30);
  };
  const FlatBake plain = bake(false);
  const FlatBake blocks = bake(true);
  ASSERT_EQ(blocks.part_bits, 4) << "five materials";
  ASSERT_EQ(blocks.levels.size(), plain.levels.size());
  for (size_t l = 0; l < plain.levels.size(); ++l) {
    const FlatLevel& a = plain.levels[l];
    const FlatLevel& b = blocks.levels[l];
    const auto decode = [&](unsigned internal, unsigned format, size_t channels, const std::vector<uint8_t>& data) {
      gl::Texture texture = gl::Texture::make_array(context(), internal, b.width, b.height, b.layers, 1);
      const size_t layer = data.size() / static_cast<size_t>(b.layers);
      for (int i = 0; i < b.layers; ++i) texture.write(0, i, 0, 0, data.data() + static_cast<size_t>(i) * layer);
      GLint size = 0;
      glGetTextureLevelParameteriv(texture.name(), 0, GL_TEXTURE_COMPRESSED_IMAGE_SIZE, &size);
      EXPECT_EQ(static_cast<size_t>(size), data.size());
      EXPECT_EQ(texture.bytes(), data.size());
      std::vector<uint8_t> out(channels * static_cast<size_t>(b.width * b.height * b.layers));
      texture.read(0, format, GL_UNSIGNED_BYTE, out.data(), out.size());
      return out;
    };
    const auto albedo = decode(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, GL_RGBA, 4, b.albedo);
    const auto normal = decode(GL_COMPRESSED_RG_RGTC2, GL_RG, 2, b.normal);
    const auto depth = decode(GL_COMPRESSED_RED_RGTC1, GL_RED, 1, b.depth);
    const auto texel = [](const FlatLevel& level, const FlatTile& tile, int x, int y) {
      return (static_cast<size_t>(tile.layer) * static_cast<size_t>(level.height) +
              static_cast<size_t>(y + static_cast<int>(tile.offset_y))) *
                 static_cast<size_t>(level.width) +
             static_cast<size_t>(x + static_cast<int>(tile.offset_x));
    };
    double colour_error = 0;
    double angle = 0;
    double depth_error = 0;
    double area_plain = 0;
    double area_blocks = 0;
    double worst_tile = 0;
    size_t n = 0;
    size_t other_ids = 0;
    size_t tested_ids = 0;
    for (size_t t = 0; t < a.tiles.size(); ++t) {
      if (a.tiles[t].covered == 0) continue;
      const auto alpha_plain = [&](int x, int y) { return double{1.0} * a.albedo[4 * texel(a, a.tiles[t], x, y) + 3]; };
      const auto alpha_blocks = [&](int x, int y) { return double{1.0} * albedo[4 * texel(b, b.tiles[t], x, y) + 3]; };
      double here_plain = 0;
      double here_blocks = 0;
      const FlatTile& tile = a.tiles[t];
      for (int y = static_cast<int>(tile.low_y) - 1; y < static_cast<int>(tile.high_y); ++y)
        for (int x = static_cast<int>(tile.low_x) - 1; x < static_cast<int>(tile.high_x); ++x) {
          const size_t i = texel(a, a.tiles[t], x, y);
          const size_t j = texel(b, b.tiles[t], x, y);
          const uint8_t packed = b.parts[j / 2];
          other_ids += unpack_part(packed, j % 2 == 1) != a.surface[4 * i + 2];
          ++tested_ids;
          // The filtered alpha between four texels, at 4 x 4 points.
          const auto area = [&](const auto& alpha) {
            double in = 0;
            const double p = alpha(x, y), q = alpha(x + 1, y), r = alpha(x, y + 1), s = alpha(x + 1, y + 1);
            for (int k = 0; k < 16; ++k) {
              const double u = (k % 4 + 0.5) / 4;
              const double v = (k / 4 + 0.5) / 4;
              in += (p * (1 - u) + q * u) * (1 - v) + (r * (1 - u) + s * u) * v >= 127.5 ? 1.0 / 16 : 0.0;
            }
            return in;
          };
          here_plain += area(alpha_plain);
          here_blocks += area(alpha_blocks);
          if (a.albedo[4 * i + 3] < 128) continue;
          ++n;
          for (size_t c = 0; c < 3; ++c) {
            const double d = double{1.0} * a.albedo[4 * i + c] - albedo[4 * j + c];
            colour_error += d * d / 3;
          }
          const auto unit = [](uint8_t cx, uint8_t cy) {
            const double nx = decode_signed(cx);
            const double ny = decode_signed(cy);
            return glm::normalize(glm::dvec3(nx, ny, std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny))));
          };
          angle += std::acos(std::min(
              1.0, glm::dot(unit(a.surface[4 * i], a.surface[4 * i + 1]), unit(normal[2 * j], normal[2 * j + 1]))));
          depth_error += std::abs(int{a.surface[4 * i + 3]} - int{depth[j]}) / 127.0 * plain.radius;
        }
      area_plain += here_plain;
      area_blocks += here_blocks;
      if (here_plain > 0) worst_tile = std::max(worst_tile, std::abs(here_blocks / here_plain - 1));
    }
    ASSERT_GT(n, 0U);
    const double psnr = 10 * std::log10(255.0 * 255.0 * static_cast<double>(n) / colour_error);
    const double degrees = angle / static_cast<double>(n) / kDegrees;
    const double texels = depth_error / static_cast<double>(n) / (plain.texel * std::exp2(static_cast<double>(l)));
    fmt::print(
        "level {}: albedo {:.1f} dB, normals {:.2f} degrees, depths {:.2f} texels, area {:+.2f} %, {:.2f} % at worst\n",
        l, psnr, degrees, texels, 100 * (area_blocks / area_plain - 1), 100 * worst_tile);
    EXPECT_EQ(other_ids, 0U) << "of " << tested_ids << " at level " << l;
    // A block is four texels across a figure that has 128, 64, 32 or 16: the coarser, the more limbs and colours on
    // the one line of eight (normals) or four (colours) values that it can hold.
    constexpr double kLeastPsnr[] = {35, 32, 31, 26};
    constexpr double kMostDegrees[] = {2.5, 3.5, 4, 4};
    ASSERT_LT(l, std::size(kLeastPsnr));
    EXPECT_GT(psnr, kLeastPsnr[l]);
    EXPECT_LT(degrees, kMostDegrees[l]);
    EXPECT_LT(texels, 0.5);
    EXPECT_NEAR(area_blocks / area_plain, 1, 0.002);
    EXPECT_LT(worst_tile, 0.05);
  }
}

// Whichever way the tiles are stored: the same pixels but for a few on the border, the same outfit by the same ids.
TEST_F(FlatGl, CompressedTilesAreDrawnAsTheOthers) {
  const std::string common = "flat:views=sphere-5x2,frames=2,texels=96";
  Renderer renderer(context(), walker());
  for (const char* how : {"", ",depth=nailboard", ",blend=3", ",blend=3,depth=nailboard", ",floor=1"}) {
    const auto plain = make(walker(), common + how);
    const auto blocks = make(walker(), common + ",compress=bc" + how);
    EXPECT_LT(blocks->footprint().texture_bytes, 0.5 * static_cast<double>(plain->footprint().texture_bytes));
    for (const double azimuth : {0.0, 50.0, 200.0}) {
      const auto frame = frame_from(azimuth * kDegrees, 12 * kDegrees, 0.5, middle_of(walker()));
      const Capture a = renderer.capture(frame, *plain);
      const Capture b = renderer.capture(frame, *blocks);
      EXPECT_GT(iou(a, b), 0.98) << how;
      double off = 0;
      double depth_off = 0;
      size_t n = 0;
      for (size_t i = 0; i < a.ids.data.size(); ++i) {
        if (a.ids.data[i] == 0 || b.ids.data[i] == 0) continue;
        ++n;
        for (size_t k = 0; k < 3; ++k)
          off += std::abs(int{a.colour.data[4 * i + k]} - int{b.colour.data[4 * i + k]}) / 3.0;
        depth_off += std::abs(a.depth.data[i] - b.depth.data[i]);
      }
      EXPECT_LT(off / static_cast<double>(n), 5) << how << ": code values";
      EXPECT_LT(depth_off / static_cast<double>(n), plain->texel_metres(0)) << how;
    }
  }
}

// Ids beyond seven take a byte each, and the bit of what is not lit travels with both kinds.
TEST_F(FlatGl, CompressedIdsSelectTheOutfitAndTheLighting) {
  for (const bool unlit : {false, true})
    for (const uint8_t part : {uint8_t{5}, uint8_t{9}}) {
      scene::Character character = testing::card(1, 1, glm::vec4(1.0F));
      for (scene::Material& material : character.materials) {
        material.part = part;
        material.unlit = unlit;
      }
      const scene::Cast cast = cast_of(std::move(character));
      const auto mesh = make(cast, "mesh");
      const auto flat = make(cast, "flat:views=sphere-1x1,texels=64,compress=bc");
      Renderer renderer(context(), cast);
      scene::Frame frame = frame_of_one(3, 0.5, 96, 96);
      scene::Outfit outfit;
      for (size_t i = 0; i < outfit.colours.size(); ++i)
        outfit.colours[i] = i == part ? glm::vec4(0.1F, 1.0F, 0.3F, 1) : glm::vec4(1, 0, 0, 1);
      frame.outfits.push_back(outfit);
      add_agent(frame, cast, {0, 0, 0}, 1);
      frame.agents[0][0].outfit = 1;
      const Capture a = renderer.capture(frame, *mesh);
      const Capture b = renderer.capture(frame, *flat);
      EXPECT_GT(iou(a, b), 0.95);
      EXPECT_LE(worst_colour_difference(a, b), 1)
          << "part " << int{part} << ", unlit " << unlit << ": white survives compression";
    }
}

TEST_F(FlatGl, BakesAreTheSameBytesTwice) {
  FlatBakeOptions options;
  options.grid.azimuths = 3;
  options.grid.elevations = 2;
  options.frames = 2;
  options.texels = 48;
  const auto bake = [&] {
    return serialise(bake_flat(context(), walker().characters[0], walker().banks[0], options, uint64_t{1} << 30));
  };
  EXPECT_EQ(bake(), bake());
}

TEST_F(FlatGl, BakesDoNotDependOnTheNumberOfThreads) {
  FlatBakeOptions options;
  options.grid.azimuths = 3;
  options.grid.elevations = 2;
  options.frames = 2;
  options.texels = 48;
  const auto bake = [&](unsigned threads) {
    options.threads = threads;
    return serialise(bake_flat(context(), walker().characters[0], walker().banks[0], options, uint64_t{1} << 30));
  };
  for (const bool compressed : {false, true}) {
    options.compressed = compressed;
    const auto one = bake(1);
    EXPECT_EQ(bake(2), one);
    EXPECT_EQ(bake(7), one);
  }
}

TEST_F(FlatGl, AStaleEntryIsMadeAnewAndAFolderThatCannotBeWrittenStopsNothing) {
  const char* before = getenv("CROWDBENCH_CACHE_DIR");
  const std::string old = before ? before : "";
  const support::ScratchFolder folder;
  setenv("CROWDBENCH_CACHE_DIR", folder.path().c_str(), 1);
  const std::string spec = "flat:views=sphere-4x1,frames=1,texels=32";
  Renderer renderer(context(), walker());
  const auto frame = frame_from(0, 0, 0, middle_of(walker()));
  const auto first = make(walker(), spec, true);
  const Image8 picture = renderer.capture(frame, *first).colour;
  // Sound by its checksum, under the right key, but not what this version writes.
  const std::vector<uint8_t> other_format(100, 7);
  ASSERT_GT(BakeCache(folder / "bakes").store("flat", first->bake_info().cache_key, other_format), 0U);
  const auto again = make(walker(), spec, true);
  EXPECT_FALSE(again->bake_info().cached);
  EXPECT_EQ(renderer.capture(frame, *again).colour, picture);
  EXPECT_TRUE(make(walker(), spec, true)->bake_info().cached) << "it was replaced";
  // A file where the folder should be: nothing can be kept, by anybody.
  const fs::path file = folder / "no_folder";
  std::ofstream(file) << "not a folder";
  setenv("CROWDBENCH_CACHE_DIR", file.c_str(), 1);
  const auto unkept = make(walker(), spec, true);
  EXPECT_FALSE(unkept->bake_info().cached);
  EXPECT_EQ(unkept->footprint().disk_bytes, 0U);
  EXPECT_EQ(renderer.capture(frame, *unkept).colour, picture);
  before ? setenv("CROWDBENCH_CACHE_DIR", old.c_str(), 1) : unsetenv("CROWDBENCH_CACHE_DIR");
}

// What any option of the bake changes must change its key, and what only the drawing depends on must not.
TEST_F(FlatGl, TheCacheKeyHoldsWhatTheBytesDependOn) {
  const auto key = [](const std::string& spec) {
    return flat_cache_key(*walker().characters[0], *walker().banks[0], flat_bake_options(parse_spec(spec)), "r", "v");
  };
  const std::string plain = key("flat");
  for (const char* option : {"views=hemi-9", "el_min=-10", "frames=9", "texels=64", "quad=square", "plane=facing",
                             "corners=6", "compress=bc"})
    EXPECT_NE(key(std::string("flat:") + option), plain) << option;
  for (const char* option : {"depth=nailboard", "blend=3", "floor=1"})
    EXPECT_EQ(key(std::string("flat:") + option), plain) << option;
  EXPECT_NE(key("flat:compress=bc"), key("flat:compress=bc,depth=nailboard")) << "only nailboards need the depth map";
  FlatBakeOptions part = flat_bake_options(parse_spec("flat"));
  part.needed.assign(1360, 1);
  part.needed[7] = 0;
  EXPECT_NE(flat_cache_key(*walker().characters[0], *walker().banks[0], part, "r", "v"), plain);
}

TEST_F(FlatGl, ABakeOverTheBudgetSaysWhatToLower) {
  try {
    make(walker(), "flat", false, uint64_t{8} << 20);
    FAIL() << "8 MiB cannot be enough";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("136 views"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("lower texels, frames or views"), std::string::npos) << error.what();
  }
}

// Bytes of every texture that the driver holds, as the driver says; of its first level.
uint64_t texture_bytes_of_driver() {
  uint64_t sum = 0;
  for (GLuint name = 1; name < 4096; ++name) {
    if (!glIsTexture(name)) continue;
    const auto level = [&](GLenum what) {
      GLint value = 0;
      glGetTextureLevelParameteriv(name, 0, what, &value);
      return static_cast<uint64_t>(value);
    };
    if (level(GL_TEXTURE_BUFFER_SIZE) != 0) continue;  // a buffer that is read as texels
    if (level(GL_TEXTURE_COMPRESSED) != 0) {
      sum += level(GL_TEXTURE_COMPRESSED_IMAGE_SIZE);
      continue;
    }
    const uint64_t bits = level(GL_TEXTURE_RED_SIZE) + level(GL_TEXTURE_GREEN_SIZE) + level(GL_TEXTURE_BLUE_SIZE) +
                          level(GL_TEXTURE_ALPHA_SIZE);
    sum += level(GL_TEXTURE_WIDTH) * level(GL_TEXTURE_HEIGHT) * level(GL_TEXTURE_DEPTH) * bits / 8;
  }
  return sum;
}

// What the accounting takes the blocks of the source's page to be is what the driver allocates for them.
TEST_F(FlatGl, TheSourcesPageHasTheBytesOfTheDriver) {
  const uint64_t before = texture_bytes_of_driver();
  const auto rgba = gl::Texture::make_2d(context(), GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, 1024, 1024);
  const auto rgb = gl::Texture::make_2d(context(), GL_COMPRESSED_RGB_S3TC_DXT1_EXT, 1024, 1024);
  EXPECT_EQ(texture_bytes_of_driver() - before, uint64_t{3} << 19);
  EXPECT_EQ(rgba.bytes() + rgb.bytes(), uint64_t{3} << 19);
}

TEST_F(FlatGl, BytesAreCountedExactly) {
  uint64_t rgba8 = 0;
  for (const char* how : {"", ",compress=bc", ",compress=bc,depth=nailboard"}) {
    const gl::Allocated before = context().allocated();
    const uint64_t driver_before = texture_bytes_of_driver();
    const auto flat = make(walker(), std::string("flat:views=sphere-4x1,frames=2,texels=64") + how);
    const Footprint bytes = flat->footprint();
    EXPECT_EQ(context().allocated().texture_bytes - before.texture_bytes, bytes.texture_bytes) << how;
    EXPECT_EQ(context().allocated().buffer_bytes - before.buffer_bytes, bytes.buffer_bytes) << how;
    EXPECT_EQ(texture_bytes_of_driver() - driver_before, bytes.texture_bytes) << how;
    EXPECT_EQ(bytes.disk_bytes, 0U);
    // 20 bits a texel for 64, 24 with depths; tiles at multiples of four take more room, the smallest most.
    if (rgba8 == 0)
      rgba8 = bytes.texture_bytes;
    else
      EXPECT_LT(bytes.texture_bytes, rgba8 / 2) << how;
  }
}

TEST_F(FlatGl, TheCacheGivesTheSamePictureAndDamageIsRepaired) {
  const char* before = getenv("CROWDBENCH_CACHE_DIR");
  const std::string old = before ? before : "";
  const support::ScratchFolder folder;
  setenv("CROWDBENCH_CACHE_DIR", folder.path().c_str(), 1);
  const std::string spec = "flat:views=sphere-4x2,frames=2,texels=48";
  Renderer renderer(context(), walker());
  const auto frame = frame_from(90 * kDegrees, 0, 0, middle_of(walker()));
  const auto draw = [&](bool expect_cached) {
    const auto flat = make(walker(), spec, true);
    EXPECT_EQ(flat->bake_info().cached, expect_cached);
    EXPECT_GT(flat->footprint().disk_bytes, 0U);
    return renderer.capture(frame, *flat).colour;
  };
  const Image8 first = draw(false);
  EXPECT_EQ(draw(true), first);
  for (const auto& entry : fs::directory_iterator(folder / "bakes")) {
    std::vector<uint8_t> bytes = read_file(entry.path());
    bytes[bytes.size() / 2] ^= 1;
    std::ofstream(entry.path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  EXPECT_EQ(draw(false), first);
  EXPECT_EQ(draw(true), first);
  before ? setenv("CROWDBENCH_CACHE_DIR", old.c_str(), 1) : unsetenv("CROWDBENCH_CACHE_DIR");
}

}  // namespace
}  // namespace crowdbench::renderers
