// The mesh with levels of detail: which level an agent gets, and that it is drawn as the level alone is.
#include "renderers/mesh/mesh_lods.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "renderers/frame/capture.h"
#include "renderers/mesh/mesh.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::fact;
using testing::frame_of_one;
using testing::make;
using testing::walker;

std::vector<std::string> texts(const std::vector<Spec>& specs) {
  std::vector<std::string> out;
  for (const Spec& spec : specs) out.push_back(spec.text());
  return out;
}

TEST(MeshLods, ReadsItsLevels) {
  EXPECT_EQ(texts(lod_specs("2000/500/0.02", walker())),
            (std::vector<std::string>{"mesh:triangles=2000", "mesh:triangles=500", "mesh:ratio=0.02"}));
  for (const char* bad : {"", "/", "500/", "x", "500/2000", "500/500", "0", "-1", "0.1/0.2", "1.5", "nan", "inf", "own",
                          "0x10", "4000001", "17/16/15/14/13/12/11/10/9/8/7/6/5/4/3/2/1"})
    EXPECT_THROW(lod_specs(bad, walker()), Error) << bad;
}

TEST(MeshLods, TakesTheFilesOwn) {
  scene::Character one = scene::Character(*walker().characters[0]);
  one.levels = {one.mesh, one.mesh};
  const scene::Cast cast = cast_of(std::move(one));
  EXPECT_EQ(texts(lod_specs("own", cast)), (std::vector<std::string>{"mesh:lod=1", "mesh:lod=2"}));
}

// Errors of 1, 3 and 2 cm: the last one is better than the one before it.
TEST(MeshLods, ChoosesTheCoarsestThatMayBeSeen) {
  const std::vector<double> errors = {0.01, 0.03, 0.02};
  EXPECT_EQ(coarsest_within(errors, 0.005, 1), 0U);
  EXPECT_EQ(coarsest_within(errors, 0.010, 1), 1U);
  EXPECT_EQ(coarsest_within(errors, 0.019, 1), 1U);
  EXPECT_EQ(coarsest_within(errors, 0.020, 1), 3U);
  EXPECT_EQ(coarsest_within(errors, 0.005, 4), 3U);
  EXPECT_EQ(coarsest_within(errors, 0, 1), 0U) << "not in front of the eye";
  EXPECT_EQ(coarsest_within({}, 1, 1), 0U);
}

// 90 degrees over 200 rows: at 10 metres a pixel is 10 cm. An agent of twice the size has half of it to itself.
TEST(MeshLods, MeasuresPixelsAtTheAgentsMiddle) {
  scene::Frame frame = frame_of_one(10, 1, 200, 200, 90);
  add_agent(frame, walker(), {0, 0, 0}, 1);
  add_agent(frame, walker(), {3, 0, 0}, 2, 0, 0, 2.0F);
  add_agent(frame, walker(), {0, 0, 20}, 3);
  const auto at = [&](size_t i) { return metres_a_pixel(pixel_scale(frame), frame.agents[0][i], 2.0); };
  EXPECT_NEAR(at(0), 0.1, 1e-6);
  EXPECT_NEAR(at(1), 0.05, 1e-6);
  EXPECT_EQ(at(2), 0) << "behind";
}

class MeshLodsGl : public testing::GlTest {
 protected:
  static constexpr const char* kSpec = "mesh:lods=300/120";
  // Two walkers.
  static scene::Frame frame_at(double distance) {
    scene::Frame frame = frame_of_one(distance, 1.0, 240, 240);
    add_agent(frame, walker(), {0, 0, 0}, 1, 0.2, 0.1F);
    add_agent(frame, walker(), {0.8, 0, -0.3}, 7, 0.6, 0.4F);
    return frame;
  }
};

TEST_F(MeshLodsGl, DrawsEachLevelAsItIsAlone) {
  Renderer renderer(context(), walker());
  const auto lods = make(walker(), kSpec);
  const auto& by_level = dynamic_cast<const MeshLods&>(*lods).drawn();
  const BakeInfo info = lods->bake_info();
  ASSERT_EQ(info.levels.size(), 2U);
  const std::vector<std::string> alone = {"mesh", "mesh:triangles=300", "mesh:triangles=120"};
  EXPECT_EQ(lods->components(), alone);
  for (size_t level = 0; level < alone.size(); ++level) {
    // At the middle of the distances at which it is to be drawn: a pixel is 2 tan(20 deg) / 240 of the distance.
    const double pixel = 2 * std::tan(20 * 3.14159265358979 / 180) / 240;
    const double from = level == 0 ? 0 : info.levels[level - 1].error.max / pixel;
    const double to = level == 2 ? 1.5 * from : info.levels[level].error.max / pixel;
    ASSERT_LT(from, to);
    const scene::Frame frame = frame_at((from + to) / 2);
    const Capture seen = renderer.capture(frame, *lods);
    EXPECT_EQ(seen, renderer.capture(frame, *make(walker(), alone[level]))) << "with ids and depth: " << alone[level];
    EXPECT_EQ(by_level[level], 2U) << alone[level];
    for (const AgentShares& agent : lods->shares(frame, all_agents(frame))) EXPECT_EQ(agent.shares[level], 1);
  }
}

TEST_F(MeshLodsGl, AllAreDrawnAndHeldOnesAsTheyAreHeld) {
  Renderer renderer(context(), walker());
  const auto lods = make(walker(), kSpec);
  scene::Frame frame = frame_of_one(3, 1.0, 240, 240);
  for (uint32_t i = 0; i < 6; ++i) add_agent(frame, walker(), {-0.8 + 0.3 * i, 0, -9.0 * i}, i + 1, 0.1 * i);
  const Capture seen = renderer.capture(frame, *lods);
  const auto& by_level = dynamic_cast<const MeshLods&>(*lods).drawn();
  EXPECT_GT(by_level[0], 0U);
  EXPECT_GT(by_level[2], 0U);
  EXPECT_EQ(by_level[0] + by_level[1] + by_level[2], 6U);
  std::vector<AgentShares> coarse;
  for (uint32_t id = 1; id <= 6; ++id) coarse.push_back({id, {0, 0, 1}});
  lods->hold(coarse);
  EXPECT_EQ(renderer.capture(frame, *lods), renderer.capture(frame, *make(walker(), "mesh:triangles=120")));
  EXPECT_EQ(lods->shares(frame, all_agents(frame)), coarse);
  lods->hold({});
  EXPECT_EQ(renderer.capture(frame, *lods), seen);
}

TEST_F(MeshLodsGl, ChoosesByThePicturesPixelsAndNotByTheSamples) {
  Renderer renderer(context(), walker());
  const auto lods = make(walker(), kSpec);
  const auto& by_level = dynamic_cast<const MeshLods&>(*lods).drawn();
  const double pixel = 2 * std::tan(20 * 3.14159265358979 / 180) / 240;
  scene::Frame frame = frame_at(1.2 * lods->bake_info().levels.at(1).error.max / pixel);
  renderer.draw(frame, *lods, Target(context(), 720, 720, {.ids = true}));
  EXPECT_EQ(by_level, (std::vector<size_t>{0, 0, 2})) << "three samples a side";
  frame.width = frame.height = 720;
  renderer.draw(frame, *lods, Target(context(), 720, 720, {.ids = true}));
  EXPECT_EQ(by_level[2], 0U) << "three times as large";
}

TEST_F(MeshLodsGl, SaysWhatItsLevelsCost) {
  const auto lods = make(walker(), "mesh:lods=300/120,pixels=2");
  const auto whole = make(walker(), "mesh");
  const auto fine = make(walker(), "mesh:triangles=300");
  const auto coarse = make(walker(), "mesh:triangles=120");
  const auto gpu = [](const auto& one) { return one->footprint().gpu_bytes(); };
  EXPECT_EQ(gpu(lods), gpu(whole) + gpu(fine) + gpu(coarse));
  EXPECT_EQ(lods->triangles(0), whole->triangles(0)) << "of a near agent";
  const BakeInfo info = lods->bake_info();
  EXPECT_EQ(fact(info.facts, "level1_triangles"), static_cast<double>(fine->triangles(0)));
  const LevelInfo& level = info.levels.at(1);
  EXPECT_EQ(level.error.max, coarse->bake_info().levels.at(0).error.max);
  EXPECT_NEAR(level.pixels(fact(info.facts, "level2_below_px")), 2, 1e-9)
      << "where it changes over it spans two pixels";
}

TEST_F(MeshLodsGl, IsRefusedBesideASingleLevelAndAsOne) {
  for (const char* spec : {"mesh:lods=300,triangles=100", "mesh:lods=300,pixels=0", "mesh:lods=x"})
    EXPECT_THROW(make(walker(), spec), Error) << spec;
  EXPECT_THROW(mesh_type.level(parse_spec(kSpec), walker().characters[0], walker().banks[0], {}), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
