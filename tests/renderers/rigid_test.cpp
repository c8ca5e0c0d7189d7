#include "renderers/rigid/rigid.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "renderers/mesh/mesh_draw.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::covered;
using testing::different_ids;
using testing::frame_of_one;

class RigidGl : public testing::GlTest {
 protected:
  static std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec) {
    return make_representation({.context = context(), .cast = cast, .progress = false}, parse_spec(spec));
  }
  static Capture draw(const scene::Cast& cast, Representation& representation, double phase, int bank_clip = 0) {
    Renderer renderer(context(), cast);
    scene::Frame frame = frame_of_one(5, 1.2, 160, 160, 30);
    add_agent(frame, cast, {0.1, 0, 0}, 7, phase, 0.15F);
    frame.agents[0][0].bank_clip = bank_clip;
    frame.agents[0][0].pose = cast.banks[0]->sample(bank_clip, phase);
    const Capture c = renderer.capture(frame, representation);
    EXPECT_GT(covered(c), 300U);
    return c;
  }
};

// Skinned on the CPU with whole weights and rounded afterwards, against the GPU's: pixels on an edge may fall to the
// other side, normals round by a part in 511.
TEST_F(RigidGl, AStoredPoseIsTheMesh) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 2200}));
  const auto mesh = make(cast, "mesh");
  const auto rigid = make(cast, "rigid:poses=5");
  for (const double phase : {0.0, 0.2, 0.6}) {
    const Capture a = draw(cast, *mesh, phase);
    const Capture b = draw(cast, *rigid, phase);
    EXPECT_LE(different_ids(a, b), 4U) << phase;
    size_t off = 0;
    for (size_t i = 0; i < a.ids.data.size(); ++i)
      if (a.ids.data[i] != 0 && b.ids.data[i] != 0)
        for (size_t c = 0; c < 3; ++c)
          off += std::abs(int{a.colour.data[4 * i + c]} - int{b.colour.data[4 * i + c]}) > 3 ? 1U : 0U;
    EXPECT_LE(off, 30U) << "colour channels further off than three grey levels: edges inside the figure";
  }
}

TEST_F(RigidGl, BetweenStoredPosesTheNearestIsShown) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto rigid = make(cast, "rigid:poses=5");
  EXPECT_EQ(rigid->shown_phase(0, 0, 0.29), 0.2);
  EXPECT_EQ(rigid->shown_phase(0, 0, 0.31), 0.4);
  EXPECT_EQ(rigid->shown_phase(0, 0, 0.91), 0.0) << "the cycle closes";
  EXPECT_EQ(draw(cast, *rigid, 0.29), draw(cast, *rigid, 0.2));
  EXPECT_EQ(draw(cast, *rigid, 0.91), draw(cast, *rigid, 0.0));
  EXPECT_NE(draw(cast, *rigid, 0.31).ids, draw(cast, *rigid, 0.2).ids);
}

TEST_F(RigidGl, FewPosesOfAClipAreWarnedAbout) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  const double seconds = cast.banks[0]->clips()[0].seconds;
  const auto enough = static_cast<int>(std::ceil(4 * seconds));
  const auto said = [&](int poses) {
    ::testing::internal::CaptureStderr();
    make(cast, fmt::format("rigid:poses={}", poses));
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(said(enough - 1).find(fmt::format("{} stored frames of clip", enough - 1)), std::string::npos);
  EXPECT_EQ(said(enough), "");
}

TEST_F(RigidGl, EveryAgentHasItsOwnPoseOfItsOwnClip) {
  const scene::Character character = scene::make_mannequin({.triangles = 500});
  scene::Cast cast = cast_of(character);
  cast.banks[0] = std::make_shared<const scene::PoseBank>(*cast.characters[0], std::vector<int>{0, 1});
  const auto mesh = make(cast, "mesh");
  const auto rigid = make(cast, "rigid:poses=10");
  for (const int clip : {0, 1})
    EXPECT_LE(different_ids(draw(cast, *mesh, 0.3, clip), draw(cast, *rigid, 0.3, clip)), 6U);
  // A row of agents in all poses of both clips, in an order that is none.
  Renderer renderer(context(), cast);
  scene::Frame frame = frame_of_one(12, 1.2, 480, 80, 15);
  for (uint32_t i = 0; i < 20; ++i) {
    add_agent(frame, cast, {0.85 * i - 8, 0, 0}, i + 1, 0.1 * ((7 * i) % 10));
    frame.agents[0].back().bank_clip = static_cast<int>(i % 2);
    frame.agents[0].back().pose = cast.banks[0]->sample(static_cast<int>(i % 2), 0.1 * ((7 * i) % 10));
  }
  const Capture a = renderer.capture(frame, *mesh);
  EXPECT_GT(covered(a), 2000U);
  EXPECT_LE(different_ids(a, renderer.capture(frame, *rigid)), 20U);
}

TEST_F(RigidGl, BytesAndBudget) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const size_t vertices = make_mesh_data(*cast.characters[0]).vertices.size();
  ASSERT_EQ(vertices, 48U) << "two boxes of six quads";
  const uint64_t one = make(cast, "rigid:poses=1")->footprint().buffer_bytes;
  const uint64_t nine = make(cast, "rigid:poses=9")->footprint().buffer_bytes;
  EXPECT_EQ(nine - one, 8 * vertices * 20) << "twenty bytes a vertex and pose";
  // All of the bank's samples fit; more than that are not stored unless asked for.
  const auto fact = [&](const std::string& spec) { return make(cast, spec)->bake_info().facts[0].second; };
  EXPECT_EQ(fact("rigid"), cast.banks[0]->clips()[0].samples);
  EXPECT_EQ(fact("rigid:poses=100"), 100);
  EXPECT_THROW(make(cast, "rigid:poses=1025"), Error);
  // 5,000 triangles, one MiB: as many poses as it holds and not one more.
  const scene::Cast large = cast_of(scene::make_mannequin({.triangles = 5000}));
  const size_t pose = make_mesh_data(*large.characters[0]).vertices.size() * 20;
  const auto limited = make(large, "rigid:budget=1");
  const double stored = limited->bake_info().facts[0].second;
  EXPECT_EQ(stored, std::floor(static_cast<double>(1 << 20) / static_cast<double>(pose)));
  EXPECT_LT(stored, large.banks[0]->clips()[0].samples) << "or the budget was not what held it";
  EXPECT_THROW(make(large, fmt::format("rigid:budget=1,poses={}", stored + 1)), Error);
  MakeContext small{.context = context(), .cast = large};
  small.bake_budget = 1000;
  EXPECT_THROW(make_representation(small, parse_spec("rigid")), Error) << "not even one pose";
}

// More stored poses, less error: the point of the representation's one option.
TEST_F(RigidGl, MorePosesAreNearerToTheMesh) {
  const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  const auto mesh = make(cast, "mesh");
  std::vector<size_t> wrong;
  for (const int poses : {2, 5, 20}) {
    const auto rigid = make(cast, fmt::format("rigid:poses={}", poses));
    size_t sum = 0;
    for (int i = 0; i < 7; ++i)
      sum += different_ids(draw(cast, *mesh, 0.07 + 0.13 * i), draw(cast, *rigid, 0.07 + 0.13 * i));
    wrong.push_back(sum);
  }
  EXPECT_LT(2 * wrong[1], wrong[0]);
  EXPECT_LT(2 * wrong[2], wrong[1]);
}

// Deformable, rigid, impostor: each agent is drawn by the level that its distance asks for, and shows the next level's
// stored pose just before it.
TEST_F(RigidGl, ThreeLevels) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string flat_spec = "(flat:views=sphere-4x1,frames=2,texels=32)";
  const auto three = make(cast, "hybrid(mesh,hybrid((rigid:poses=5)," + flat_spec + ",distance=12),distance=8)");
  const auto mesh = make(cast, "mesh");
  const auto rigid = make(cast, "rigid:poses=5");
  const auto flat = make(cast, "flat:views=sphere-4x1,frames=2,texels=32");
  Renderer renderer(context(), cast);
  const auto picture = [&](Representation& r, double distance, double phase) {
    scene::Frame frame = frame_of_one(distance, 0.0, 96, 96, 25);
    add_agent(frame, cast, {0, 0, 0}, 1, phase, 0.2F);
    const Capture c = renderer.capture(frame, r);
    EXPECT_GT(covered(c), 50U);
    return c;
  };
  EXPECT_EQ(picture(*three, 6, 0.29), picture(*mesh, 6, 0.29));
  EXPECT_EQ(picture(*three, 7.6, 0.29), picture(*mesh, 7.6, static_cast<double>(0.2F))) << "the rigid mesh's pose";
  EXPECT_EQ(picture(*three, 9, 0.29), picture(*rigid, 9, 0.29));
  EXPECT_EQ(picture(*three, 11.5, 0.62), picture(*rigid, 11.5, 0.5)) << "the impostor's pose, or the nearest to it";
  EXPECT_EQ(picture(*three, 14, 0.29), picture(*flat, 14, 0.29));
  EXPECT_NE(picture(*rigid, 9, 0.29), picture(*mesh, 9, 0.29));
}

}  // namespace
}  // namespace crowdbench::renderers
