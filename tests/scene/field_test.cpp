// Files as people have them: what is not drawn, where travel is animated, which way a character faces, mirrored nodes,
// the height of the clip in use, one animation a channel, values that are off by rounding.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "scene/character/cut_out.h"
#include "scene/character/drawn.h"
#include "scene/crowd/crowd.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/body.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"
#include "scene/pose/pose_bank.h"
#include "scene/pose/stand.h"
#include "tests/scene/gltf_builder.h"
#include "tests/scene/posed_height.h"

namespace crowdbench::scene {
namespace {

using test::bending_card;
using test::Builder;
using test::load;
using test::posed_height;

bool warned(const Character& c, const std::string& of) {
  return std::ranges::any_of(c.warnings, [&](const std::string& w) { return w.find(of) != std::string::npos; });
}

nlohmann::json& primitive(Builder& b) { return b.doc["meshes"][0]["primitives"][0]; }
nlohmann::json& attributes(Builder& b) { return primitive(b)["attributes"]; }

// A channel of the first clip: "translation" or "rotation" of a node over one second.
void move(Builder& b, int animation, int node, const char* path, const std::vector<float>& times,
          const std::vector<float>& values) {
  const int input = b.accessor<float>(times, "SCALAR");
  const int output = b.accessor<float>(values, path == std::string("rotation") ? "VEC4" : "VEC3");
  auto& clip = b.doc["animations"][static_cast<size_t>(animation)];
  clip["samplers"].push_back({{"input", input}, {"output", output}});
  clip["channels"].push_back({{"sampler", clip["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

// The card with one clip "walk" of no channels yet.
Builder walking_card() {
  Builder b = bending_card();
  b.doc["animations"] = {
      {{"name", "walk"}, {"samplers", nlohmann::json::array()}, {"channels", nlohmann::json::array()}}};
  return b;
}

// --- what is not drawn has no say

TEST(Undrawn, AVertexThatNoIndexNamesCountsForNothing) {
  Builder b = bending_card();
  attributes(b)["POSITION"] = b.accessor<float>({0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0, 0, 20, 0}, "VEC3");
  attributes(b)["NORMAL"] = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  attributes(b)["TEXCOORD_0"] = b.accessor<float>({0, 1, 1, 1, 1, 0, 0, 0, 0, 0}, "VEC2");
  attributes(b)["JOINTS_0"] = b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  attributes(b)["WEIGHTS_0"] = b.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const Character c = load(b, LoadOptions{});
  EXPECT_NEAR(c.placement.scale, 1.75 / 2, 1e-9);
  EXPECT_EQ(c.mesh.positions.size(), 4U);
  EXPECT_EQ(c.file_vertices, 5U);
  LoadOptions all = test::as_is();
  all.undrawn = true;
  EXPECT_EQ(load(b, all).mesh.positions.size(), 5U);
}

TEST(Undrawn, CollapsedAndTransparentTrianglesCountForNothing) {
  for (const bool transparent : {false, true}) {
    Builder b = bending_card();
    nlohmann::json far = primitive(b);
    far["attributes"]["POSITION"] = transparent ? b.accessor<float>({0, 20, 0, 1, 20, 0, 1, 22, 0, 0, 22, 0}, "VEC3")
                                                : b.accessor<float>({0, 20, 0, 0, 20, 0, 0, 20, 0, 0, 20, 0}, "VEC3");
    if (transparent) {
      far["material"] = 1;
      b.doc["materials"].push_back(
          {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0}}}}});
    }
    b.doc["meshes"][0]["primitives"].push_back(far);
    const Character c = load(b, LoadOptions{});
    EXPECT_NEAR(c.placement.scale, 1.75 / 2, 1e-9) << transparent;
    EXPECT_EQ(c.triangles(), 2U) << transparent;
    EXPECT_EQ(c.file_triangles, 4U);
    EXPECT_TRUE(warned(c, "2 of 4 triangles cannot be seen"));
  }
}

// Hair and cloth share a picture with what is solid: a triangle over clear texels alone is not there, nor is one whose
// vertices are clear; one that reaches a solid texel is.
TEST(Undrawn, TrianglesOverClearTexelsCountForNothing) {
  constexpr int kSide = 8;
  Image8 image(kSide, kSide, 4);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      for (int c = 0; c < 4; ++c) image.at(x, y)[c] = c == 3 && x >= kSide / 2 ? 0 : 255;
  const std::vector<uint8_t> png = encode_png(image);
  struct Case {
    std::vector<float> uvs;
    float alpha;
    size_t triangles;
  };
  const std::vector<float> clear = {0.8F, 0.1F, 0.95F, 0.1F, 0.95F, 0.9F, 0.8F, 0.9F};
  const std::vector<float> solid = {0.1F, 0.1F, 0.95F, 0.1F, 0.95F, 0.9F, 0.1F, 0.9F};
  for (const Case& of : {Case{clear, 1, 2}, Case{solid, 1, 4}, Case{solid, 0.2F, 2}}) {
    Builder b = bending_card();
    b.doc["images"][0]["bufferView"] = b.view(png.data(), png.size());
    b.doc["materials"].push_back(
        {{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    nlohmann::json far = primitive(b);
    far["material"] = 1;
    far["attributes"]["POSITION"] = b.accessor<float>({0, 20, 0, 1, 20, 0, 1, 22, 0, 0, 22, 0}, "VEC3");
    far["attributes"]["TEXCOORD_0"] = b.accessor<float>(of.uvs, "VEC2");
    std::vector<float> colours;
    for (int i = 0; i < 4; ++i) colours.insert(colours.end(), {1, 1, 1, of.alpha});
    far["attributes"]["COLOR_0"] = b.accessor<float>(colours, "VEC4");
    b.doc["meshes"][0]["primitives"].push_back(far);
    const Character c = load(b, LoadOptions{});
    EXPECT_EQ(c.triangles(), of.triangles);
    EXPECT_NEAR(c.placement.scale, 1.75 / (of.triangles == 2 ? 2 : 22), 1e-9);
  }
}

TEST(Undrawn, ANodeScaledToNothingCountsForNothing) {
  Builder b = bending_card();
  b.doc["meshes"].push_back(b.doc["meshes"][0]);
  b.doc["nodes"].push_back({{"mesh", 1}, {"translation", {0, 30, 0}}, {"scale", {0, 0, 0}}});
  b.doc["scenes"][0]["nodes"].push_back(3);
  EXPECT_NEAR(load(b, LoadOptions{}).placement.scale, 1.75 / 2, 1e-9);
}

// A second card at a height of 30, which a scale channel of the clip shows or hides.
Builder card_with_a_flag(const std::vector<float>& times, const std::vector<float>& scales, float rest) {
  Builder b = walking_card();
  b.doc["meshes"].push_back(b.doc["meshes"][0]);
  b.doc["nodes"].push_back({{"mesh", 1}, {"translation", {0, 30, 0}}, {"scale", {rest, rest, rest}}});
  b.doc["scenes"][0]["nodes"].push_back(3);
  std::vector<float> values;
  for (const float scale : scales) values.insert(values.end(), {scale, scale, scale});
  move(b, 0, 3, "scale", times, values);
  return b;
}

TEST(Undrawn, WhatAClipScalesToNothingCountsForNothing) {
  for (const float scale : {0.0F, 1e-5F}) {
    Builder b = card_with_a_flag({0, 1}, {scale, scale}, 1);
    move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 1});
    const Character c = load(b, LoadOptions{});
    EXPECT_EQ(c.triangles(), 4U);  // the bind pose shows it
    EXPECT_NEAR(c.placement.scale, 1.75 / 2, 1e-6) << scale;
    EXPECT_NEAR(c.motion[0].ground_speed, 1.75 / 2, 1e-6) << scale;
    EXPECT_LT(PoseBank(c, {0}, 30).bounds_max().y, 1.76F) << scale;
  }
  EXPECT_NEAR(load(card_with_a_flag({0, 1}, {1, 1}, 1).glb(), LoadOptions{}).placement.scale, 1.75 / 32, 1e-6);
}

// A joint of its own stands still at the root while the body travels, and what it carries is not seen.
TEST(Undrawn, WhatIsHiddenDoesNotLengthenTheCycle) {
  for (const float alpha : {0.0F, 1.0F}) {
    Builder b = walking_card();
    move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 1});
    EXPECT_EQ(cycle_seconds(load(b, LoadOptions{}), 0), 1);
    b.doc["meshes"].push_back(b.doc["meshes"][0]);
    b.doc["meshes"][1]["primitives"][0]["material"] = 1;
    b.doc["materials"].push_back(
        {{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, alpha}}}}});
    b.doc["nodes"].push_back({{"mesh", 1}});
    b.doc["scenes"][0]["nodes"].push_back(3);
    const Character c = load(b, LoadOptions{});
    EXPECT_EQ(c.skeleton.joints.size(), 3U);
    if (alpha == 0)
      EXPECT_EQ(cycle_seconds(c, 0), 1) << "of the body alone";
    else
      EXPECT_GT(cycle_seconds(c, 0), 1) << "what stands there is left behind, and the loop is closed";
  }
}

TEST(Undrawn, WhatAClipShowsForAMomentIsDrawn) {
  Builder b = card_with_a_flag({0, 0.2F, 0.25F, 0.3F, 1}, {0, 0, 1, 0, 0}, 0);
  const Character c = load(b, LoadOptions{});
  EXPECT_EQ(c.triangles(), 4U);
  EXPECT_NEAR(c.placement.scale, 1.75 / 2, 1e-6);  // the clip's first pose does not show it
}

TEST(Undrawn, AVertexIsShownByTheTrianglesThatReachToIt) {
  Builder b = bending_card();
  const Character c = load(b);
  auto palette = joint_matrices(c, -1, 0);
  const auto hidden = [&] {
    const auto posed = skin_positions(c.mesh, palette);
    return hidden_vertices(c.mesh, stretches(palette), [&](uint32_t v) { return posed[v]; });
  };
  EXPECT_TRUE(hidden().empty());
  // Both upper corners fall on the joint: the triangle with one of them still reaches there, the other one does not.
  palette[1] = glm::dmat4(0.0);
  palette[1][3] = {0, 9, 0, 1};
  EXPECT_EQ(hidden(), std::vector<uint32_t>{3});
  EXPECT_EQ(shown_positions(c.mesh, palette)[3], glm::dvec3(0, 0, 0));
  EXPECT_EQ(shown_positions(c.mesh, palette)[2].y, 9);
  EXPECT_EQ(shown_heights(c.mesh, palette)[3], 0);
}

// What goes into a bake's key is to be the same by the shorter computation.
TEST(Undrawn, HeightsAreThoseOfThePositionsToTheLastBit) {
  const Character c = make_mannequin({.triangles = 500});
  for (int clip = -1; clip < static_cast<int>(c.clips.size()); ++clip)
    for (const double phase : {0.0, 0.37, 0.81}) {
      auto palette = model_matrices(c, clip, phase);
      for (const double scale : {1.0, 1e-6}) {
        palette[3] = palette[3] * glm::dmat4(glm::dmat3(scale));  // hides what it carries
        const std::vector<glm::dvec3> positions = shown_positions(c.mesh, palette);
        const std::vector<double> heights = shown_heights(c.mesh, palette);
        ASSERT_EQ(heights.size(), positions.size());
        for (size_t v = 0; v < heights.size(); ++v) ASSERT_EQ(heights[v], positions[v].y) << clip << " " << v;
      }
    }
}

TEST(Undrawn, SharedVerticesCountOnceAndAreLimitedByWhatIsNamed) {
  Builder b = bending_card();
  auto& primitives = b.doc["meshes"][0]["primitives"];
  nlohmann::json half = primitives[0];
  primitives[0]["indices"] = b.accessor<uint16_t>({0, 1, 2}, "SCALAR");
  half["indices"] = b.accessor<uint16_t>({0, 2, 3}, "SCALAR");
  primitives.push_back(half);
  LoadOptions options = test::as_is();
  options.limits.vertices = 6;  // 8 if every primitive had the whole buffer
  const Character c = load(b, options);
  EXPECT_EQ(c.file_vertices, 4U);
  EXPECT_EQ(c.mesh.positions.size(), 6U);
  EXPECT_EQ(c.mesh.primitives[1].first_vertex, 3U);
  options.limits.vertices = 5;
  EXPECT_THROW(load(b, options), Error);
}

// The card of 1 x 2 units with a masked picture of 64 x 64 texels; alpha: 0 to 1.
Builder masked_card(double cutoff, const std::function<double(int x, int y)>& alpha) {
  Image8 image(64, 64, 4);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 4; ++c)
        image.at(x, y)[c] = static_cast<uint8_t>(c == 3 ? std::lround(255 * alpha(x, y)) : 255);
  const std::vector<uint8_t> png = encode_png(image);
  Builder b = bending_card();
  b.doc["images"][0]["bufferView"] = b.view(png.data(), png.size());
  b.doc["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33071}}};
  b.doc["materials"][0]["alphaMode"] = "MASK";
  b.doc["materials"][0]["alphaCutoff"] = cutoff;
  b.doc.erase("animations");
  return b;
}

// A triangle reaches as far as its mask leaves it: the height and the ground are those of what is drawn, and so are the
// bounds by which cameras look.
TEST(Undrawn, WhatAMaskCutsOffATriangleCountsForNothing) {
  struct Case {
    const char* name;
    double cutoff;
    std::function<double(int, int)> alpha;
    double low, high;  // what is left, units
  };
  const Case cases[] = {
      {"upper half is clear", 0.5, [](int, int y) { return y >= 32 ? 1 : 0; }, 0, 1},
      {"lower quarter is clear", 0.5, [](int, int y) { return y < 48 ? 1 : 0; }, 0.5, 2},
      {"a disc", 0.5, [](int x, int y) { return std::hypot(x - 31.5, y - 31.5) < 16 ? 1 : 0; }, 0.5, 1.5},
      {"one strand", 0.5, [](int x, int y) { return x == 41 && y > 7 ? 1 : 0; }, 0, 1.75},
      {"a slope of alpha", 0.25, [](int, int y) { return y / 63.0; }, 0, 2 * (1 - (0.25 * 63 + 0.5) / 64)},
  };
  for (const Case& of : cases) {
    Builder b = masked_card(of.cutoff, of.alpha);
    const Character c = load(b, LoadOptions{});
    const double texel = 2.0 / 64;
    EXPECT_NEAR(1.75 / c.placement.scale, of.high - of.low, texel) << of.name;
    EXPECT_NEAR(-c.placement.model_from_gltf[3].y / c.placement.scale, of.low, texel) << of.name;
    const PoseBank bank = PoseBank::exact(c, -1, 0);
    EXPECT_NEAR(static_cast<double>(bank.bounds_min().y), 0, texel) << of.name;
    EXPECT_NEAR(static_cast<double>(bank.bounds_max().y), 1.75, texel * c.placement.scale) << of.name;
    DrawnExtent extent(c);
    const auto points = extent.outer_points(skin_positions(c.mesh, model_matrices(c, -1, 0)));
    const auto [lowest, highest] = std::ranges::minmax(points, {}, [](const glm::dvec3& p) { return p.y; });
    EXPECT_NEAR(lowest.y, 0, texel * c.placement.scale) << of.name;
    EXPECT_NEAR(highest.y, 1.75, texel * c.placement.scale) << of.name;
  }
}

// Where vertices' alpha runs from 1 at the lower edge to 0 at the upper, a mask at 0.4 ends at 0.6 of the height.
TEST(Undrawn, WhatVertexAlphaCutsOffCountsForNothing) {
  Builder b = masked_card(0.4, [](int, int) { return 1; });
  attributes(b)["COLOR_0"] = b.accessor<float>({1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1, 0}, "VEC4");
  EXPECT_NEAR(1.75 / load(b, LoadOptions{}).placement.scale, 1.2, 0.01);
}

// The middle of the body is that of what is drawn of it.
TEST(Undrawn, WhatAMaskCutsOffHasNoMass) {
  const Character c = load(masked_card(0.5, [](int x, int) { return x < 16 ? 1 : 0; }).glb(), LoadOptions{});
  EXPECT_NEAR(Body(c).centre(joint_matrices(c, -1, 0)).x, 0.125, 0.03);
}

// --- root motion is what the body does

void expect_travel(const Character& c, double x, double z) {
  EXPECT_NEAR(c.motion[0].ground_speed, std::hypot(x, z), 1e-6);
  EXPECT_NEAR(c.motion[0].direction.x * c.motion[0].ground_speed, x, 1e-6);
  EXPECT_NEAR(c.motion[0].direction.y * c.motion[0].ground_speed, z, 1e-6);
  EXPECT_FALSE(c.motion[0].from_stance);
  EXPECT_EQ(c.motion[0].closing_seconds, 0.0);
  const auto first = skin_positions(c.mesh, model_matrices(c, 0, 0.0));
  const auto last = skin_positions(c.mesh, model_matrices(c, 0, 1.0));
  for (size_t v = 0; v < first.size(); ++v) EXPECT_LT(glm::length(last[v] - first[v]), 1e-6);
}

TEST(RootMotion, BelowASkeletonThatStandsStill) {
  Builder b = walking_card();
  b.doc["nodes"].push_back({{"name", "armature"}, {"children", {0, 1}}});
  b.doc["scenes"][0]["nodes"] = {3};
  b.doc["skins"][0]["skeleton"] = 3;
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 1});
  expect_travel(load(b), 0, 1);
}

TEST(RootMotion, BelowARootJointThatStandsStill) {
  Builder b = walking_card();
  b.doc["nodes"].push_back({{"name", "root"}, {"children", {1}}});
  b.doc["scenes"][0]["nodes"] = {0, 3};
  b.doc["skins"][0] = {{"joints", {3, 1, 2}}};
  attributes(b)["JOINTS_0"] = b.accessor<uint8_t>({1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0}, "VEC4");
  b.doc["nodes"][2]["translation"] = {0, 0, 0};
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, -1.5F});
  expect_travel(load(b), 0, -1.5);
}

TEST(RootMotion, SplitOverSeveralNodesAndSideways) {
  Builder b = walking_card();
  b.doc["nodes"].push_back({{"name", "armature"}, {"children", {1}}});
  b.doc["scenes"][0]["nodes"] = {0, 3};
  move(b, 0, 3, "translation", {0, 1}, {0, 0, 0, -0.5F, 0, 0});
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, -0.5F, 0, 0.25F});
  expect_travel(load(b), -1, 0.25);
}

TEST(RootMotion, SplitOrWholeTheFigureStandsAtOnePlace) {
  const auto stands = [](float of_armature) {
    Builder b = walking_card();
    b.doc["nodes"].push_back({{"name", "armature"}, {"children", {0, 1}}});
    b.doc["scenes"][0]["nodes"] = {3};
    b.doc["skins"][0]["skeleton"] = 3;
    move(b, 0, 3, "translation", {0, 1}, {0, 0, 0, 0, 0, of_armature});
    move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 1.5F - of_armature});
    const Character c = load(b);
    EXPECT_NEAR(c.motion[0].ground_speed, 1.5, 1e-6);
    return glm::dvec3(c.placement.model_from_gltf[3]);
  };
  const glm::dvec3 whole = stands(1.5F);
  for (const float third : {0.5F, 1.0F}) EXPECT_LT(glm::length(stands(third) - whole), 1e-6) << third;
}

TEST(RootMotion, ATurnIsStrippedAndKeptAsARate) {
  // A quarter turn to the left in a second while the hips go round an arc of radius 2 about (2, 0).
  Builder b = walking_card();
  const auto h = static_cast<float>(std::sqrt(0.5));
  std::vector<float> times;
  std::vector<float> places;
  std::vector<float> turns;
  for (int i = 0; i <= 16; ++i) {
    const double angle = std::acos(-1.0) / 2 * i / 16;
    times.push_back(static_cast<float>(i) / 16);
    for (const double v : {2 - 2 * std::cos(angle), 0.0, 2 * std::sin(angle)}) places.push_back(static_cast<float>(v));
    for (const double v : {0.0, std::sin(angle / 2), 0.0, std::cos(angle / 2)}) turns.push_back(static_cast<float>(v));
  }
  EXPECT_NEAR(turns.back(), h, 1e-6);
  move(b, 0, 1, "translation", times, places);
  move(b, 0, 1, "rotation", times, turns);
  const Character c = load(b);
  EXPECT_NEAR(c.motion[0].yaw_rate, std::acos(-1.0) / 2, 1e-5);
  EXPECT_NEAR(c.motion[0].ground_speed, std::acos(-1.0), 1e-4);
  EXPECT_NEAR(c.motion[0].direction.y, 1.0, 1e-4);
  EXPECT_EQ(c.motion[0].closing_seconds, 0.0);
  // The whole of this clip is that motion: nothing is left of it in the pose.
  const auto first = skin_positions(c.mesh, model_matrices(c, 0, 0.0));
  for (const double phase : {0.25, 0.5, 1.0}) {
    const auto then = skin_positions(c.mesh, model_matrices(c, 0, phase));
    for (size_t v = 0; v < first.size(); ++v) EXPECT_LT(glm::length(then[v] - first[v]), 1e-3) << phase;
  }
}

TEST(RootMotion, StairsAreClimbedWhileTheFigureGoesForwards) {
  for (const float rise : {0.8F, -0.8F}) {
    Builder b = walking_card();
    move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, rise, 1.5F});
    const Character c = load(b);
    EXPECT_NEAR(c.motion[0].ground_speed, 1.5, 1e-6);
    EXPECT_EQ(c.motion[0].direction, glm::dvec2(0, 1));
    EXPECT_NEAR(c.motion[0].root_displacement.y, static_cast<double>(rise), 1e-6);
    EXPECT_FALSE(c.motion[0].from_stance);
    const auto first = skin_positions(c.mesh, model_matrices(c, 0, 0.0));
    const auto then = skin_positions(c.mesh, model_matrices(c, 0, 0.5));
    for (size_t v = 0; v < first.size(); ++v) EXPECT_LT(glm::length(then[v] - first[v]), 1e-6);
  }
  Builder jump = walking_card();
  move(jump, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 2, 1});
  EXPECT_EQ(load(jump).motion[0].root_displacement, glm::dvec3(0.0));
}

TEST(RootMotion, AFallIsNoTravel) {
  // The card tips over about its lower edge: its mass moves by 1, but it does not end as it began.
  Builder b = walking_card();
  const auto h = static_cast<float>(std::sqrt(0.5));
  move(b, 0, 1, "rotation", {0, 1}, {0, 0, 0, 1, h, 0, 0, h});
  EXPECT_EQ(load(b).motion[0].root_displacement, glm::dvec3(0.0));
}

// A body of one metre and a foot below it, which go 0.5 and `foot` metres along Z in a second. The foot has a twentieth
// of the mass.
Character over_a_foot(float foot) {
  Builder b = walking_card();
  const int positions =
      b.accessor<float>({-0.3F, 0.5F, 0, 0.3F, 0.5F, 0, 0, 1.8F, 0, -0.2F, 0, 0, 0.2F, 0, 0, 0, 0.1F, 0}, "VEC3");
  attributes(b) = {{"POSITION", positions}};
  attributes(b)["JOINTS_0"] =
      b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  attributes(b)["WEIGHTS_0"] =
      b.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  primitive(b)["indices"] = b.accessor<uint16_t>({0, 1, 2, 3, 4, 5}, "SCALAR");
  primitive(b).erase("material");
  b.doc["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "body"}}, {{"name", "foot"}}};
  b.doc["skins"] = {{{"joints", {1, 2}}}};
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 0.5F});
  move(b, 0, 2, "translation", {0, 1}, {0, 0, 0, 0, 0, foot});
  return load(b);
}

// Nearly all of the figure goes 0.5 m and ends as it began; whether it travels is for its feet to say.
TEST(RootMotion, WhoTravelsTakesTheFeetAlong) {
  EXPECT_EQ(over_a_foot(0).motion[0].root_displacement, glm::dvec3(0.0)) << "leans over";
  EXPECT_EQ(over_a_foot(0.1F).motion[0].root_displacement, glm::dvec3(0.0));
  for (const float foot : {0.2F, 0.5F})
    EXPECT_NEAR(over_a_foot(foot).motion[0].root_displacement.z, 0.951 * 0.5 + 0.049 * foot, 0.001) << foot;
}

// --- agents go where their clip goes, and their feet stay where they are set down

// A walker whose left foot (x < 0) stands on the ground for the first half of the cycle and the right one for the
// second, while the body goes by `travel` (x, z) in one second; `in_place`: the same on a treadmill.
// toes: how far they reach along Z.
Character walker(glm::dvec2 travel, bool in_place, float toes = 0) {
  Builder b = walking_card();
  // Two cards: joint 0 "hips" holds the left, joint 1 "arm" the right.
  attributes(b)["POSITION"] =
      b.accessor<float>({-0.3F, 0, 0, -0.1F, 0, 0, -0.2F, 1.8F, 0, 0.1F, 0, 0, 0.3F, 0, 0, 0.2F, 1.8F, 0}, "VEC3");
  attributes(b) = {{"POSITION", attributes(b)["POSITION"]}};
  attributes(b)["JOINTS_0"] =
      b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  attributes(b)["WEIGHTS_0"] =
      b.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  primitive(b)["indices"] = b.accessor<uint16_t>({0, 1, 2, 3, 4, 5}, "SCALAR");
  if (toes != 0) {
    nlohmann::json feet = primitive(b);
    feet["attributes"]["POSITION"] =
        b.accessor<float>({-0.3F, 0, 0, -0.1F, 0, 0, -0.2F, 0, toes, 0.1F, 0, 0, 0.3F, 0, 0, 0.2F, 0, toes}, "VEC3");
    b.doc["meshes"][0]["primitives"].push_back(feet);
  }
  primitive(b).erase("material");
  b.doc["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "left"}}, {{"name", "right"}}};
  b.doc["skins"] = {{{"joints", {1, 2}}}};
  b.doc["scenes"][0]["nodes"] = {0, 1, 2};
  const auto x = static_cast<float>(travel.x);
  const auto z = static_cast<float>(travel.y);
  const float s = in_place ? 1.0F : 0.0F;  // what a treadmill takes back by each time
  const auto at = [&](float gone, float time, float lift) {
    return std::vector<float>{x * (gone - s * time), lift, z * (gone - s * time)};
  };
  const auto keys = [&](std::initializer_list<std::vector<float>> all) {
    std::vector<float> out;
    for (const auto& k : all) out.insert(out.end(), k.begin(), k.end());
    return out;
  };
  move(b, 0, 1, "translation", {0, 0.5F, 0.75F, 1},
       keys({at(0, 0, 0), at(0, 0.5F, 0), at(0.5F, 0.75F, 0.2F), at(1, 1, 0)}));
  move(b, 0, 2, "translation", {0, 0.25F, 0.5F, 1},
       keys({at(-0.5F, 0, 0), at(0, 0.25F, 0.2F), at(0.5F, 0.5F, 0), at(0.5F, 1, 0)}));
  return load(b, LoadOptions{});
}

struct Foot {
  double slid = 0;  // metres over the ground while it stands, over a second
  glm::dvec2 gone{0.0};
};

// How far the standing feet of the only agent slide in two cycles; belt: the ground's own speed.
double worst_slide(const Character& character, MotionKind motion, std::optional<double> heading) {
  Cast cast;
  cast.characters = {std::make_shared<const Character>(character)};
  cast.banks = {std::make_shared<const PoseBank>(character, std::vector<int>{0}, 60.0)};
  cast.shares = {1.0};
  Scenario scenario;
  scenario.crowd.agents = 1;
  scenario.crowd.motion = motion;
  scenario.crowd.heading_deg = heading;
  scenario.crowd.scale_variation = 0;
  scenario.crowd.speed_variation = 0;
  scenario.tick_rate = 60;
  const Crowd crowd = make_crowd(scenario, cast, stage_view(scenario));
  const BankClip& clip = cast.banks[0]->clips()[0];
  std::vector<std::vector<glm::dvec3>> feet;  // by tick and vertex, world axes
  for (uint64_t tick = 0; tick < 60; ++tick) {
    const Frame frame = make_frame(scenario, cast, crowd, scenario.camera.at(0), tick, false);
    const FrameAgent& agent = frame.agents[0][0];
    const auto palette = cast.banks[0]->palette(agent.pose);
    glm::dvec2 belt(0.0);
    if (motion == MotionKind::treadmill) {
      const double s = crowd.heading_sin[0];
      const double c = crowd.heading_cos[0];
      const glm::dvec2 way(clip.direction.x * c + clip.direction.y * s, clip.direction.y * c - clip.direction.x * s);
      belt = way * clip.ground_speed * (static_cast<double>(tick) / 60);
    }
    std::vector<glm::dvec3>& points = feet.emplace_back();
    for (const size_t v : {size_t{0}, size_t{3}}) {
      const Mat3x4& m = palette[character.mesh.joints[v][0]];
      const glm::vec4 p(character.mesh.positions[v], 1.0F);
      const glm::dvec3 local(glm::dot(m.rows[0], p), glm::dot(m.rows[1], p), glm::dot(m.rows[2], p));
      const double s = agent.heading.x;
      const double c = agent.heading.y;
      points.push_back(glm::dvec3(agent.position) + frame.origin +
                       glm::dvec3(local.x * c + local.z * s + belt.x, local.y, local.z * c - local.x * s + belt.y));
    }
  }
  double worst = 0;
  for (size_t t = 0; t + 1 < feet.size(); ++t)
    for (size_t v = 0; v < 2; ++v) {
      const glm::dvec3 d = feet[t + 1][v] - feet[t][v];
      if (feet[t][v].y > 1e-3 || feet[t + 1][v].y > 1e-3 || std::hypot(d.x, d.z) > 1) continue;  // wraps
      worst = std::max(worst, std::hypot(d.x, d.z) * 60);
    }
  return worst;
}

TEST(Feet, StayWhereTheyStandForwardsSidewaysAndBackward) {
  for (const bool in_place : {false, true})
    for (const glm::dvec2& travel :
         {glm::dvec2(0, 1.2), glm::dvec2(1.2, 0), glm::dvec2(-0.8, 0), glm::dvec2(0, -0.9), glm::dvec2(0.7, 0.7)}) {
      const Character c = walker(travel, in_place);
      SCOPED_TRACE(fmt::format("{} {} {}", travel.x, travel.y, in_place));
      EXPECT_NEAR(c.motion[0].ground_speed, glm::length(travel) * c.placement.scale, 0.02);
      EXPECT_EQ(c.motion[0].from_stance, in_place);
      for (const MotionKind motion : {MotionKind::treadmill, MotionKind::lanes, MotionKind::free})
        for (const std::optional<double>& heading : {std::optional<double>(90), std::optional<double>(30)})
          EXPECT_LT(worst_slide(c, motion, heading), 0.02 * glm::length(travel)) << static_cast<int>(motion);
    }
}

// A turn of one joint alone, as files with one animation a channel have it: once, and to and fro.
TEST(Feet, OneJointThatTurnsAloneDoesNotWalk) {
  const float s = 0.2F;
  const auto c = static_cast<float>(std::sqrt(1 - 0.04));
  struct Case {
    std::vector<float> times, turns;
  };
  for (const Case& of : {Case{{0, 1}, {0, 0, 0, 1, 0, 0, s, c}}, Case{{0, 1}, {0, 0, 0, 1, s, 0, 0, c}},
                         Case{{0, 0.5F, 1}, {0, 0, 0, 1, s, 0, 0, c, 0, 0, 0, 1}},
                         Case{{0, 0.7F, 1}, {0, 0, -s, c, 0, 0, s, c, 0, 0, -s, c}}}) {
    Builder b = walking_card();
    attributes(b)["POSITION"] = b.accessor<float>({-0.25F, 0, 0.1F, 0.25F, 0, 0.1F, 0.25F, 1, 0, -0.25F, 1, 0}, "VEC3");
    attributes(b)["JOINTS_0"] = b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
    move(b, 0, 1, "rotation", of.times, of.turns);
    const Character card = load(b);
    EXPECT_EQ(card.motion[0].ground_speed, 0) << of.turns[3] << " " << of.turns.size();
    EXPECT_EQ(card.motion[0].root_displacement, glm::dvec3(0.0));
  }
}

TEST(Feet, AnAgentFacesItsHeadingAndGoesWhereTheClipGoes) {
  Cast cast;
  cast.characters = {std::make_shared<const Character>(walker({0, -1}, false))};
  cast.banks = {std::make_shared<const PoseBank>(*cast.characters[0], std::vector<int>{0})};
  cast.shares = {1.0};
  Scenario scenario;
  scenario.crowd.agents = 1;
  scenario.crowd.motion = MotionKind::free;
  scenario.crowd.heading_deg = 90;
  scenario.crowd.speed_variation = 0;
  scenario.crowd.scale_variation = 0;
  const Crowd crowd = make_crowd(scenario, cast, stage_view(scenario));
  const Frame before = make_frame(scenario, cast, crowd, scenario.camera.at(0), 0, false);
  const Frame after = make_frame(scenario, cast, crowd, scenario.camera.at(0), 6, false);
  EXPECT_NEAR(after.agents[0][0].heading.x, 1.0, 1e-6);
  EXPECT_LT(after.agents[0][0].position.x - before.agents[0][0].position.x, -0.1);  // backward
}

// --- which way it faces

TEST(Facing, TurnDegAndUpTurnTheCharacter) {
  Builder b = bending_card();
  LoadOptions options;
  options.normalise.turn_deg = 90;
  const Character c = load(b, options);
  const auto drawn = skin_positions(c.mesh, model_matrices(c, -1, 0));
  EXPECT_NEAR(drawn[1].z - drawn[0].z, -0.875, 1e-6);  // +X goes to -Z
  EXPECT_NEAR(skin_normals(c.mesh, model_matrices(c, -1, 0))[0].x, 1.0, 1e-6);

  Builder lying = bending_card();
  lying.doc["nodes"].push_back({{"children", {0, 1}}, {"rotation", {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}});  // y to z
  lying.doc["scenes"][0]["nodes"] = {3};
  LoadOptions up;
  up.normalise.up = UpAxis::z;
  const Character z = load(lying, up);
  EXPECT_NEAR(z.placement.scale, 0.875, 1e-6);
  EXPECT_NEAR(skin_positions(z.mesh, model_matrices(z, -1, 0))[2].y, 1.75, 1e-6);
}

TEST(Facing, WhoLiesIsToldOfTheUpAxis) {
  const auto told = [](std::vector<double> head, UpAxis up) {
    Builder b = bending_card();
    b.doc["nodes"][1]["name"] = "hips";
    b.doc["nodes"][1]["children"] = {2, 3, 4, 5};
    b.doc["nodes"].push_back({{"name", "head"}, {"translation", head}});
    b.doc["nodes"].push_back({{"name", "foot_l"}, {"translation", {0.1, 0, 0}}});
    b.doc["nodes"].push_back({{"name", "foot_r"}, {"translation", {-0.1, 0, 0}}});
    b.doc["skins"][0]["joints"] = {1, 2, 3, 4, 5};
    b.doc["skins"][0].erase("inverseBindMatrices");
    LoadOptions options;
    options.normalise.up = up;
    return warned(load(b, options), "--up-axis z");
  };
  EXPECT_TRUE(told({0, 0.2, 1.6}, UpAxis::y));
  EXPECT_FALSE(told({0, 1.6, 0.2}, UpAxis::y)) << "stands";
  EXPECT_FALSE(told({0, 0.2, -1.6}, UpAxis::y)) << "up = z would stand it on its head";
  EXPECT_FALSE(told({0, 0.2, 1.6}, UpAxis::z)) << "said already";
}

TEST(Facing, AWalkAlongMinusZThatTheToesPointToIsTurned) {
  const Character turned = walker({0, -1}, false, -0.3F);
  EXPECT_NEAR(turned.motion[0].direction.y, 1.0, 1e-6);
  EXPECT_TRUE(warned(turned, "turned by 180 degrees"));
  const Character backward = walker({0, -1}, false, 0.3F);
  EXPECT_NEAR(backward.motion[0].direction.y, -1.0, 1e-6);
  EXPECT_FALSE(warned(backward, "turn_deg"));
  EXPECT_TRUE(warned(walker({0, -1}, false), "turn_deg = 180"));
}

// VRM 0.x files have no clips of their own, or clips on the spot, and face -Z; what is no VRM file is left as it is.
TEST(Facing, AVrmFileThatGoesNowhereIsTurnedToWhereItsToesPoint) {
  for (const float toes : {-0.5F, 0.5F}) {
    Builder b = bending_card();
    attributes(b)["POSITION"] = b.accessor<float>({0, 0, 0, 1, 0, 0, 0.5F, 0, toes, 0.5F, 2, 0}, "VEC3");
    primitive(b)["indices"] = b.accessor<uint16_t>({0, 1, 2, 0, 1, 3}, "SCALAR");
    EXPECT_FALSE(warned(load(b), "turned by 180 degrees"));
    b.doc["extensions"]["VRM"]["humanoid"]["humanBones"] = {{{"bone", "hips"}, {"node", 1}}};
    for (const bool with_clip : {true, false}) {
      if (!with_clip) b.doc.erase("animations");
      const Character c = load(b);
      EXPECT_EQ(warned(c, "no clip goes anywhere, and feet and face point to -Z"), toes < 0) << toes;
      EXPECT_GT(skin_positions(c.mesh, model_matrices(c, -1, 0))[2].z, 0.1) << "toes point to +Z";
      LoadOptions as_it_is;
      as_it_is.normalise.turn_deg = 0;
      EXPECT_FALSE(warned(load(b, as_it_is), "turned by 180 degrees"));
    }
  }
}

TEST(Facing, AnyWalkTellsItNotTheDefaultClipAlone) {
  Builder b = walking_card();
  b.doc["animations"][0]["name"] = "walk_strafe";
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  b.doc["animations"].push_back({{"name", "walk"}});
  move(b, 1, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, -1});
  EXPECT_TRUE(warned(load(b), "clip 1 'walk' travels along -Z"));
  b.doc["animations"][1]["name"] = "walk_back";
  EXPECT_FALSE(warned(load(b), "travels along -Z"));
}

// --- mirrored nodes

TEST(Mirrored, ASkinnedMeshBelowAMirroringNodeTurnsItsWinding) {
  for (const std::vector<double>& scale : {std::vector<double>{-1, 1, 1}, {1, 1, -1}, {-1, -1, 1}}) {
    Builder b = bending_card();
    b.doc["nodes"].push_back({{"children", {0, 1}}, {"scale", scale}});
    b.doc["scenes"][0]["nodes"] = {3};
    EXPECT_EQ(load(b).mesh.primitives[0].mirrored, scale[0] * scale[1] * scale[2] < 0);
  }
}

// --- height is that of the clips in use

TEST(Height, IsThatOfTheClipInUse) {
  // "Crouch_Walk" comes first and folds the upper half down; "Walk" stands.
  Builder b = walking_card();
  b.doc["animations"][0]["name"] = "Crouch_Walk";
  move(b, 0, 2, "translation", {0, 1}, {0, 0.2F, 0, 0, 0.2F, 0});
  b.doc["animations"].push_back({{"name", "Walk"}});
  move(b, 1, 2, "translation", {0, 1}, {0, 1, 0, 0, 1, 0});
  const Character plain = load(b, LoadOptions{});
  EXPECT_EQ(plain.placement.default_clip, 0);
  EXPECT_NEAR(posed_height(plain, 0), 1.75, 1e-6);
  LoadOptions options;
  options.normalise.clips = {"Walk"};
  const Character walk = load(b, options);
  EXPECT_EQ(walk.placement.upright_clip, 1);
  EXPECT_NEAR(posed_height(walk, 1), 1.75, 1e-6);
  options.normalise.clips = {"Crouch_Walk", "Walk"};
  EXPECT_EQ(load(b, options).placement.upright_clip, 1);
  options.normalise.clips = {"run"};  // whoever plays it is to blame, not the file
  EXPECT_EQ(load(b, options).placement.upright_clip, 0);
}

// Who sits on the floor with a blade in hand that reaches below it is drawn as tall as standing, and does not stand.
TEST(Height, OfWhoSitsIsThatOfTheClipThatStands) {
  Builder b = walking_card();
  const int positions = b.accessor<float>({-0.2F, -0.9F, 0, 0.2F, -0.9F, 0, 0.2F, 0,    0, -0.2F, 0,    0,  // legs
                                           -0.2F, 0.9F,  0, 0.2F, 0.9F,  0, 0.2F, 1.8F, 0, -0.2F, 1.8F, 0,  // trunk
                                           0.5F,  0,     0, 0.6F, 0,     0, 0.6F, 1,    0},                 // blade
                                          "VEC3");
  attributes(b) = {{"POSITION", positions}};
  std::vector<uint8_t> joints;
  std::vector<float> weights;
  for (int v = 0; v < 11; ++v) {
    joints.insert(joints.end(), {static_cast<uint8_t>(v < 8 ? v / 4 : 3), 0, 0, 0});
    weights.insert(weights.end(), {1, 0, 0, 0});
  }
  attributes(b)["JOINTS_0"] = b.accessor<uint8_t>(joints, "VEC4");
  attributes(b)["WEIGHTS_0"] = b.accessor<float>(weights, "VEC4");
  primitive(b)["indices"] = b.accessor<uint16_t>({0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 8, 9, 10}, "SCALAR");
  primitive(b).erase("material");
  b.doc["nodes"] = {{{"mesh", 0}, {"skin", 0}},
                    {{"name", "legs"}, {"translation", {0, 0.9, 0}}},
                    {{"name", "hips"}, {"children", {1, 3}}},
                    {{"name", "hand_l"}, {"children", {4}}},
                    {{"name", "blade"}}};
  b.doc["skins"] = {{{"joints", {1, 2, 3, 4}}}};
  b.doc["scenes"][0]["nodes"] = {0, 2};
  move(b, 0, 1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 1});
  b.doc["animations"].push_back(
      {{"name", "sit"}, {"samplers", nlohmann::json::array()}, {"channels", nlohmann::json::array()}});
  const auto h = static_cast<float>(std::sqrt(0.5));
  move(b, 1, 1, "rotation", {0, 1}, {h, 0, 0, h, h, 0, 0, h});
  LoadOptions options;
  options.normalise.clips = {"sit"};
  const Character c = load(b, options);
  EXPECT_NEAR(posed_height(c, 1), posed_height(c, 0), 1e-6) << "the blade fills the place of the legs";
  EXPECT_EQ(c.placement.upright_clip, 0);
}

// --- the ground

// Soles that stand at 0 for most of a cycle of 30 poses: a dip of a few poses does not lift the figure off the ground.
TEST(Ground, IsWhereTheFigureStays) {
  std::vector<double> lowest(30, 0.0);
  for (size_t i = 10; i < 16; ++i) lowest[i] = 0.1;  // a leap
  EXPECT_EQ(supporting_height(lowest, 2), 0.0);
  lowest[20] = -0.05;
  lowest[21] = -0.12;
  lowest[22] = -0.05;
  EXPECT_EQ(supporting_height(lowest, 2), 0.0);
  lowest[3] = -0.015;  // within a hundredth of the height: soles roll
  EXPECT_EQ(supporting_height(lowest, 2), -0.015);
  for (size_t i = 0; i < 30; ++i) lowest[i] = static_cast<double>(i);
  EXPECT_EQ(supporting_height(lowest, 2), 0.0) << "never stays";
  EXPECT_EQ(supporting_height({1.5}, 2), 1.5);
}

// A blade on a node of the hand is below the soles in every pose, a toe in one: the feet stand all the same.
TEST(Ground, WhatIsHeldHasNoSay) {
  Builder b = walking_card();
  b.doc["animations"][0]["name"] = "idle";
  move(b, 0, 2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 1});
  b.doc["nodes"][1]["name"] = "hips";
  b.doc["nodes"][2]["name"] = "hand_l";
  b.doc["nodes"][2]["children"] = {3};
  b.doc["nodes"].push_back({{"name", "blade"}, {"translation", {0, -1, 0}}});
  b.doc["skins"][0]["joints"] = {1, 2, 3};
  b.doc["skins"][0].erase("inverseBindMatrices");
  nlohmann::json blade = primitive(b);
  blade["attributes"]["POSITION"] = b.accessor<float>({0, -1, 0, 0.1F, -1, 0, 0.1F, 1, 0, 0, 1, 0}, "VEC3");
  blade["attributes"]["JOINTS_0"] = b.accessor<uint8_t>({2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0}, "VEC4");
  attributes(b)["JOINTS_0"] = b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  b.doc["meshes"][0]["primitives"].push_back(blade);
  const Character c = load(b, LoadOptions{});
  EXPECT_NEAR(c.placement.model_from_gltf[3].y, 0, 1e-6);
  b.doc["nodes"][2]["name"] = "tail";
  EXPECT_NEAR(load(b, LoadOptions{}).placement.model_from_gltf[3].y / c.placement.scale, 1, 1e-6);
}

// --- clips

TEST(Together, OneAnimationAChannelPlaysAtOnce) {
  Builder b = walking_card();
  b.doc["animations"][0].erase("name");
  move(b, 0, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 2});
  b.doc["animations"].push_back(nlohmann::json::object());
  move(b, 1, 2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 1, 0});
  const Character c = load(b);
  ASSERT_EQ(c.clips.size(), 3U);
  EXPECT_EQ(c.clips[2].name, "together");
  EXPECT_EQ(c.clips[2].channels.size(), 2U);
  EXPECT_EQ(c.placement.default_clip, 2);
  EXPECT_TRUE(warned(c, "plays them at once"));
  // Two that move the same are alternatives, and so are clips of other lengths.
  move(b, 1, 1, "translation", {0, 1}, {0, 0, 0, 0, 0, 1});
  EXPECT_EQ(load(b).clips.size(), 2U);
}

TEST(Strictness, KeysBeforeZeroAreShifted) {
  Builder b = walking_card();
  move(b, 0, 1, "translation", {-0.5F, 0.5F}, {0, 0, 0, 0, 0, 2});
  move(b, 0, 2, "translation", {0, 0.5F}, {0, 1, 0, 0, 1.5F, 0});
  const Character c = load(b);
  EXPECT_EQ(c.clips[0].start, 0.0);
  EXPECT_EQ(c.clips[0].end, 1.0);
  EXPECT_EQ(c.clips[0].channels[1].times.front(), 0.5);
  EXPECT_TRUE(warned(c, "begins at -0.5 s, before 0"));
}

// Of keys at one time the last counts from then on; until then the curve goes to the first.
TEST(Strictness, KeysAtOneTimeMakeTheCurveJump) {
  Builder b = walking_card();
  move(b, 0, 2, "translation", {0, 0.5F, 0.5F, 0.5F, 1, 1}, {0, 1, 0, 0, 2, 0, 0, 9, 0, 0, 4, 0, 0, 5, 0, 0, 6, 0});
  const Character c = load(b);
  EXPECT_TRUE(warned(c, "keys 1 and 2 are both at 0.5 s"));
  const auto at = [&](double time) { return node_matrices(c, 0, time)[2][3].y; };
  EXPECT_NEAR(at(0.25), 1.5, 1e-3);
  EXPECT_NEAR(at(0.4999), 2, 1e-3);
  EXPECT_EQ(at(0.5), 4);
  EXPECT_NEAR(at(0.75), 4.5, 1e-3);
  EXPECT_EQ(at(1), 6);
  EXPECT_EQ(c.clips[0].end, 1.0);
}

TEST(Strictness, APrimitiveThatRepeatsAnotherIsDrawnOnce) {
  Builder b = bending_card();
  b.doc["meshes"][0]["primitives"].push_back(primitive(b));
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U);
  EXPECT_EQ(c.file_triangles, 4U);
  EXPECT_EQ(count_vertices(c.mesh), 4U);
  EXPECT_EQ(c.file_vertices, 4U);
  EXPECT_TRUE(warned(c, "is drawn once"));
  // In another material it is drawn, and its vertices are shared.
  b.doc["materials"].push_back({{"doubleSided", true}});
  b.doc["meshes"][0]["primitives"][1]["material"] = 1;
  const Character two = load(b);
  EXPECT_EQ(two.triangles(), 4U);
  EXPECT_EQ(two.mesh.positions.size(), 8U);
  EXPECT_EQ(count_vertices(two.mesh), 4U);
}

TEST(Strictness, AMatrixThatIsOffByRoundingIsSnapped) {
  Builder b = bending_card();
  b.doc["nodes"].push_back(
      {{"children", {0, 1}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 1e-7, 0, 0, 1, 0, 0, 0, 0, 0.9999999}}});
  b.doc["scenes"][0]["nodes"] = {3};
  const Character c = load(b);
  EXPECT_EQ(c.skeleton.nodes[0].matrix, glm::dmat4(1.0));
  EXPECT_TRUE(warned(c, "is snapped"));
  b.doc["nodes"][3]["matrix"][15] = 0.9;
  try {
    load(b);
    FAIL();
  } catch (const Error& error) {
    EXPECT_FALSE(error.advice.empty());
  }
}

}  // namespace
}  // namespace crowdbench::scene
