// The truth and the mesh hold each other: the shading formula in two languages, outlines within the bound that is
// derived from how a rasteriser rounds.
#include "truth/truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gl_test_support.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/sanitized.h"
#include "truth/judge.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

class TruthGl : public GlTest {
 protected:
  static Capture drawn(const scene::Cast& cast, const scene::Frame& frame) {
    const auto representation = testing::make(cast, reference_spec().text());
    return Renderer(context(), cast).capture(frame, *representation, {.linear = true});
  }
  static truth::Judgement judged(const scene::Cast& cast, const scene::Frame& frame, const Capture& capture) {
    return truth::judge(cast, frame, truth::cast_truth(cast, frame), {capture.ids, capture.depth, capture.colour});
  }
};

// Twelve walkers that overlap, over the grid.
scene::Frame crowd_of_walkers(const scene::Cast& cast, int width, int height) {
  scene::Frame frame = frame_of_one(6.0, 1.7, width, height, 45.0);
  frame.camera.target.y = 0.8;
  frame.ground = true;
  for (uint32_t i = 0; i < 12; ++i)
    add_agent(frame, cast, {0.45 * (i % 4) - 0.7, 0, 1.2 * (i / 4) - 1.9}, i + 1, 0.083 * i,
              0.13F * static_cast<float>(i), 0.9F + 0.02F * static_cast<float>(i));
  return frame;
}

TEST_F(TruthGl, TheMeshIsWrongOnlyAlongOutlines) {
  const scene::Cast& cast = testing::walker();
  const scene::Frame frame = crowd_of_walkers(cast, 320, 240);
  const Capture mesh = drawn(cast, frame);
  const truth::Judgement judgement = judged(cast, frame, mesh);
  EXPECT_GT(judgement.covered, 5'000U);
  EXPECT_EQ(judgement.unexplained, 0U) << judgement.wrong << " wrong";
  EXPECT_EQ(judgement.wrong, judgement.outline + judgement.depth + judgement.mask);
  EXPECT_LT(judgement.largest_bound, 0.02) << "pixels";
  // An outline passes so near to a pixel's centre once in many pixels.
  EXPECT_LT(judgement.wrong, judgement.covered / 100);
  EXPECT_GT(judgement.inner, judgement.covered / 2);
  EXPECT_LT(judgement.worst_depth, 1e-5);
  // Textures of figures as small as these have the levels that the driver chooses: llvmpipe's are approximate.
  EXPECT_LT(judgement.mean_colour, 1.5);
  // Without them what is left are normals of 10 bits a component and the rounding to 8 bits.
  scene::Character bare = *cast.characters.front();
  for (scene::Material& material : bare.materials) material.base_colour_image = -1;
  const scene::Cast plain = cast_of(bare);
  const scene::Frame plain_frame = crowd_of_walkers(plain, 160, 120);
  EXPECT_LT(judged(plain, plain_frame, drawn(plain, plain_frame)).mean_colour, 0.35);
}

// What is shown to fail: the crowd a fiftieth of a pixel to the side, one agent not drawn, and the wrong one drawn.
TEST_F(TruthGl, TheJudgeFindsWhatIsWrong) {
  const scene::Cast& cast = testing::walker();
  const scene::Frame frame = crowd_of_walkers(cast, 200, 150);
  const truth::TruthPicture truth = truth::cast_truth(cast, frame);
  const auto judged_as = [&](const scene::Frame& other) {
    const Capture mesh = drawn(cast, other);
    return truth::judge(cast, frame, truth, {mesh.ids, mesh.depth, mesh.colour});
  };
  ASSERT_EQ(judged_as(frame).unexplained, 0U);
  scene::Frame fewer = frame;
  fewer.agents[0].pop_back();
  const truth::Judgement missing = judged_as(fewer);
  EXPECT_GT(missing.unexplained, 100U);
  ASSERT_EQ(missing.offenders.size(), 64U);
  EXPECT_EQ(missing.offenders[0].truth_id, 12U);
  scene::Frame beside = frame;
  for (scene::FrameAgent& agent : beside.agents[0]) agent.position.x += 0.01F;  // a third of a pixel
  EXPECT_GT(judged_as(beside).unexplained, 20U);
}

// One card that fills the picture, lit at an angle: the two formulas agree to what 8 bits and 10-bit normals leave.
TEST_F(TruthGl, ShadingIsTheSameFormula) {
  for (const int kind : {0, 1, 2, 3}) {
    scene::Character character = card(4, 4, glm::vec4(0.8F, 0.4F, 0.2F, 1.0F));
    scene::Material& material = character.materials.front();
    material.emissive = {0.02F, 0.1F, 0.05F};
    material.unlit = kind == 1;
    for (glm::vec3& normal : character.mesh.normals) normal = glm::normalize(glm::vec3(0.3F, -0.2F, 0.9F));
    if (kind == 2)  // colours from corner to corner
      for (const glm::vec3& p : character.mesh.positions)
        character.mesh.colours.emplace_back(0.5F + 0.1F * p.x, 0.2F * p.y, 0.7F, 1.0F);
    if (kind == 3)  // its posed faces' own normal
      for (scene::Primitive& primitive : character.mesh.primitives) primitive.flat = true;
    const scene::Cast cast = cast_of(character);
    scene::Frame frame = frame_of_one(3, 2, 60, 40);
    frame.outfits.front().colours[material.slot] = {0.5F, 0.9F, 1.0F, 1.0F};
    add_agent(frame, cast, {0, 0, 0}, 3, 0, 0.04F);
    const Capture mesh = drawn(cast, frame);
    const truth::TruthPicture truth = truth::cast_truth(cast, frame);
    ASSERT_EQ(mesh.ids, truth.ids) << kind;
    double worst = 0;
    for (size_t i = 0; i < mesh.linear.data.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(mesh.linear.data[i] - truth.linear.data[i])));
    // Half a step of 1/511 a component turns a normal by at most 1/511 x sqrt(3)/2; times albedo and diffuse.
    EXPECT_LE(worst, 0.8 * 0.75 / 511 * std::sqrt(3.0) / 2 + 1e-5) << kind;
    EXPECT_GT(truth.linear.at(30, 20)[1], 0.1F);
  }
}

// A picture of noise, magnified and bilinear: within the 8 bits of a filter's weights.
TEST_F(TruthGl, MagnifiedTexturesAgreeWithinTheirWeights) {
  scene::Character character = card(2, 2);
  scene::Texture texture;
  texture.image = Image8(8, 4, 4);
  for (size_t i = 0; i < texture.image.data.size(); ++i)
    texture.image.data[i] = i % 4 == 3 ? 255 : static_cast<uint8_t>(i * 73 % 251);
  character.images.push_back(texture);
  character.materials.front().base_colour_image = 0;
  character.materials.front().unlit = true;
  character.mesh.uvs.clear();
  for (const glm::vec3& p : character.mesh.positions) character.mesh.uvs.emplace_back(p.x, 1.3F - 0.5F * p.y);
  for (const bool mirrored : {false, true}) {
    character.images.front().mirrored_u = mirrored;
    const scene::Cast cast = cast_of(character);
    scene::Frame frame = frame_of_one(2.2, 1, 120, 90);
    add_agent(frame, cast, {0, 0, 0}, 1, 0, 0.06F);
    const Capture mesh = drawn(cast, frame);
    const truth::TruthPicture truth = truth::cast_truth(cast, frame);
    double worst = 0;
    for (size_t i = 0; i < mesh.ids.data.size(); ++i)
      if (mesh.ids.data[i] != 0 && truth.ids.data[i] != 0)
        for (size_t c = 0; c < 3; ++c)
          worst = std::max(worst,
                           std::abs(static_cast<double>(mesh.linear.data[4 * i + c] - truth.linear.data[4 * i + c])));
    // 1/256 of the difference of neighbours an axis (at most 1), and as much again where a driver rounds what it
    // filtered to 8 bits.
    EXPECT_LE(worst, 4.0 / 256) << mirrored;
    EXPECT_GT(worst, 0.0);
  }
}

// The grid where a pixel is narrower than a line and where it is wider than a cell; depth along the view axis.
TEST_F(TruthGl, TheGroundIsTheSame) {
  const scene::Cast cast = cast_of(card(0.1F, 0.1F));
  scene::Frame frame = frame_of_one(0.4, 1.5, 160, 120, 60.0);
  frame.camera.target = {0.3, 0, -4};
  frame.ground = true;
  const Capture mesh = drawn(cast, frame);
  const truth::TruthPicture truth = truth::cast_truth(cast, frame);
  double mean = 0;
  size_t ground = 0;
  for (size_t i = 0; i < mesh.depth.data.size(); ++i) {
    ASSERT_EQ(std::isfinite(mesh.depth.data[i]), std::isfinite(truth.depth.data[i])) << i;
    if (!std::isfinite(truth.depth.data[i])) continue;
    ++ground;
    EXPECT_NEAR(mesh.depth.data[i] / truth.depth.data[i], 1.0, 1e-5);
    mean += std::abs(int{mesh.colour.data[4 * i]} - int{truth.colour.data[4 * i]});
  }
  EXPECT_GT(ground, 8'000U);
  // The shader takes differences between pixels for derivatives: second order, at the edges of lines alone.
  EXPECT_LT(mean / static_cast<double>(ground), 0.5);
}

// A card with round holes, mirrored by its primitive and seen from behind: what is cut and what is culled.
TEST_F(TruthGl, MasksAndMirrorsAreTheMeshs) {
  scene::Character character = card(1, 1.6F);
  scene::Texture mask;
  mask.image = Image8(96, 128, 4);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 96; ++x) {
      uint8_t* texel = mask.image.at(x, y);
      std::fill_n(texel, 3, uint8_t{200});
      texel[3] = (x % 32 - 15.5) * (x % 32 - 15.5) + (y % 32 - 15.5) * (y % 32 - 15.5) >= 100 ? 255 : 0;
    }
  character.images.push_back(mask);
  character.materials.front().base_colour_image = 0;
  character.mesh.uvs.clear();
  for (const glm::vec3& p : character.mesh.positions) character.mesh.uvs.emplace_back(p.x + 0.5F, 1 - p.y / 1.6F);
  for (const bool masked : {false, true})
    for (const bool mirrored : {false, true})
      for (const float heading : {0.0F, 0.5F}) {
        character.materials.front().alpha_cutoff = masked ? 0.5F : 0.0F;
        for (scene::Primitive& primitive : character.mesh.primitives) primitive.mirrored = mirrored;
        const scene::Cast cast = cast_of(character);
        scene::Frame frame = frame_of_one(3, 0.8, 120, 120, 35);
        add_agent(frame, cast, {0, 0, 0}, 9, 0, heading);
        const Capture mesh = drawn(cast, frame);
        const truth::Judgement judgement = judged(cast, frame, mesh);
        EXPECT_EQ(judgement.covered > 3'000, mirrored == (heading == 0.5F)) << mirrored << heading;
        EXPECT_EQ(judgement.unexplained, 0U) << masked << mirrored << heading;
        EXPECT_LE(judgement.mask, masked ? judgement.covered / 50 : 0U);
      }
}

}  // namespace
}  // namespace crowdbench::renderers
