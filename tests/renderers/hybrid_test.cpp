#include "renderers/hybrid/hybrid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

scene::FrameAgent agent_at(const glm::vec3& position, float scale = 1) {
  scene::FrameAgent a;
  a.position = position;
  a.scale = scale;
  return a;
}

TEST(LodPolicy, SwitchDistanceIsTheGeometry) {
  scene::Camera camera;
  camera.fov_y = std::numbers::pi / 2;  // tan(45 degrees) = 1: a pixel at depth d is 2 d / rows
  const LodCharacter character{1.8, 0.015};
  // At 480 rows a texel of 15 mm covers a pixel at 0.015 * 480 / 2 = 3.6 m.
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 1}, character, camera, 480), 3.6, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 0.5}, character, camera, 480), 7.2, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 2}, character, camera, 480), 1.8, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::height, 120}, character, camera, 480), 3.6, 1e-12);
  EXPECT_EQ(switch_distance({LodPolicy::Rule::distance, 20}, character, camera, 480), 20);
}

TEST(LodPolicy, SplitsByEachRuleAndKeepsOrder) {
  scene::Frame frame = frame_of_one(5, 0.9, 640, 480, 90);  // looks along -Z
  // Middle 0.9 m over the pivot: put pivots so that middles lie on a level with the eye.
  frame.agents[0] = {agent_at({0, -0.9F, -10}), agent_at({0, -0.9F, -30}), agent_at({18, -0.9F, -10}),
                     agent_at({0, -0.9F, -25}, 2)};
  const AgentLists all = {{0, 1, 2, 3}};
  AgentLists near;
  AgentLists far;
  const std::vector<LodCharacter> character = {{1.8, 0.015}};
  split_agents({LodPolicy::Rule::distance, 20}, character, frame, all, near, far);
  EXPECT_EQ(near[0], (std::vector<uint32_t>{0}));
  EXPECT_EQ(far[0], (std::vector<uint32_t>{1, 2, 3})) << "20.6 m away off the axis is beyond 20";
  // By height: 1.8 m at 20 m depth are 21.6 pixels of 480 rows.
  split_agents({LodPolicy::Rule::height, 21.6}, character, frame, all, near, far);
  EXPECT_EQ(near[0], (std::vector<uint32_t>{0, 2, 3})) << "depth counts, not distance; twice as tall is near at 25 m";
  EXPECT_EQ(far[0], (std::vector<uint32_t>{1}));
  split_agents({LodPolicy::Rule::ratio, 0.18}, character, frame, all, near, far);
  EXPECT_EQ(far[0], (std::vector<uint32_t>{1})) << "0.015 * 480 / (2 * 20) = 0.18: the same place";
}

class HybridGl : public GlTest {
 protected:
  std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec) {
    MakeContext make{.context = context(), .cast = cast};
    make.use_cache = false;
    make.progress = false;
    return make_representation(make, parse_spec(spec));
  }
};

TEST_F(HybridGl, OfOneRepresentationTwiceIsThatRepresentation) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto mesh = make(cast, "mesh");
  const auto both = make(cast, "hybrid(mesh,mesh,distance=8)");
  Renderer renderer(context(), cast);
  scene::Frame frame = frame_of_one(6, 1.5, 160, 120, 40);
  for (uint32_t i = 0; i < 6; ++i) add_agent(frame, cast, {0.5 * i - 1.2, 0, -1.5 * i}, i + 1, 0.1 * i);
  const Capture a = renderer.capture(frame, *mesh);
  const Capture b = renderer.capture(frame, *both);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.colour, b.colour);
  const auto& hybrid = dynamic_cast<const HybridRepresentation&>(*both);
  EXPECT_EQ(hybrid.near_agents() + hybrid.far_agents(), 6U);
  EXPECT_GT(hybrid.near_agents(), 0U);
  EXPECT_GT(hybrid.far_agents(), 0U);
}

TEST_F(HybridGl, DrawsNearAgentsAsTheMeshAndFarOnesAsImpostors) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string flat_spec = "flat:views=sphere-4x1,frames=2,texels=32";
  const auto mesh = make(cast, "mesh");
  const auto flat = make(cast, flat_spec);
  const auto both = make(cast, "hybrid(mesh," + flat_spec + ",distance=10)");
  Renderer renderer(context(), cast);
  for (const double distance : {6.0, 14.0}) {
    scene::Frame frame = frame_of_one(distance, 0.9, 120, 120, 25);
    add_agent(frame, cast, {0, 0, 0}, 1, 0.0);
    const auto expected = renderer.capture(frame, distance < 10 ? *mesh : *flat).colour;
    EXPECT_EQ(renderer.capture(frame, *both).colour, expected) << distance;
    EXPECT_NE(renderer.capture(frame, distance < 10 ? *flat : *mesh).colour, expected);
  }
  EXPECT_EQ(both->footprint().gpu_bytes(), mesh->footprint().gpu_bytes() + flat->footprint().gpu_bytes());
}

TEST_F(HybridGl, RefusesRulesThatCannotDecide) {
  const scene::Cast cast = cast_of(testing::two_bones());
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,ratio=1)"), Error) << "a mesh has no texels";
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,distance=5,height=30)"), Error);
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,height=0)"), Error);
  EXPECT_THROW(make(cast, "hybrid(mesh)"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
