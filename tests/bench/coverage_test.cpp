#include "bench/stage/coverage.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderers/frame/capture.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

TEST(Coverage, CountsPixelsAndAgentsByHand) {
  ImageU32 ids(4, 2, 1);
  ids.data = {0, 7, 7, 0, 1, 0, 7, 0};
  const scene::Coverage coverage = coverage_of(ids);
  EXPECT_EQ(coverage.covered_px, 4U);
  EXPECT_EQ(coverage.occupancy, 0.5);
  EXPECT_EQ(coverage.agents_visible, 2U);
  EXPECT_EQ(coverage_of(ImageU32{}).occupancy, 0.0);
}

class SolveWithMeshGl : public testing::Test {
 protected:
  static scene::Scenario scenario_of(uint32_t agents, double occupancy) {
    scene::Scenario s;
    s.width = 320;
    s.height = 240;
    s.crowd.agents = agents;
    s.occupancy = occupancy;
    s.characters[0].source = "mannequin:triangles=2200";
    return s;
  }
  // Solves, draws the result afresh and counts again.
  static void check(uint32_t agents, double target) {
    SCOPED_TRACE(fmt::format("{} agents, {}", agents, target));
    const scene::Scenario scenario = scenario_of(agents, target);
    const scene::Cast cast = scene::load_cast(scenario);
    gl::Context context;
    const scene::Solved solved = solve_with_mesh(context, scenario, cast);
    EXPECT_NEAR(solved.achieved, target, 0.003);
    EXPECT_FALSE(solved.unreachable);
    EXPECT_LE(solved.agents_off, agents / 20);
    EXPECT_EQ(solved.agents_wholly + solved.agents_partly + solved.agents_off, agents);
    renderers::Renderer renderer(context, cast);
    const auto mesh = renderers::make_representation({context, cast}, renderers::parse_spec("mesh"));
    const auto frame = scene::make_frame(solved.scenario, cast, solved.crowd, solved.camera, 0);
    const scene::Coverage again = coverage_of(renderer.capture(frame, *mesh).ids);
    EXPECT_EQ(again.occupancy, solved.achieved);
    EXPECT_EQ(again.covered_px, solved.touched_px);
  }
};

TEST_F(SolveWithMeshGl, ReachesBothOccupanciesWithAFewAgents) {
  check(10, 0.15);
  check(10, 0.9);
  check(100, 0.15);
}

TEST_F(SolveWithMeshGl, SearchesWithSimplifiedCharactersAndMeasuresWithTheMesh) { check(400, 0.15); }

TEST_F(SolveWithMeshGl, OnePersonCannotCoverNineTenths) {
  const scene::Scenario scenario = scenario_of(1, 0.9);
  const scene::Cast cast = scene::load_cast(scenario);
  gl::Context context;
  const scene::Solved solved = solve_with_mesh(context, scenario, cast);
  EXPECT_TRUE(solved.unreachable);
  EXPECT_GT(solved.achieved, 0.15);
}

}  // namespace
}  // namespace crowdbench::bench
