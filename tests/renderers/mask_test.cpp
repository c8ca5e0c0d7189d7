// Masked figures: the holes of the mesh are holes in everything that is baked from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gl_test_support.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_bake.h"
#include "solids.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;

// A card of 1 m x 1.6 m, seen from both sides, with so many texels that are there or not.
scene::Character masked_card(int width, int height, float cutoff, bool (*there)(int x, int y)) {
  scene::Character character = card(1.0F, 1.6F, glm::vec4(0.8F, 0.5F, 0.3F, 1.0F));
  scene::Texture mask;
  mask.image = Image8(width, height, 4);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      uint8_t* texel = mask.image.at(x, y);
      texel[0] = texel[1] = texel[2] = 255;
      texel[3] = there(x, y) ? 255 : 0;
    }
  character.images.push_back(mask);
  scene::Material& material = character.materials.front();
  material.base_colour_image = 0;
  material.alpha_cutoff = cutoff;
  material.double_sided = true;
  character.mesh.uvs.clear();
  for (const glm::vec3& p : character.mesh.positions) character.mesh.uvs.emplace_back(p.x + 0.5F, 1.0F - p.y / 1.6F);
  return character;
}

// 3 x 4 round holes.
scene::Character card_with_holes(float cutoff) {
  return masked_card(96, 128, cutoff, [](int x, int y) {
    const double dx = x % 32 - 15.5;
    const double dy = y % 32 - 15.5;
    return dx * dx + dy * dy >= 100;
  });
}

Capture draw(const scene::Cast& cast, const std::string& spec) {
  scene::Frame frame = frame_of_one(4.0, 0.8, 240, 240, 28.0);
  add_agent(frame, cast, {0, 0, 0}, 7);
  Renderer renderer(context(), cast);
  const auto representation = make(cast, spec);
  return renderer.capture(frame, *representation, {});
}

double overlap(const Capture& a, const Capture& b) {
  size_t both = 0;
  size_t any = 0;
  for (size_t i = 0; i < a.ids.data.size(); ++i) {
    both += a.ids.data[i] != 0 && b.ids.data[i] != 0 ? 1 : 0;
    any += a.ids.data[i] != 0 || b.ids.data[i] != 0 ? 1 : 0;
  }
  return double(both) / double(any);
}

struct Pattern {
  const char* name;
  bool (*there)(int x, int y);
  double covers;  // of the card
};
const Pattern kPatterns[] = {{"stripes", [](int x, int) { return x / 4 % 2 == 0; }, 0.5},
                             {"fine stripes", [](int x, int) { return x % 2 == 0; }, 0.5},
                             {"checkers", [](int x, int y) { return (x / 2 + y / 2) % 2 == 0; }, 0.5},
                             {"net", [](int x, int y) { return x % 8 == 0 || y % 8 == 0; }, 15.0 / 64},
                             {"holes", [](int x, int y) { return x % 8 > 1 || y % 8 > 1; }, 60.0 / 64}};

// The card with two specks before and behind it: it stands in the middle of a box that is so deep, metres.
scene::Character amid(scene::Character card, float deep) {
  scene::Mesh& mesh = card.mesh;
  for (const float z : {-deep / 2, deep / 2}) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::vec2& at : {glm::vec2(0, 0.8F), glm::vec2(0.002F, 0.8F), glm::vec2(0, 0.802F)}) {
      mesh.positions.emplace_back(at.x, at.y, z);
      mesh.normals.emplace_back(0, 0, 1);
      mesh.uvs.emplace_back(0.01F, 0.01F);
      mesh.joints.push_back(mesh.joints.front());
      mesh.weights.push_back(mesh.weights.front());
    }
    mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2});
  }
  mesh.primitives.back().index_count += 6;
  mesh.primitives.back().vertex_count += 6;
  return card;
}

// Pixels that a crowd of cards covers which are so many pixels tall, at many places between pixels.
double pixels_of(const scene::Character& card, const std::string& spec, double height, float turns = 0) {
  const scene::Cast cast = cast_of(card);
  constexpr double kFov = 8.0;
  constexpr int kSize = 360;
  const double distance = 1.6 * kSize / height / (2 * std::tan(kFov * 3.14159265358979 / 360));
  scene::Frame frame = frame_of_one(distance, 0, kSize, kSize, kFov);
  const int each = static_cast<int>(kSize / (1.2 * height));
  for (int i = 0; i < each * each; ++i)
    add_agent(frame, cast,
              {1.47 * (i % each - each / 2.0) + 0.37 * (i * 37 % 101) / 101, 1.83 * (i / each - each / 2.0), 0},
              uint32_t(i + 1), 0.0, turns);
  Renderer renderer(context(), cast);
  const Capture capture = renderer.capture(frame, *make(cast, spec), {});
  return static_cast<double>(std::ranges::count_if(capture.ids.data, [](uint32_t id) { return id != 0; }));
}

class MaskLevelsGl : public GlTest {};

// A regular pattern averages to one grey: it must not vanish at a distance, nor close.
TEST_F(MaskLevelsGl, PatternsCoverAsMuchAtADistanceAsNear) {
  for (const double height : {200.0, 58.0, 37.0, 21.0, 11.0}) {
    const double all = pixels_of(masked_card(128, 128, 0.0F, kPatterns[0].there), "mesh", height);
    for (const Pattern& pattern : kPatterns) {
      const double there = pixels_of(masked_card(128, 128, 0.5F, pattern.there), "mesh", height);
      EXPECT_NEAR(there / all, pattern.covers, 0.03) << pattern.name << " " << height << " pixels tall";
    }
  }
}

// Texels of one axis's map that are covered at a level, as a fraction of the map.
double covered_at(const ReliefModel& model, const AtlasPlan& plan, const Atlas& atlas, size_t axis, uint32_t level) {
  const auto texels = static_cast<size_t>(model.boxes[0].texels);
  const size_t n = texels >> level;
  const AtlasPlace place = atlas_place(plan, 0, texels, level);
  size_t count = 0;
  for (size_t v = 0; v < n; ++v)
    for (size_t u = 0; u < n; ++u) {
      const uint16_t* d =
          atlas.depth.data() + 2 * ((place.top + v) * static_cast<size_t>(plan.width) + place.left + axis * texels + u);
      count += d[0] <= d[1] ? 1 : 0;
    }
  return static_cast<double>(count) / static_cast<double>(n * n);
}

// A relief's levels cover what the first does: the whole map and, where there is a pattern, each quarter of it alike.
TEST(MaskRelief, LevelsKeepTheArea) {
  std::vector<Pattern> patterns(std::begin(kPatterns), std::end(kPatterns));
  patterns.push_back({"dots", [](int x, int y) { return x % 8 / 3 == 1 && y % 8 / 3 == 1; }, 9.0 / 64});
  for (const Pattern& pattern : patterns) {
    const ReliefModel model = bake_relief(masked_card(128, 128, 0.5F, pattern.there), {.map_size = 128});
    const AtlasPlan plan = plan_atlas(model);
    const Atlas atlas = fill_atlas(model, plan);
    EXPECT_NEAR(covered_at(model, plan, atlas, 2, 0), pattern.covers, 0.03) << pattern.name;
    for (uint32_t level = 1; level < 5; ++level)
      EXPECT_NEAR(covered_at(model, plan, atlas, 2, level), covered_at(model, plan, atlas, 2, 0),
                  1.0 / ((128U >> level) * (128U >> level)))
          << pattern.name << ", level " << level;
  }
  // A ball's outline is a disc of 127 texels. Half a texel of 8 by 8 is 0.008.
  const ReliefModel ball = bake_relief(testing::sphere(0.5, 64), {.map_size = 128});
  const AtlasPlan plan = plan_atlas(ball);
  const Atlas atlas = fill_atlas(ball, plan);
  for (uint32_t level = 0; level < 5; ++level)
    for (size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(covered_at(ball, plan, atlas, axis, level), 3.14159265 / 4 * 127 * 127 / (128 * 128), 0.009)
          << axis << ", level " << level;
}

// And so do its pictures, of cards 40 to 5 pixels tall.
TEST_F(MaskLevelsGl, ReliefsCoverWhatThePatternLeaves) {
  for (const double height : {40.0, 12.0, 5.0}) {
    const double all = pixels_of(masked_card(128, 128, 0.0F, kPatterns[0].there), "relief:capture=bind", height);
    for (const size_t k : {size_t{2}, size_t{3}}) {
      const double there = pixels_of(masked_card(128, 128, 0.5F, kPatterns[k].there), "relief:capture=bind", height);
      EXPECT_NEAR(there / all, kPatterns[k].covers, 0.05) << kPatterns[k].name << " " << height << " pixels tall";
    }
  }
}

// A sheet in the middle of its box, seen aslant, lies where two steps of the search meet and is looked for in one of
// them.
TEST_F(MaskLevelsGl, ReliefsMeetASheetInTheMiddleOfItsBoxOnce) {
  constexpr float kTurned = 0.045F;  // of a full turn: 16 degrees
  for (const auto& [spec, height] : {std::pair<std::string, double>("relief:capture=bind", 40.0),
                                     {"relief:capture=bind", 12.0},
                                     {"relief:capture=bind,depth=8", 12.0},
                                     {"relief:capture=bind,search=cone", 12.0}}) {
    const double all = pixels_of(amid(masked_card(128, 128, 0.0F, kPatterns[0].there), 0.4F), spec, height, kTurned);
    const double there = pixels_of(amid(masked_card(128, 128, 0.5F, kPatterns[2].there), 0.4F), spec, height, kTurned);
    EXPECT_NEAR(there / all, kPatterns[2].covers, 0.05) << spec << ", " << height << " pixels tall";
  }
}

// Discs end where the mask ends. Cards without a mask have their own size. While how much discs reach over was judged
// by the places that reaches end at, what lies between those counted for nothing: stripes showed 0.57 in place of 0.5.
TEST_F(MaskLevelsGl, SurfelsCoverWhatThePatternLeaves) {
  const std::string spec = "surfel:points=4096";
  for (const double height : {120.0, 21.0, 3.0}) {
    const double all = pixels_of(masked_card(128, 128, 0.0F, kPatterns[0].there), "mesh", height);
    EXPECT_NEAR(pixels_of(masked_card(128, 128, 0.0F, kPatterns[0].there), spec, height) / all, 1, 0.02) << height;
    for (const Pattern& pattern : kPatterns) {
      const double there = pixels_of(masked_card(128, 128, 0.5F, pattern.there), spec, height);
      EXPECT_NEAR(there / all, pattern.covers, 0.04) << pattern.name << " " << height << " pixels tall";
    }
  }
}

struct Masked {
  const char* spec;
  double iou;  // with the mesh
};

class MaskGl : public GlTest, public ::testing::WithParamInterface<Masked> {};

// A third of the card is holes: a bake without them overlaps by two thirds.
TEST_P(MaskGl, SilhouetteHasTheHoles) {
  const scene::Cast cast = cast_of(card_with_holes(0.5F));
  const Capture mesh = draw(cast, "mesh");
  EXPECT_LT(overlap(mesh, draw(cast_of(card_with_holes(0.0F)), "mesh")), 0.72);
  EXPECT_GT(overlap(mesh, draw(cast, GetParam().spec)), GetParam().iou);
}

INSTANTIATE_TEST_SUITE_P(Bakes, MaskGl,
                         ::testing::Values(Masked{"rigid", 0.999}, Masked{"preskinned", 0.999}, Masked{"pseudo", 0.999},
                                           Masked{"posecache", 0.999}, Masked{"dynamic", 0.97}, Masked{"layered", 0.96},
                                           Masked{"perjoint", 0.97}, Masked{"flat", 0.97}, Masked{"polypostor", 0.97},
                                           Masked{"relief", 0.97}, Masked{"surfel", 0.9}),
                         [](const auto& test) { return std::string(test.param.spec); });

}  // namespace
}  // namespace crowdbench::renderers
