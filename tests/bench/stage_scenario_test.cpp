// One scenario stands at one camera, whoever asks.
#include "bench/stage/stage_scenario.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "bench/stage/cast_name.h"
#include "bench/stage/coverage.h"
#include "bench/stage/low_polygon.h"
#include "bench/stage/stage_facts.h"
#include "core/files.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/load_cast.h"
#include "test_paths.h"

namespace crowdbench::bench {
namespace {

scene::Scenario scenario_of(uint32_t agents, double occupancy) {
  scene::Scenario s;
  s.width = 320;
  s.height = 240;
  s.crowd.agents = agents;
  s.occupancy = occupancy;
  s.characters[0].source = "mannequin:triangles=2200";
  return s;
}

class StageScenarioGl : public testing::Test {
 protected:
  // Stages, draws the result afresh and counts again.
  Staged check(uint32_t agents, double target) {
    SCOPED_TRACE(fmt::format("{} agents, {}", agents, target));
    const scene::Scenario scenario = scenario_of(agents, target);
    const scene::Cast cast = scene::load_cast(scenario);
    Staged staged = stage_scenario(scenario, cast, context_);
    EXPECT_EQ(staged.scenario.camera.at(0), staged.camera);
    EXPECT_EQ(staged.scenario.camera.at(1e3), staged.camera);
    EXPECT_EQ(staged.solved->requested, target);
    EXPECT_NEAR(staged.solved->achieved, target, 0.003);
    EXPECT_FALSE(staged.solved->unreachable);
    const StageFacts facts = measure_stage(staged, cast, context_);
    EXPECT_EQ(facts.coverage.occupancy, staged.solved->achieved);
    EXPECT_FALSE(facts.unreachable);
    EXPECT_LE(facts.on_screen.off, agents / 20);
    EXPECT_EQ(facts.on_screen.wholly + facts.on_screen.partly + facts.on_screen.off, agents);
    renderers::Renderer renderer(context_, cast);
    const auto mesh = renderers::make_representation({context_, cast}, renderers::parse_spec("mesh"));
    const auto frame = scene::make_frame(staged.scenario, cast, staged.crowd, staged.camera, 0);
    const scene::Coverage again = coverage_of(renderer.capture(frame, *mesh).ids);
    EXPECT_EQ(again.occupancy, staged.solved->achieved);
    return staged;
  }
  gl::Context context_;
};

TEST_F(StageScenarioGl, ReachesBothOccupanciesWithAFewAgents) {
  EXPECT_EQ(check(10, 0.15).solved->drafts, 0) << "a few are searched with as they are";
  check(10, 0.9);
  check(100, 0.15);
}

TEST_F(StageScenarioGl, SearchesWithSimplifiedCharactersAndMeasuresWithTheMesh) {
  const Staged staged = check(400, 0.15);
  EXPECT_GT(staged.solved->drafts, 0);
  EXPECT_LE(staged.solved->measurements, 3);
}

TEST_F(StageScenarioGl, OnePersonCannotCoverNineTenths) {
  const scene::Scenario scenario = scenario_of(1, 0.9);
  const scene::Cast cast = scene::load_cast(scenario);
  const Staged staged = stage_scenario(scenario, cast, context_);
  EXPECT_TRUE(staged.solved->unreachable);
  EXPECT_GT(staged.solved->achieved, 0.15);
  EXPECT_TRUE(measure_stage(staged, cast, context_).unreachable);
}

// The grid that `view` and `pair` lay on the ground hides soles and toes; it must not move the camera.
TEST_F(StageScenarioGl, NeitherGroundNorRepresentationMovesTheCamera) {
  scene::Scenario scenario = scenario_of(30, 0.3);
  scenario.camera.keys[0].camera.eye = {0, 0.6, 9};
  const scene::Cast cast = scene::load_cast(scenario);
  const Staged bare = stage_scenario(scenario, cast, context_);
  scenario.ground = true;
  scenario.representation = "flat";
  const Staged on_ground = stage_scenario(scenario, cast, context_);
  EXPECT_EQ(on_ground.camera, bare.camera);
  EXPECT_EQ(on_ground.crowd.x, bare.crowd.x);
  EXPECT_EQ(on_ground.solved->achieved, bare.solved->achieved);
  EXPECT_EQ(measure_stage(on_ground, cast, context_).touched_px, measure_stage(bare, cast, context_).touched_px);
  EXPECT_TRUE(on_ground.scenario.ground) << "it is drawn all the same";
}

// Without an occupancy the scenario is staged as it stands, its path kept.
TEST_F(StageScenarioGl, WithoutAnOccupancyNothingMoves) {
  scene::Scenario scenario = scenario_of(20, 0.5);
  scenario.occupancy.reset();
  scenario.camera.keys.push_back({2.0, scene::Camera{{5, 2, 5}, {0, 1, 0}}});
  const scene::Cast cast = scene::load_cast(scenario);
  const Staged staged = stage_scenario(scenario, cast, context_);
  EXPECT_EQ(staged.scenario, scenario);
  EXPECT_EQ(staged.camera, scenario.camera.keys[0].camera);
  EXPECT_FALSE(staged.solved.has_value());
  const StageFacts facts = measure_stage(staged, cast, context_);
  EXPECT_FALSE(facts.unreachable);
  EXPECT_GT(facts.coverage.covered_px, 100U);
  // A mesh discards nothing and no ground is drawn: a pixel is touched when an agent covers it. The figures come from
  // two draws, one that counts ids and one that counts depths.
  EXPECT_EQ(facts.touched_px, facts.coverage.covered_px);
}

// Whoever makes a crowd or solves an occupancy by itself shows another one sooner or later. A half of a stimulus has
// nothing to solve: plans of studies refuse `occupancy`. Cases of the stability battery (sizes, time, world) stand
// crowds where no scenario would.
TEST(StageScenario, NobodyElseInTheDriverMakesACrowd) {
  namespace fs = std::filesystem;
  static const std::regex makes(R"(\b(make_crowd|solve_occupancy)\s*\()");
  std::set<std::string> found;
  for (const char* room : {"bench", "studies"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(CROWDBENCH_SOURCE_DIR) / room)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
      if (std::regex_search(read_text(entry.path()), makes)) found.insert(entry.path().filename().string());
    }
  EXPECT_EQ(found,
            (std::set<std::string>{"crowd_clip.cpp", "sizes.cpp", "stage_scenario.cpp", "time.cpp", "world.cpp"}));
}

TEST(CastName, JoinsTheCharactersNames) {
  const auto named = [](std::string name) {
    scene::Character character;
    character.name = std::move(name);
    return std::make_shared<const scene::Character>(std::move(character));
  };
  scene::Cast cast;
  EXPECT_EQ(cast_name(cast), "");
  cast.characters = {named("mannequin")};
  EXPECT_EQ(cast_name(cast), "mannequin");
  cast.characters = {named("a.glb"), named("b.glb"), named("a.glb")};
  EXPECT_EQ(cast_name(cast), "a.glb + b.glb + a.glb");
}

TEST(LowPolygon, IsTheReferenceWith500TrianglesAndASpecOfItsOwn) {
  const renderers::Spec spec = low_polygon_spec();
  EXPECT_EQ(spec.name, renderers::reference_spec().name);
  EXPECT_EQ(spec.text(), renderers::parse_spec(renderers::reference_spec().text() + ":triangles=500").text());
  EXPECT_NE(spec.text(), renderers::reference_spec().text()) << "both are drawn in one run";
}

}  // namespace
}  // namespace crowdbench::bench
