// Light that a character gives off: every representation shows it as the mesh does.
#include "renderers/bake/emission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/colour.h"
#include "gl_test_support.h"
#include "scene/cast/cast.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;

const std::string kReference = "reference";
constexpr float kTall = 1.6F;    // metres
constexpr float kRow = 0.4F;     // of the front
constexpr double kAway = 120.0;  // metres from the eye: perspective enlarges the front by a fifth of a percent

// A box whose front (+Z) has four rows: one that does not glow, one of a plain emissive factor, one beyond 1 whose
// image is bright on the left alone, and an unlit one, whose emissive factor the mesh leaves out.
scene::Character lantern() {
  scene::Character c;
  c.name = "lantern";
  c.skeleton.nodes.push_back({.name = "root"});
  c.skeleton.joints.push_back({.name = "root", .node = 0});
  c.skeleton.root_node = 0;
  c.materials.push_back({.base_colour = glm::vec4(0.3F), .slot = 0});
  c.materials.push_back({.base_colour = glm::vec4(0.1F), .emissive = {0.5F, 0.25F, 0.0F}, .slot = 1});
  c.materials.push_back(
      {.base_colour = glm::vec4(0.1F), .emissive = {4.0F, 2.0F, 1.0F}, .emissive_image = 0, .slot = 2});
  c.materials.push_back(
      {.base_colour = {0.0F, 0.2F, 0.05F, 1.0F}, .emissive = {1.0F, 0.0F, 1.0F}, .unlit = true, .slot = 3});
  scene::Texture halves;
  halves.image = Image8(64, 1, 4);
  for (int x = 0; x < 32; ++x) std::copy_n(std::array<uint8_t, 3>{255, 128, 0}.begin(), 3, halves.image.at(x, 0));
  c.images.push_back(halves);
  scene::Mesh& mesh = c.mesh;
  const auto quad = [&](const glm::vec3& a, const glm::vec3& right, const glm::vec3& up, int material) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::vec2& at : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
      mesh.positions.push_back(a + at.x * right + at.y * up);
      mesh.normals.push_back(glm::normalize(glm::cross(right, up)));
      mesh.uvs.emplace_back(at.x, 1 - at.y);
    }
    const auto begin = static_cast<uint32_t>(mesh.indices.size());
    for (const uint32_t k : {0U, 1U, 2U, 0U, 2U, 3U}) mesh.indices.push_back(first + k);
    mesh.primitives.push_back(
        {.first_index = begin, .index_count = 6, .first_vertex = first, .vertex_count = 4, .material = material});
  };
  const float x = 0.4F;
  const float z = 0.25F;
  for (int row = 0; row < 4; ++row) quad({-x, kRow * static_cast<float>(row), z}, {2 * x, 0, 0}, {0, kRow, 0}, row);
  quad({x, 0, -z}, {-2 * x, 0, 0}, {0, kTall, 0}, 0);
  quad({x, 0, z}, {0, 0, -2 * z}, {0, kTall, 0}, 0);
  quad({-x, 0, -z}, {0, 0, 2 * z}, {0, kTall, 0}, 0);
  quad({-x, kTall, z}, {2 * x, 0, 0}, {0, 0, -2 * z}, 0);
  quad({-x, 0, -z}, {2 * x, 0, 0}, {0, 0, 2 * z}, 0);
  mesh.joints.assign(mesh.positions.size(), glm::u16vec4(0));
  mesh.weights.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
  c.content_hash = c.name;
  return c;
}

const scene::Cast& glowing_cast() {
  static const scene::Cast one = cast_of(lantern());
  return one;
}

// The lantern alone before black, `pixels` tall, turned by `turns`.
scene::Frame picture(double pixels, double turns, bool lit) {
  const int size = static_cast<int>(pixels * 1.25);
  const double fov = 2 * std::atan(0.5 * static_cast<double>(kTall) * size / pixels / kAway);
  scene::Frame frame = frame_of_one(kAway, 0.5 * static_cast<double>(kTall), size, size, fov * 180 / std::numbers::pi);
  frame.background = glm::vec4(0.0F, 0.0F, 0.0F, 1.0F);
  if (!lit) frame.light.ambient = frame.light.diffuse = 0.0F;
  add_agent(frame, glowing_cast(), {0, 0, 0}, 1, 0.0, static_cast<float>(turns));
  return frame;
}

// Mean linear colour of what lies `inset` metres and more within a rectangle of the front (metres, from its lower left
// corner), as a picture of `pixels` tall shows it straight from the front.
glm::dvec3 mean_of(const Capture& c, double pixels, const glm::dvec2& low, const glm::dvec2& high, double inset) {
  // The front lies nearer than the pivot.
  const double metre = pixels / static_cast<double>(kTall) * kAway / (kAway - 0.25);
  glm::dvec3 sum(0.0);
  int count = 0;
  for (int y = 0; y < c.linear.height; ++y)
    for (int x = 0; x < c.linear.width; ++x) {
      const glm::dvec2 at((x + 0.5 - 0.5 * c.linear.width) / metre + 0.4,
                          (0.5 * c.linear.height - y - 0.5) / metre + 0.5 * static_cast<double>(kTall));
      if (at.x < low.x + inset || at.y < low.y + inset || at.x > high.x - inset || at.y > high.y - inset) continue;
      const float* p = c.linear.at(x, y);
      sum += glm::dvec3(p[0], p[1], p[2]);
      ++count;
    }
  EXPECT_GT(count, 50);
  return sum / static_cast<double>(count);
}

glm::dvec3 whole(const Capture& c) {
  glm::dvec3 sum(0.0);
  for (size_t i = 0; i < c.linear.pixels(); ++i)
    sum += glm::dvec3(c.linear.data[4 * i], c.linear.data[4 * i + 1], c.linear.data[4 * i + 2]);
  return sum;
}

// What 8 bits leave of light e under a peak: half a code of the capture's square root, half a code of the map's sRGB,
// and half a code for how a driver decodes that. steps: of the map.
double code_error(double e, double peak, double steps) {
  const double f = std::clamp(e / peak, 0.0, 1.0);
  const double slope = 2.4 / 1.055 * std::pow((linear_to_srgb(f) + 0.055) / 1.055, 1.4);
  return peak * (std::sqrt(f) / 255 + slope * (0.5 / steps + 0.5 / 255)) + 1e-3;
}

// How a type is asked for, and the ways in which flat stores and draws its maps.
struct Asked {
  std::string spec;
  double steps = 255;  // codes of a map's component
};
std::vector<Asked> asked() {
  std::vector<Asked> out;
  for (const RepresentationType& type : representation_types()) out.push_back({example_spec(type)});
  for (const char* how : {"blend=3", "depth=nailboard", "quad=square", "layers=1"})
    out.push_back({"flat:views=sphere-4x2," + std::string(how)});
  // Colours of five bits, and of two codes between those that a block has.
  out.push_back({"flat:views=sphere-4x2,compress=bc", 31});
  out.push_back({"flat:views=sphere-4x2,compress=bc,blend=3,depth=nailboard", 31});
  out.push_back({"polypostor:views=sphere-4x2,key=two_keys"});
  out.push_back({"relief:search=cone"});
  return out;
}

class EmissionGl : public testing::GlTest, public ::testing::WithParamInterface<Asked> {
 protected:
  static void TearDownTestSuite() { made_.clear(); }
  static Representation& made(const std::string& spec) {
    auto& one = made_[spec];
    if (!one)
      one = make_representation({.context = context(), .cast = glowing_cast(), .use_cache = false, .progress = false},
                                parse_spec(spec));
    return *one;
  }
  static Capture draw(scene::Frame frame, const std::string& spec, int supersample = 1) {
    frame.antialiasing.supersample = supersample;
    Renderer renderer(context(), glowing_cast());
    return renderer.capture(frame, made(spec), {.linear = true});
  }
  static std::map<std::string, std::unique_ptr<Representation>> made_;
};
std::map<std::string, std::unique_ptr<Representation>> EmissionGl::made_;

// What each row shows, away from its edges: lit, and by its own light alone.
TEST_P(EmissionGl, RowsShowWhatTheMeshShows) {
  CROWDBENCH_SKIP_SANITIZED("TheWholeLightIsTheMeshs");
  const double texel = made(GetParam().spec).texel_metres(0);
  for (const double pixels : {120.0, 240.0})
    for (const bool lit : {false, true}) {
      const scene::Frame frame = picture(pixels, 0, lit);
      const Capture reference = draw(frame, kReference);
      const Capture test = draw(frame, GetParam().spec);
      const double inset = 2 * kTall / pixels + 2 * texel;
      for (int row = 0; row < 4; ++row)
        for (const double left : {0.0, 0.4}) {
          const glm::dvec2 low(left, row * kRow);
          const glm::dvec2 high = low + glm::dvec2(0.4, kRow);
          const glm::dvec3 wanted = mean_of(reference, pixels, low, high, inset);
          const glm::dvec3 shown = mean_of(test, pixels, low, high, inset);
          for (int c = 0; c < 3; ++c) {
            // The base colour has eight bits too, and so has the normal.
            const double base = lit ? 0.01 : 0.0;
            EXPECT_NEAR(shown[c], wanted[c], code_error(wanted[c], 4.0, GetParam().steps) + base)
                << pixels << " pixels, row " << row << " from " << left << ", component " << c << (lit ? ", lit" : "");
          }
        }
      if (!lit) {
        const glm::dvec3 plain = mean_of(reference, pixels, {0, kRow}, {0.8, 2 * kRow}, inset);
        EXPECT_NEAR(plain.r, 0.5, 1e-5);
        EXPECT_NEAR(plain.g, 0.25, 1e-5);
        const glm::dvec3 bright = mean_of(reference, pixels, {0, 2 * kRow}, {0.4, 3 * kRow}, inset);
        EXPECT_NEAR(bright.r, 4.0, 1e-5) << "beyond 1, as the mesh keeps it";
      }
    }
}

// All the light that arrives, down to figures of a few pixels: maps are filtered in linear light and their levels are
// means, so that a small lamp is as strong as it is. From behind there is none.
TEST_P(EmissionGl, TheWholeLightIsTheMeshs) {
  for (const double pixels : {240.0, 120.0, 60.0, 30.0}) {
    const scene::Frame frame = picture(pixels, 0, false);
    const glm::dvec3 wanted = whole(draw(frame, kReference, 5));
    const glm::dvec3 shown = whole(draw(frame, GetParam().spec, 5));
    // A twentieth: what a box's sharp corners lose to a silhouette of texels. Polypostors have outlines as an eye five
    // heights away sees them, to whom the front, 0.25 m before the pivot, is larger.
    const bool fitted = GetParam().spec.starts_with("polypostor");
    // A lamp of 0.4 m at the outline grows by its discs' reach, up to a pixel: a tenth at 30 pixels.
    const double grown = GetParam().spec.starts_with("surfel") ? 1.07 : 1;
    const double nearer = fitted ? 5 * kTall / (5 * kTall - 0.25) : 1;
    for (int c = 0; c < 2; ++c) {
      EXPECT_GT(shown[c] / wanted[c], 0.95) << pixels << " pixels";
      EXPECT_LT(shown[c] / wanted[c], 1.05 * nearer * nearer * grown) << pixels << " pixels";
    }
  }
  const glm::dvec3 front = whole(draw(picture(120, 0, false), kReference));
  const scene::Frame behind = picture(120, 0.5, false);
  EXPECT_GT(whole(draw(picture(120, 0.5, true), GetParam().spec)).g, 100);
  const glm::dvec3 back = whole(draw(behind, kReference));
  EXPECT_EQ(back.r, 0.0);
  EXPECT_LE(whole(draw(behind, GetParam().spec)).r, 0.002 * front.r) << "seen from behind";
}

// An outfit colours what is lit; it does not tint the light given off.
TEST_P(EmissionGl, OutfitsDoNotTintIt) {
  CROWDBENCH_SKIP_SANITIZED("TheWholeLightIsTheMeshs");
  scene::Frame frame = picture(120, 0, false);
  const Capture plain = draw(frame, GetParam().spec);
  scene::Outfit outfit;
  for (glm::vec4& c : outfit.colours) c = glm::vec4(0.1F, 0.2F, 0.9F, 1.0F);
  frame.outfits.push_back(outfit);
  frame.agents[0][0].outfit = 1;
  const Capture tinted = draw(frame, GetParam().spec);
  const double inset = 2 * kTall / 120;
  for (int row = 1; row < 3; ++row) {
    const glm::dvec2 low(0, row * kRow);
    const glm::dvec2 high(0.4, (row + 1) * kRow);
    EXPECT_EQ(mean_of(plain, 120, low, high, inset), mean_of(tinted, 120, low, high, inset));
  }
  // The unlit row is: its base colour is what is shown.
  const glm::dvec3 unlit = mean_of(tinted, 120, {0.1, 3.2 * kRow}, {0.7, 3.8 * kRow}, 0);
  EXPECT_NEAR(unlit.g, 0.2 * 0.2, 0.005);
}

INSTANTIATE_TEST_SUITE_P(Registered, EmissionGl, ::testing::ValuesIn(asked()),
                         [](const ::testing::TestParamInfo<Asked>& param) {
                           std::string name;
                           for (const char c : param.param.spec)
                             name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

class EmissionBytesGl : public testing::GlTest {};
class EmissionCrowdGl : public testing::GlTest {};

TEST(EmissionPeak, IsTheBrightestThatIsInUse) {
  scene::Character c = lantern();
  EXPECT_FLOAT_EQ(emission_peak(c), 4.0F);
  // 128 is 0.2159 of linear light.
  c.images[0].image = Image8(2, 1, 4);
  c.images[0].image.data = {0, 128, 0, 255, 0, 0, 0, 255};
  EXPECT_NEAR(emission_peak(c), 0.5, 1e-6) << "the row without an image; 2 x 0.2159 is less";
  c.materials[1].emissive = glm::vec3(0.0F);
  EXPECT_NEAR(emission_peak(c), 2 * srgb_to_linear(128 / 255.0), 1e-6);
  c.images[0].image = Image8(2, 1, 4);
  EXPECT_EQ(emission_peak(c), 0.0F) << "a black image, and an unlit material";
  c.materials[3].unlit = false;
  EXPECT_EQ(emission_peak(c), 1.0F);
  for (scene::Primitive& p : c.mesh.primitives) p.material = 0;
  EXPECT_EQ(emission_peak(c), 0.0F) << "nothing uses it";
}

// A character that does not glow is stored and drawn from the same bytes whether its materials have an emissive image
// or not; one that does has a map more: 4 bytes a texel of 12, or half a byte.
TEST_F(EmissionBytesGl, OnlyThoseThatGlowHaveAMap) {
  const auto bytes_of = [](const scene::Character& character, const std::string& spec) {
    const scene::Cast one = cast_of(character);
    return make_representation({.context = context(), .cast = one, .use_cache = false, .progress = false},
                               parse_spec(spec))
        ->footprint();
  };
  scene::Character dark = lantern();
  for (scene::Material& m : dark.materials) m.emissive = glm::vec3(0.0F), m.emissive_image = -1;
  scene::Character black = lantern();
  black.images[0].image = Image8(2, 1, 4);
  black.materials[1].emissive = glm::vec3(0.0F);
  for (const auto& [spec, ratio] : {std::pair<std::string, double>{"flat:views=sphere-4x2,texels=32", 12.0 / 8},
                                    {"flat:views=sphere-4x2,texels=32,compress=bc", (2.5 + 0.5) / 2.5},
                                    {"polypostor:views=sphere-4x2,texels=32", 11.0 / 7},
                                    {"relief:map=32", (20.5 + 8) / 20.5}}) {
    const Footprint none = bytes_of(dark, spec);
    EXPECT_EQ(bytes_of(black, spec).texture_bytes, none.texture_bytes) << spec;
    EXPECT_EQ(bytes_of(black, spec).buffer_bytes, none.buffer_bytes) << spec;
    EXPECT_DOUBLE_EQ(static_cast<double>(bytes_of(lantern(), spec).texture_bytes),
                     ratio * static_cast<double>(none.texture_bytes))
        << spec;
  }
}

// Characters of one crowd with and without a map, whichever comes first.
TEST_F(EmissionCrowdGl, ADarkOneBesideAGlowingOneStaysDark) {
  scene::Character dark = lantern();
  for (scene::Material& m : dark.materials) m.emissive = glm::vec3(0.0F);
  dark.materials[3].unlit = false;
  dark.content_hash = "dark";
  for (const char* spec : {"flat:views=sphere-4x2,texels=32", "flat:views=sphere-4x2,texels=32,compress=bc",
                           "polypostor:views=sphere-4x2,texels=32", "relief:map=32"})
    for (const bool dark_first : {false, true}) {
      scene::Cast both = cast_of(dark_first ? dark : lantern());
      const scene::Cast second = cast_of(dark_first ? lantern() : dark);
      both.characters.push_back(second.characters[0]);
      both.banks.push_back(second.banks[0]);
      both.shares = {0.5, 0.5};
      scene::Frame frame = picture(60, 0, false);
      frame.agents.push_back(frame.agents[0]);
      frame.agents[0][0].position.x -= 0.5F;
      frame.agents[1][0].position.x += 0.5F;
      frame.agents[1][0].id = 2;
      Renderer renderer(context(), both);
      const auto one = make_representation({.context = context(), .cast = both, .use_cache = false, .progress = false},
                                           parse_spec(spec));
      const Capture c = renderer.capture(frame, *one, {.linear = true});
      std::array<double, 3> light{};  // by id
      for (size_t i = 0; i < c.ids.data.size(); ++i) light[c.ids.data[i]] += static_cast<double>(c.linear.data[4 * i]);
      EXPECT_EQ(light[dark_first ? 1 : 2], 0.0) << spec;
      EXPECT_GT(light[dark_first ? 2 : 1], 100.0) << spec;
    }
}

}  // namespace
}  // namespace crowdbench::renderers
