// Golden pictures: one small picture a representation, kept in tests/data/golden. They say that nothing moved which
// nobody meant to move; what is right is said by the other tests.
//
// What may differ, and why: tests/support/picture_comparison.h. Each test moves its picture by 1/128 pixel and finds it
// within (small figures are the worst, 1.3 %), and by half a pixel, with its light turned by 5 degrees or 3 % less, by
// a whole pixel, mirrored, and finds it outside.
//
// CROWDBENCH_TEST_PICTURES names a folder for all pictures and their differences, which are then also told in numbers;
// without it those that differ too much go to the system's temporary folder.
// CROWDBENCH_UPDATE_GOLDEN=1 writes the pictures anew instead of comparing; look at each before it is committed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "core/image_io.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "test_paths.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/picture_comparison.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using support::compare;
using support::kBias;
using support::kCodes;
using support::kEdges;
using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using Comparison = support::PictureComparison;

constexpr int kSide = 160;

struct Golden {
  const char* name;
  const char* spec;
  double distance;    // metres: 5.5 gives figures of about 130 pixels, 15 of about 45
  bool meet = false;  // whether the figures pass through each other
};
const std::vector<Golden>& goldens() {
  static const std::vector<Golden> all = {
      {"mesh", "mesh", 5.5},
      {"mesh_level", "mesh:triangles=500", 5.5},
      {"rigid", "rigid:poses=8", 5.5},
      {"pseudo", "pseudo", 5.5},
      {"preskinned", "preskinned:passes=2", 5.5},
      {"posecache", "posecache:keys=4", 5.5},
      {"dynamic", "dynamic", 5.5},
      {"layered", "layered:views=sphere-6x2,frames=4", 5.5},
      {"perjoint", "perjoint:views=cube-3", 5.5},
      {"surfel", "surfel", 5.5},
      {"surfel_far", "surfel", 15},
      {"hybrid", "hybrid(mesh,polypostor:views=sphere-4x1,frames=2,texels=64,distance=4,fade=4)", 5.5},
      {"polypostor", "polypostor:views=sphere-6x2,frames=4", 5.5},
      {"polypostor_far", "polypostor:views=sphere-6x2,frames=4", 15},
      {"flat", "flat:views=sphere-6x2,frames=4", 5.5},
      {"flat_nailboard", "flat:views=sphere-6x2,frames=4,depth=nailboard", 5.5, true},
      {"flat_blend", "flat:views=sphere-6x2,frames=4,blend=3", 5.5},
      {"flat_between", "flat:views=sphere-6x2,frames=4,frames_between=move_blend", 5.5},
      {"flat_far", "flat:views=sphere-6x2,frames=4", 15},
      {"relief", "relief:map=64", 5.5},
      {"relief_far", "relief:map=64", 15},
  };
  return all;
}

const scene::Cast& cast() {
  static const scene::Cast one = cast_of(scene::make_mannequin({.triangles = 2200}), 10.0);
  return one;
}

struct Nudge {
  double right = 0, up = 0;  // pixels, of the whole picture
  double light = 0;          // radians about the vertical
  double strength = 1;       // of the light
};

// One figure before another, turned, in clothes of several colours. Between stored views, and between stored frames.
scene::Frame frame_of(double distance, bool meet, const Nudge& nudge) {
  scene::Frame frame = frame_of_one(distance, 1.6, kSide, kSide, 24.0);
  const double pixel = 2 * distance * std::tan(frame.camera.fov_y / 2) / kSide;  // metres, where the first one stands
  frame.camera.eye.x -= nudge.right * pixel;
  frame.camera.eye.y -= nudge.up * pixel;
  frame.camera.target = {frame.camera.eye.x, frame.camera.eye.y - 0.7, 0};
  frame.origin = frame.camera.eye;
  scene::Outfit clothes;
  for (size_t k = 0; k < clothes.colours.size(); ++k)
    clothes.colours[k] = {k % 2 == 0 ? 0.9F : 0.3F, k % 3 == 0 ? 0.8F : 0.4F, k % 5 == 0 ? 0.9F : 0.25F, 1.0F};
  frame.outfits.push_back(clothes);
  const glm::vec3 l = frame.light.direction;
  const auto c = static_cast<float>(std::cos(nudge.light));
  const auto s = static_cast<float>(std::sin(nudge.light));
  frame.light.direction = {c * l.x + s * l.z, l.y, c * l.z - s * l.x};
  frame.light.ambient *= static_cast<float>(nudge.strength);
  frame.light.diffuse *= static_cast<float>(nudge.strength);
  add_agent(frame, cast(), {-0.25, 0, 0}, 1, 0.17, 0.06F);
  frame.agents[0].back().outfit = 1;
  add_agent(frame, cast(), meet ? glm::dvec3(-0.1, 0, -0.05) : glm::dvec3(0.4, 0, -0.9), 2, 0.6, 0.7F);
  return frame;
}

Image8 picture_of(const Golden& golden, Renderer& renderer, Representation& representation, const Nudge& nudge = {}) {
  scene::Frame frame = frame_of(golden.distance, golden.meet, nudge);
  if (representation.has_history()) {
    // Both figures were near two ticks ago: the picture shows them in the middle of a fade.
    (void)renderer.capture(frame_of(golden.distance / 3, golden.meet, nudge), representation);
    frame.tick = 1;
    (void)renderer.capture(frame, representation);
    frame.tick = 2;
  }
  return renderer.capture(frame, representation).colour;
}

Image8 shifted(const Image8& image, int right, int down) {
  Image8 out = image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(std::clamp(x - right, 0, image.width - 1), std::clamp(y - down, 0, image.height - 1)), 4,
                  out.at(x, y));
  return out;
}

Image8 mirrored(const Image8& image) {
  Image8 out = image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) std::copy_n(image.at(image.width - 1 - x, y), 4, out.at(x, y));
  return out;
}

// Grey where the pictures agree, lighter or darker, eightfold, where they do not.
Image8 difference_of(const Image8& test, const Image8& reference) {
  Image8 out = test;
  for (size_t i = 0; i < out.data.size(); ++i)
    if (i % 4 != 3)
      out.data[i] = static_cast<uint8_t>(std::clamp(128 + 8 * (int{test.data[i]} - int{reference.data[i]}), 0, 255));
  return out;
}

class GoldenGl : public testing::GlTest, public ::testing::WithParamInterface<Golden> {
 protected:
  // Kept while the next picture wants the same: bakes take seconds.
  static Representation& shared(const Golden& golden) {
    if (spec_ != golden.spec) {
      MakeContext make{.context = context(), .cast = cast()};
      make.use_cache = false;
      make.progress = false;
      representation_ = make_representation(make, parse_spec(golden.spec));
      spec_ = golden.spec;
    }
    return *representation_;
  }
  static void TearDownTestSuite() {
    representation_.reset();
    spec_.clear();
  }
  static std::unique_ptr<Representation> representation_;
  static std::string spec_;
};
std::unique_ptr<Representation> GoldenGl::representation_;
std::string GoldenGl::spec_;

TEST_P(GoldenGl, IsWhatItWas) {
  CROWDBENCH_SKIP_SANITIZED("the contract, of the same representations");
  const Golden& golden = GetParam();
  Representation& representation = shared(golden);
  Renderer renderer(context(), cast());
  const Image8 picture = picture_of(golden, renderer, representation);
  const fs::path path = fs::path(CROWDBENCH_TEST_DATA) / "golden" / (std::string(golden.name) + ".png");
  if (std::getenv("CROWDBENCH_UPDATE_GOLDEN") != nullptr) {
    fs::create_directories(path.parent_path());
    write_png(path, picture);
    GTEST_SKIP() << "wrote " << path;
  }
  const auto reference = std::get<Image8>(read_image(path));
  ASSERT_EQ(reference.width, picture.width);
  ASSERT_EQ(reference.height, picture.height);
  ASSERT_EQ(reference.channels, 4);
  const Comparison c = compare(picture, reference);
  const char* const chosen = std::getenv("CROWDBENCH_TEST_PICTURES");
  if (chosen != nullptr)
    std::printf("%s: %.3f %% of %zu pixels differ by more than %d codes, channels by %+.3f, %+.3f, %+.3f on the mean\n",
                golden.name, 100 * c.differing, c.shown, kCodes, c.bias[0], c.bias[1], c.bias[2]);
  if (chosen != nullptr || !c.same()) {
    const fs::path out = chosen != nullptr ? fs::path(chosen) : fs::path(::testing::TempDir()) / "crowdbench_golden";
    fs::create_directories(out);
    write_png(out / (std::string(golden.name) + ".png"), picture);
    write_png(out / (std::string(golden.name) + "_difference.png"), difference_of(picture, reference));
    EXPECT_TRUE(c.same()) << golden.name << ": " << 100 * c.differing << " % of " << c.shown
                          << " pixels differ by more than " << kCodes << " codes, " << 100 * kEdges
                          << " % may; channels by " << c.bias[0] << ", " << c.bias[1] << ", " << c.bias[2]
                          << " on the mean, " << kBias << " may. The picture and the difference are in " << out
                          << "; the golden is " << path;
  }

  // What must be seen: a picture moved by a pixel, mirrored, or lit otherwise by little.
  for (const auto& [right, down] : {std::pair(1, 0), std::pair(0, 1), std::pair(-1, 0), std::pair(0, -1)})
    EXPECT_FALSE(compare(shifted(picture, right, down), picture).same()) << right << ", " << down;
  EXPECT_FALSE(compare(mirrored(picture), picture).same());
  Nudge turned;
  turned.light = 5 * std::numbers::pi / 180;
  EXPECT_FALSE(compare(picture_of(golden, renderer, representation, turned), picture).same()) << "light, 5 degrees";
  Nudge dimmed;
  dimmed.strength = 0.97;
  EXPECT_FALSE(compare(picture_of(golden, renderer, representation, dimmed), picture).same()) << "light, 3 % less";
  Nudge moved;
  moved.right = 0.5;
  EXPECT_FALSE(compare(picture_of(golden, renderer, representation, moved), picture).same()) << "half a pixel";

  // What must not: as far as drivers' grids can move it.
  for (const auto& [right, up] :
       {std::pair(1.0 / 128, 0.0), std::pair(0.0, 1.0 / 128), std::pair(-1.0 / 128, -1.0 / 128)}) {
    const Comparison r = compare(picture_of(golden, renderer, representation, {.right = right, .up = up}), picture);
    EXPECT_TRUE(r.same()) << right << ", " << up;
  }
}

TEST(Golden, EveryRepresentationHasOne) {
  for (const RepresentationType& type : representation_types())
    EXPECT_TRUE(std::any_of(goldens().begin(), goldens().end(),
                            [&](const Golden& golden) { return parse_spec(golden.spec).name == type.name; }))
        << type.name << " has no line in goldens()";
}

INSTANTIATE_TEST_SUITE_P(Pictures, GoldenGl, ::testing::ValuesIn(goldens()),
                         [](const ::testing::TestParamInfo<Golden>& param) { return std::string(param.param.name); });

TEST(GoldenComparison, CountsAsByHand) {
  Image8 reference(10, 10, 4);
  std::fill(reference.data.begin(), reference.data.end(), uint8_t{128});
  EXPECT_FALSE(compare(reference, reference).same()) << "nobody is shown: that is no comparison";
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 10; ++x) reference.at(x, y)[0] = 200;
  Comparison c = compare(reference, reference);
  EXPECT_EQ(c.shown, 50U);
  EXPECT_TRUE(c.same());
  Image8 test = reference;
  test.at(3, 3)[1] = 128 + kCodes;
  EXPECT_TRUE(compare(test, reference).same());
  EXPECT_EQ(compare(test, reference).differing, 0);
  test.at(3, 3)[1] = 128 + kCodes + 1;
  c = compare(test, reference);
  EXPECT_NEAR(c.differing, 1.0 / 50, 1e-12);
  EXPECT_NEAR(c.bias[1], (kCodes + 1) / 50.0, 1e-12);
  test.at(4, 3)[1] = 128 - kCodes - 1;
  EXPECT_FALSE(compare(test, reference).same()) << "two of fifty";
  test = reference;
  test.at(0, 9)[2] = 0;
  EXPECT_EQ(compare(test, reference).shown, 51U) << "shown in either";
  // Half of the pixels a code darker: more than the mean may.
  test = reference;
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 3; ++y) --test.at(x, y)[0];
  EXPECT_FALSE(compare(test, reference).same());
}

}  // namespace
}  // namespace crowdbench::renderers
