#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "core/colour.h"
#include "core/error.h"
#include "core/image_io.h"
#include "gl_test_support.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/counters.h"
#include "renderers/gl/program.h"
#include "renderers/mesh/mesh_data.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/pose.h"
#include "tests/renderers/compare_captures.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::covered;
using testing::different_ids;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;

class MeshGl : public GlTest {};

Capture draw(const scene::Cast& cast, const scene::Frame& frame, const CaptureOptions& options = {},
             const std::string& spec = "mesh") {
  Renderer renderer(context(), cast);
  const auto representation = make(cast, spec);
  return renderer.capture(frame, *representation, options);
}

// The vertical field of view that makes one metre at depth 1 as long as `focal` pixels.
double fov_deg(int height, double focal) {
  return 2.0 * std::atan(height / 2.0 / focal) * 180.0 / 3.14159265358979323846;
}

scene::Material& material(scene::Character& character) { return character.materials.front(); }

// Alpha in 5 x 5 checks, every other one empty.
void mask_with_checks(scene::Character& character, float cutoff) {
  scene::Texture checks;
  checks.image = Image8(80, 80, 4);
  checks.nearest = true;
  checks.min_filter = scene::MinFilter::nearest;
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) {
      uint8_t* texel = checks.image.at(x, y);
      texel[0] = texel[1] = texel[2] = 255;
      texel[3] = (x / 16 + y / 16) % 2 == 0 ? 200 : 100;
    }
  character.images.push_back(checks);
  material(character).base_colour_image = static_cast<int>(character.images.size()) - 1;
  material(character).alpha_cutoff = cutoff;
  character.mesh.uvs.clear();
  for (const glm::vec3& p : character.mesh.positions) character.mesh.uvs.emplace_back(p.x + 0.5F, 1.0F - p.y);
}

// A card of 1 m x 1 m that covers 100 x 100 pixels: a check has 20.
TEST_F(MeshGl, AMaskCutsHolesIntoColourIdsAndDepth) {
  const auto drawn = [](float cutoff, float alpha, bool colours) {
    scene::Character character = card(1.0F, 1.0F, glm::vec4(1, 1, 1, alpha));
    mask_with_checks(character, cutoff);
    if (colours) character.mesh.colours.assign(character.mesh.positions.size(), glm::vec4(1, 1, 1, 0.5F));
    const scene::Cast cast = cast_of(std::move(character));
    scene::Frame frame = frame_of_one(4.0, 0.5, 200, 200, fov_deg(200, 400.0));
    add_agent(frame, cast, {0, 0, 0}, 7);
    return draw(cast, frame);
  };
  const Capture masked = drawn(0.5F, 1.0F, false);
  size_t there = 0;
  for (int y = 50; y < 150; ++y)
    for (int x = 50; x < 150; ++x) {
      const bool check = ((x - 50) / 20 + (y - 50) / 20) % 2 == 0;
      ASSERT_EQ(masked.ids.at(x, y)[0] != 0, check) << x << ", " << y;
      there += check ? 1 : 0;
    }
  EXPECT_EQ(covered(masked), there);
  EXPECT_EQ(covered(drawn(0.0F, 1.0F, false)), 10000U) << "opaque materials have no alpha";
  EXPECT_EQ(covered(drawn(0.3F, 1.0F, false)), 10000U) << "100 / 255 is above it";
  EXPECT_EQ(covered(drawn(0.5F, 0.5F, false)), 0U) << "the factor multiplies";
  EXPECT_EQ(covered(drawn(0.3F, 1.0F, true)), there) << "vertex colours multiply";
}

// A card 1 m wide and 0.5 m high at 4 m: with a focal length of f pixels a metre covers f / 4 pixels.
TEST_F(MeshGl, CardCoversExactlyItsPixelsAtItsDepth) {
  const int size = 200;
  const double f = 400.0;  // pixels: 100 pixels a metre at 4 m
  const double fov = fov_deg(size, f);
  const scene::Cast cast = cast_of(card(1.0F, 0.5F));
  scene::Frame frame = frame_of_one(4.0, 0.25, size, size, fov);
  add_agent(frame, cast, {0, 0, 0}, 7);
  const Capture c = draw(cast, frame);
  // 100 x 50 pixels in the middle: columns 50..149, rows 75..124.
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const bool inside = x >= 50 && x < 150 && y >= 75 && y < 125;
      ASSERT_EQ(c.ids.at(x, y)[0], inside ? 7U : 0U) << x << ", " << y;
      if (inside) {
        ASSERT_NEAR(c.depth.at(x, y)[0], 4.0F, 4.0e-6F);
      } else {
        ASSERT_TRUE(std::isinf(c.depth.at(x, y)[0]));
        ASSERT_EQ(c.colour.at(x, y)[0], 128);
      }
    }
}

TEST_F(MeshGl, DepthIsInMetresWithAFiniteFarPlaneToo) {
  const scene::Cast cast = cast_of(card(4.0F, 4.0F));
  for (const double far : {0.0, 12.0, 1000.0}) {
    scene::Frame frame = frame_of_one(7.0, 2.0, 32, 32);
    frame.camera.far = far;
    add_agent(frame, cast, {0, 0, 0}, 1);
    EXPECT_NEAR(draw(cast, frame).depth.at(16, 16)[0], 7.0F, 1e-4F) << far;
  }
}

// Positions as the vertex shader sees them, against linear blend skinning in double on the CPU. What may differ: 16-bit
// weights (0.5/65535 each, on levers below 1 m), float matrices and the float agent transform.
TEST_F(MeshGl, SkinsAsTheCpuDoes) {
  const scene::Character character = scene::make_mannequin({.triangles = 2200});
  const int clip = character.placement.default_clip;
  ASSERT_GE(clip, 0);
  const scene::Cast cast = cast_of(character);
  ASSERT_EQ(cast.banks[0]->clips()[0].clip, 0);
  const scene::PoseBank& bank = *cast.banks[0];
  const MeshData data = make_mesh_data(character);
  const gl::Buffer vertices(context(), data.vertices);
  const gl::Attribute attributes[] = {
      {CB_ATTRIBUTE_POSITION, 4, GL_FLOAT, false, false, offsetof(MeshVertex, position)},
      {CB_ATTRIBUTE_NORMAL, 4, GL_INT_2_10_10_10_REV, true, false, offsetof(MeshVertex, normal)},
      {CB_ATTRIBUTE_UV, 2, GL_FLOAT, false, false, offsetof(MeshVertex, uv)},
      {CB_ATTRIBUTE_JOINTS, 4, GL_UNSIGNED_SHORT, false, true, offsetof(MeshVertex, joints)},
      {CB_ATTRIBUTE_WEIGHTS, 4, GL_UNSIGNED_SHORT, true, false, offsetof(MeshVertex, weights)},
  };
  const gl::VertexArray array(context(), vertices, sizeof(MeshVertex), attributes, nullptr);
  const gl::Program program(context(), {"renderers/mesh/mesh.vert", "renderers/mesh/mesh.frag"}, {{"CB_FEEDBACK", ""}},
                            {"f_world"});
  const auto count = static_cast<GLsizei>(data.vertices.size());
  const gl::Buffer feedback(context(), data.vertices.size() * sizeof(glm::vec3));

  const uint32_t samples = bank.clips()[0].samples;
  double worst_on_sample = 0;
  double worst_between = 0;
  for (const double phase : {0.0, 7.0 / samples, 13.0 / samples, 2.37 / samples, 0.999}) {
    const glm::dvec3 place(3.0, 0.0, -8.0);
    const double turns = 0.15;
    const float scale = 1.1F;
    scene::Frame frame = frame_of_one(2.0, 1.5, 64, 64);
    // The second of two agents, so that instance and palette offsets count.
    add_agent(frame, cast, {0, 0, 0}, 1, 0.5);
    add_agent(frame, cast, place, 2, phase, static_cast<float>(turns), scale);
    FrameResources resources(context(), cast);
    resources.upload(frame);
    const Target target(context(), 64, 64, {});  // nothing is rasterised, yet a draw wants a complete frame buffer
    target.bind();
    const uint32_t second[] = {1};
    resources.draw_posed(0, second, [&](uint32_t first, uint32_t instances) {
      array.set_instance_stream(CB_ATTRIBUTE_AGENT, resources.list(), first * sizeof(uint32_t));
      array.bind();
      program.use();
      program.set(CB_LOCATION_JOINTS, static_cast<uint32_t>(bank.joints()));
      glEnable(GL_RASTERIZER_DISCARD);
      feedback.bind(GL_TRANSFORM_FEEDBACK_BUFFER, 0);
      glBeginTransformFeedback(GL_POINTS);
      glDrawArraysInstanced(GL_POINTS, 0, count, static_cast<GLsizei>(instances));
      glEndTransformFeedback();
      glDisable(GL_RASTERIZER_DISCARD);
    });
    std::vector<glm::vec3> got(data.vertices.size());
    feedback.read(got.data(), got.size() * sizeof(glm::vec3));

    const bool on_sample = std::abs(phase * samples - std::round(phase * samples)) < 1e-9;
    std::vector<glm::dmat4> palette;
    if (on_sample) {
      palette = scene::model_matrices(character, 0, phase);
    } else {
      for (const scene::Mat3x4& m : bank.palette(bank.sample(0, phase)))
        palette.push_back(glm::transpose(glm::dmat4(m.rows[0], m.rows[1], m.rows[2], glm::dvec4(0, 0, 0, 1))));
    }
    const std::vector<glm::dvec3> posed = scene::skin_positions(character.mesh, palette);
    const double s = std::sin(turns * 2 * 3.14159265358979323846);
    const double c = std::cos(turns * 2 * 3.14159265358979323846);
    double& worst = on_sample ? worst_on_sample : worst_between;
    for (size_t v = 0; v < got.size(); ++v) {
      const glm::dvec3 p = posed[data.source_vertex[v]] * static_cast<double>(scale);
      const glm::dvec3 want = glm::dvec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x) + place - frame.origin;
      worst = std::max(worst, glm::length(glm::dvec3(got[v]) - want));
    }
  }
  std::printf("worst vertex: %.2e m on a bank sample, %.2e m between\n", worst_on_sample, worst_between);
  EXPECT_LT(worst_on_sample, 1e-5);
  EXPECT_LT(worst_between, 1e-5);
}

// The upper of two boxes has turned by a quarter about X and, with the agent turned by a quarter, lies along world +X.
TEST_F(MeshGl, OneBoneTurnsItsBox) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const int size = 240;
  const double f = 390;  // the nearest faces lie 3.9 m away: 100 pixels a metre
  scene::Frame frame = frame_of_one(4.0, 1.0, size, size, fov_deg(size, f));
  add_agent(frame, cast, {0, 0, 0}, 3, 0.5, 0.25F);
  const Capture c = draw(cast, frame);
  const auto id = [&](double x, double y) {
    return c.ids.at(static_cast<int>(std::floor(120 + 100 * x)),
                    static_cast<int>(std::floor(120 - 100 * (y - 1.0))))[0];
  };
  // The upper box: x from 0 to 0.8, y from 0.9 to 1.1. The lower one: x from -0.1 to 0.1, y up to 1.
  for (const double x : {0.015, 0.4, 0.785})
    for (const double y : {0.915, 1.0, 1.085}) EXPECT_EQ(id(x, y), 3U) << x << ", " << y;
  EXPECT_EQ(id(0.815, 1.0), 0U);
  EXPECT_EQ(id(0.4, 1.115), 0U);
  EXPECT_EQ(id(0.4, 0.885), 0U);
  EXPECT_EQ(id(0.0, 1.3), 0U) << "where it stood before it turned";
  EXPECT_EQ(id(-0.3, 1.0), 0U) << "where it would lie had it turned the other way";
  EXPECT_EQ(id(0.0, 0.5), 3U);
  EXPECT_NEAR(c.depth.at(160, 120)[0], 3.9F, 1e-4F);
}

TEST_F(MeshGl, BackFacesAreCulledUnlessDoubleSided) {
  scene::Character one = card(1.0F, 1.0F);
  scene::Frame frame = frame_of_one(4.0, 0.5, 64, 64);
  const scene::Cast single = cast_of(one);
  material(one).double_sided = true;
  const scene::Cast both = cast_of(one);
  add_agent(frame, single, {0, 0, 0}, 1, 0, 0.0F);
  const Capture front = draw(single, frame);
  EXPECT_EQ(draw(both, frame), front);
  frame.agents[0].clear();
  add_agent(frame, single, {0, 0, 0}, 1, 0, 0.5F);  // its back
  EXPECT_EQ(covered(draw(single, frame)), 0U);
  // Its normal is flipped towards the eye, so its back is as bright as its front.
  const Capture back = draw(both, frame);
  EXPECT_EQ(covered(back), covered(front));
  EXPECT_EQ(back.colour.at(32, 32)[0], front.colour.at(32, 32)[0]);
}

TEST_F(MeshGl, MirroredPrimitivesKeepTheirFront) {
  scene::Character character = card(1.0F, 1.0F);
  character.skeleton.nodes[0].scale = {-1, 1, 1};
  scene::Frame frame = frame_of_one(4.0, 0.5, 64, 64);
  const scene::Cast unaware = cast_of(character);
  character.mesh.primitives[0].mirrored = true;
  const scene::Cast aware = cast_of(character);
  add_agent(frame, aware, {0, 0, 0}, 1);
  EXPECT_EQ(covered(draw(unaware, frame)), 0U) << "the matrix alone shows the back";
  EXPECT_GT(covered(draw(aware, frame)), 100U);
}

// A third of a pixel's width is covered: the mean is taken in linear light.
TEST_F(MeshGl, SupersamplingAveragesInLinearLight) {
  scene::Character character = card(2.0F, 4.0F);
  material(character).unlit = true;
  const scene::Cast cast = cast_of(character);
  const int size = 30;
  // 10 pixels a metre at 4 m; the card's right edge lies at x = 1 m - 2/3 pixel.
  scene::Frame frame = frame_of_one(4.0, 2.0, size, size, fov_deg(size, 40));
  add_agent(frame, cast, {-2.0 / 30.0, 0, 0}, 1);
  frame.antialiasing.supersample = 3;
  const Capture c = draw(cast, frame, {.linear = true});
  const double background = static_cast<double>(frame.background.r);
  const double mean = (1.0 + 2.0 * background) / 3.0;
  EXPECT_NEAR(c.linear.at(24, 15)[0], mean, 1e-6);
  EXPECT_EQ(c.colour.at(24, 15)[0], linear_to_srgb8(mean));
  EXPECT_EQ(c.colour.at(23, 15)[0], 255);
  EXPECT_EQ(c.colour.at(25, 15)[0], 128);
  // Id and depth are the centre sample's, which is not covered.
  EXPECT_EQ(c.ids.at(23, 15)[0], 1U);
  EXPECT_EQ(c.ids.at(24, 15)[0], 0U);
  EXPECT_TRUE(std::isinf(c.depth.at(24, 15)[0]));
  const auto mesh = make(cast, "mesh");
  Renderer renderer(context(), cast);
  for (const int wrong : {0, 2, 1001}) {
    frame.antialiasing.supersample = wrong;
    EXPECT_THROW((void)renderer.capture(frame, *mesh), Error) << wrong;
  }
}

// Every 8-bit code, through the outfit's factor of an unlit white card.
TEST_F(MeshGl, EncodesSrgbWithinOneCode) {
  scene::Character character = card(1.0F, 1.0F);
  material(character).unlit = true;
  const scene::Cast cast = cast_of(character);
  const int size = 160;
  scene::Frame frame = frame_of_one(10.0, 8.0, size, size, fov_deg(size, 100));  // 10 pixels a metre
  for (uint32_t code = 0; code < 256; ++code) {
    scene::Outfit outfit;
    for (glm::vec4& c : outfit.colours) c = glm::vec4(static_cast<float>(srgb_to_linear(code / 255.0)));
    frame.outfits.push_back(outfit);
    const uint32_t row = code / 16;
    add_agent(frame, cast, {static_cast<double>(code % 16) - 7.5, static_cast<double>(row), 0}, code + 1);
    frame.agents[0].back().outfit = code + 1;
  }
  const Capture c = draw(cast, frame, {.linear = true});
  int worst = 0;
  for (int code = 0; code < 256; ++code) {
    const int x = 5 + 10 * (code % 16);
    const int y = size - 5 - 10 * (code / 16);
    ASSERT_EQ(c.ids.at(x, y)[0], static_cast<uint32_t>(code) + 1);
    worst = std::max(worst, std::abs(c.colour.at(x, y)[0] - code));
    ASSERT_NEAR(c.linear.at(x, y)[0], srgb_to_linear(code / 255.0), 1e-6);
  }
  EXPECT_LE(worst, 1);
}

TEST_F(MeshGl, LightUnlitAndEmissiveAreAsStated) {
  const auto value = [](const scene::Material& m) {
    scene::Character character = card(1.0F, 1.0F);
    character.materials.front() = m;
    const scene::Cast cast = cast_of(character);
    scene::Frame frame = frame_of_one(4.0, 0.5, 16, 16, 10);
    add_agent(frame, cast, {0, 0, 0}, 1);
    return draw(cast, frame, {.linear = true}).linear.at(8, 8)[0];
  };
  scene::Material m;
  m.base_colour = glm::vec4(0.5F);
  // The card faces +Z, where the light's direction (0.4, 0.8, 0.45) / 0.9798 has 0.45928.
  const double z = 0.45 / std::sqrt(0.4 * 0.4 + 0.8 * 0.8 + 0.45 * 0.45);
  EXPECT_NEAR(value(m), 0.5 * (0.25 + 0.75 * z), 1e-4);
  m.emissive = glm::vec3(0.125F);
  EXPECT_NEAR(value(m), 0.5 * (0.25 + 0.75 * z) + 0.125, 1e-4);
  m.unlit = true;
  EXPECT_NEAR(value(m), 0.5, 1e-6);
}

// A primitive that came without normals is lit by its faces as they are posed, whatever was stored for it, from both
// sides.
TEST_F(MeshGl, FlatPrimitivesAreLitByTheirPosedFaces) {
  const scene::Character right = card(1.0F, 1.0F);
  scene::Character wrong = right;
  for (glm::vec3& normal : wrong.mesh.normals) normal = {1.0F, 0.0F, 0.0F};
  scene::Character flat = wrong;
  for (scene::Primitive& primitive : flat.mesh.primitives) primitive.flat = true;
  for (const float heading : {0.0F, 0.1F}) {
    const auto picture = [&](const scene::Character& character) {
      const scene::Cast cast = cast_of(character);
      scene::Frame frame = frame_of_one(3.0, 0.5, 64, 64, 40.0);
      add_agent(frame, cast, {0, 0, 0}, 1, 0.0, heading);
      return draw(cast, frame);
    };
    const Capture expected = picture(right);
    EXPECT_GT(covered(expected), 400U);
    EXPECT_NE(picture(wrong).colour.data, expected.colour.data);
    const Capture shown = picture(flat);
    ASSERT_EQ(shown.colour.data.size(), expected.colour.data.size());
    for (size_t i = 0; i < expected.colour.data.size(); ++i)
      ASSERT_NEAR(shown.colour.data[i], expected.colour.data[i], 1) << heading;
  }
}

TEST_F(MeshGl, ColoursAreTheSameWithAndWithoutIds) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  scene::Frame frame = frame_of_one(5.0, 1.0, 200, 200);
  frame.ground = true;
  for (uint32_t i = 0; i < 5; ++i)
    add_agent(frame, cast, {i - 2.0, 0, -0.5 * i}, i + 1, 0.17 * i, 0.2F * static_cast<float>(i));
  Renderer renderer(context(), cast);
  const auto mesh = make(cast, "mesh");
  const Target plain(context(), 200, 200, {});
  renderer.draw(frame, *mesh, plain);
  const Capture without = plain.read();
  const Capture with = renderer.capture(frame, *mesh);
  EXPECT_EQ(with.colour, without.colour);
  EXPECT_EQ(with.depth, without.depth);
  EXPECT_TRUE(without.ids.empty());
  EXPECT_GT(covered(with), 1000U);
}

// The vertex cache order holds vertex shading to 1.1 of the vertices that are indexed.
TEST_F(MeshGl, VertexInvocationsStayNearTheVertices) {
  const scene::Character character = scene::make_mannequin({.triangles = 5000});
  const scene::Cast cast = cast_of(character);
  const MeshData data = make_mesh_data(character);
  scene::Frame frame = frame_of_one(9.0, 1.0, 64, 64);
  const uint32_t agents = 8;
  for (uint32_t i = 0; i < agents; ++i) add_agent(frame, cast, {i - 4.0, 0, 0}, i + 1);
  Renderer renderer(context(), cast);
  for (const char* spec : {"mesh", "mesh:floor=1"}) {
    const auto mesh = make(cast, spec);
    const Target target(context(), 64, 64, {});
    renderer.draw(frame, *mesh, target);
    gl::PipelineCounter counter(context());
    counter.begin();
    renderer.draw(frame, *mesh, target);
    counter.end();
    const gl::PipelineCounts counts = counter.result();
    if (!counts.vertex_invocations) GTEST_SKIP() << "this driver has no pipeline statistics";
    const double share =
        static_cast<double>(*counts.vertex_invocations) / static_cast<double>(agents * data.vertices.size());
    std::printf("%s: %zu vertices, %.3f vertex invocations each\n", spec, data.vertices.size(), share);
    EXPECT_LE(share, 1.1);
    EXPECT_GE(share, 1.0);
    EXPECT_EQ(mesh->triangles(0), character.triangles());
    ASSERT_TRUE(counts.samples_passed);
    EXPECT_GT(*counts.samples_passed, 100U);
  }
}

// The same scene 100 km from the origin is the same picture: doubles never reach the GPU. Every coordinate is a
// multiple of 1/1024, so that the differences are exact.
TEST_F(MeshGl, FarFromTheOriginNothingMoves) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  Capture near;
  for (const double offset : {0.0, 1e5, -1e5}) {
    scene::Frame frame = frame_of_one(4.25, 1.5, 160, 120);
    frame.ground = true;
    frame.camera.eye += glm::dvec3(offset, 0, offset);
    frame.camera.target += glm::dvec3(offset, 0, offset);
    frame.origin = frame.camera.eye;
    for (uint32_t i = 0; i < 3; ++i)
      add_agent(frame, cast, {offset + 0.75 * i - 0.5, 0, offset - 0.25 * i}, i + 1, 0.2 * i);
    const Capture c = draw(cast, frame);
    if (offset == 0.0) {
      near = c;
      EXPECT_GT(covered(c), 1000U);
      continue;
    }
    EXPECT_EQ(c.colour, near.colour) << offset;
    EXPECT_EQ(c.ids, near.ids) << offset;
    EXPECT_EQ(c.depth, near.depth) << offset;
  }
}

// The floor draws the pose of phase 0, so at phase 0 both pictures are the same but for rounding at silhouettes.
TEST_F(MeshGl, FloorDrawsTheSameFigureAtPhaseZero) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  scene::Frame frame = frame_of_one(4.0, 0.9, 300, 300);
  add_agent(frame, cast, {0, 0, 0}, 1, 0.0, 0.1F, 1.05F);
  const Capture a = draw(cast, frame);
  const Capture b = draw(cast, frame, {}, "mesh:floor=1");
  EXPECT_GT(covered(a), 5000U);
  EXPECT_LE(different_ids(a, b), covered(a) / 500);
}

TEST_F(MeshGl, NormalsPackWithinATenthOfADegree) {
  for (int i = 0; i < 500; ++i) {
    const double a = i * 0.37;
    const double b = i * 0.91;
    const glm::vec3 n(static_cast<float>(std::sin(a) * std::cos(b)), static_cast<float>(std::cos(a)),
                      static_cast<float>(std::sin(a) * std::sin(b)));
    const glm::vec3 back = glm::normalize(unpack_normal(pack_normal(n)));
    EXPECT_LT(std::acos(std::min(1.0F, glm::dot(n, back))) * 57.2958F, 0.12F);
  }
}

// Two character types in one frame: each list draws its own type, with its own agents' ids and places.
TEST_F(MeshGl, SeveralCharacterTypesKeepTheirAgentsApart) {
  scene::Cast cast = cast_of(card(0.5F, 0.5F));
  const scene::Cast tall = cast_of(card(0.25F, 1.0F));
  cast.characters.push_back(tall.characters[0]);
  cast.banks.push_back(tall.banks[0]);
  cast.shares = {0.5, 0.5};
  const int size = 100;
  scene::Frame frame = frame_of_one(4.0, 0.5, size, size, fov_deg(size, 160));  // 40 pixels a metre
  add_agent(frame, cast, {-0.75, 0, 0}, 11);
  add_agent(frame, cast, {0, 0, 0}, 12);
  frame.agents.insert(frame.agents.begin(), std::vector<scene::FrameAgent>());
  add_agent(frame, cast, {0.75, 0, 0}, 13);
  ASSERT_EQ(frame.agents[0].size(), 1U);  // one square card, two tall ones
  ASSERT_EQ(frame.agents[1].size(), 2U);
  const Capture c = draw(cast, frame);
  std::map<uint32_t, size_t> pixels;
  for (const uint32_t id : c.ids.data) ++pixels[id];
  EXPECT_EQ(pixels[11], 10U * 40U);
  EXPECT_EQ(pixels[12], 10U * 40U);
  EXPECT_EQ(pixels[13], 20U * 20U);
  EXPECT_EQ(c.ids.at(80, 60)[0], 13U);
}

// Palettes that do not fit one buffer are computed and drawn in batches; the picture is the same.
TEST_F(MeshGl, BatchesOfPalettesChangeNothing) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  scene::Frame frame = frame_of_one(9.0, 1.5, 200, 120);
  AgentLists lists(1);
  for (uint32_t i = 0; i < 11; ++i) {
    add_agent(frame, cast, {0.6 * i - 3.0, 0, -0.3 * (i % 3)}, i + 1, 0.13 * i, 0.1F * static_cast<float>(i));
    lists[0].push_back(i);
  }
  Renderer renderer(context(), cast);
  const auto mesh = make(cast, "mesh");
  const Capture whole = renderer.capture(frame, *mesh);
  ASSERT_GT(covered(whole), 500U);
  scene::Frame empty = frame;
  empty.agents[0].clear();
  const uint64_t agent_bytes = static_cast<uint64_t>(cast.banks[0]->joints()) * sizeof(scene::Mat3x4);
  for (const uint64_t block : {uint64_t{1}, agent_bytes * 3}) {
    FrameResources resources(context(), cast, block);
    resources.upload(frame);
    const Target target(context(), frame.width, frame.height, {.ids = true});
    renderer.draw(empty, *mesh, target);
    int batches = 0;
    resources.draw_posed(0, lists[0], [&](uint32_t, uint32_t) { ++batches; });
    EXPECT_EQ(batches, block == 1 ? 11 : 4);
    resources.upload(frame);
    mesh->draw(frame, resources, lists, target.pass());
    EXPECT_EQ(target.read(), whole);
  }
}

TEST_F(MeshGl, GroundIsDrawnWithoutAnId) {
  const scene::Cast cast = cast_of(card(0.1F, 0.1F));
  scene::Frame frame = frame_of_one(4.0, 1.5, 120, 90);
  frame.ground = true;
  const Capture c = draw(cast, frame);
  EXPECT_EQ(covered(c), 0U);
  // Straight below the horizon's middle at pixel row y the ground lies at depth 1.5 f / (y - 45).
  const double f = 45.0 / std::tan(20.0 * 3.14159265358979323846 / 180);
  for (const int y : {60, 75, 89}) EXPECT_NEAR(c.depth.at(60, y)[0], 1.5 * f / (y + 0.5 - 45.0), 1e-3) << y;
  EXPECT_TRUE(std::isinf(c.depth.at(60, 30)[0]));
  frame.ground_height = 0.5;
  const Capture higher = draw(cast, frame);
  EXPECT_NEAR(higher.depth.at(60, 75)[0], 1.0 * f / (75.5 - 45.0), 1e-3);
}

}  // namespace
}  // namespace crowdbench::renderers
