#include "scene/crowd/occupancy.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pillar_cast.h"
#include "scene/cast/cast.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::scene {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// An oracle without OpenGL: every agent is an upright card of 0.5 x 1.75 m that faces the eye, painted into a bitmap.
Coverage cards(const Frame& frame) {
  std::vector<bool> covered(static_cast<size_t>(kWidth) * kHeight);
  const glm::dmat3 rotation = view_rotation(frame.camera);
  const glm::dmat4 project = projection(frame.camera, static_cast<double>(frame.width) / frame.height);
  for (const auto& kind : frame.agents)
    for (const FrameAgent& agent : kind) {
      glm::dvec2 low{1e9};
      glm::dvec2 high{-1e9};
      bool behind = false;
      for (const double y : {0.0, 1.75 * agent.scale}) {
        const glm::dvec3 q = rotation * (glm::dvec3(agent.position) + glm::dvec3(0.0, y, 0.0));
        behind = behind || -q.z < frame.camera.near;
        for (const double x : {-0.25, 0.25}) {
          const glm::dvec4 clip = project * glm::dvec4(q + glm::dvec3(x, 0.0, 0.0), 1.0);
          const glm::dvec2 pixel{(clip.x / clip.w + 1) / 2 * kWidth, (1 - clip.y / clip.w) / 2 * kHeight};
          low = glm::min(low, pixel);
          high = glm::max(high, pixel);
        }
      }
      if (behind) continue;
      for (int y = std::max(0, static_cast<int>(std::ceil(low.y - 0.5))); y < std::min<double>(kHeight, high.y - 0.5);
           ++y)
        for (int x = std::max(0, static_cast<int>(std::ceil(low.x - 0.5))); x < std::min<double>(kWidth, high.x - 0.5);
             ++x)
          covered[static_cast<size_t>(y) * kWidth + static_cast<size_t>(x)] = true;
    }
  Coverage coverage;
  coverage.covered_px = static_cast<uint64_t>(std::count(covered.begin(), covered.end(), true));
  coverage.occupancy = static_cast<double>(coverage.covered_px) / (kWidth * kHeight);
  return coverage;
}

Scenario scenario_of(uint32_t agents, double occupancy) {
  Scenario s;
  s.width = kWidth;
  s.height = kHeight;
  s.crowd.agents = agents;
  s.occupancy = occupancy;
  return s;
}

TEST(Occupancy, FindsItsTargetInFewMeasurementsWithEverybodyOnScreen) {
  const Cast cast = pillar_cast();
  for (const uint32_t agents : {10U, 100U, 250U, 1000U, 5000U})
    for (const double target : {0.05, 0.15, 0.5, 0.9}) {
      SCOPED_TRACE(fmt::format("{} agents, {}", agents, target));
      int measured = 0;
      const Solved solved = solve_occupancy(scenario_of(agents, target), cast, [&](const Frame& frame) {
        ++measured;
        return cards(frame);
      });
      EXPECT_NEAR(solved.search.achieved, target, 0.003);
      EXPECT_FALSE(solved.search.unreachable);
      EXPECT_EQ(solved.search.requested, target);
      EXPECT_EQ(solved.search.measurements, measured);
      EXPECT_LE(measured, 12);
      const OnScreen seen = count_on_screen(solved.scenario, cast, solved.crowd, solved.camera, 0);
      EXPECT_EQ(seen.wholly + seen.partly + seen.off, agents);
      EXPECT_LE(seen.off, agents / 20);
      // What is returned is what was measured.
      const Frame frame = make_frame(solved.scenario, cast, solved.crowd, solved.camera, 0);
      EXPECT_EQ(cards(frame).occupancy, solved.search.achieved);
      if (solved.scenario.crowd.stage == Stage::view) {
        EXPECT_GE(solved.scenario.crowd.spacing, 0.7);
      }
    }
}

TEST(Occupancy, ASolvedScenarioIsWholeAfterItsText) {
  const Cast cast = pillar_cast();
  for (const double target : {0.15, 0.95}) {
    const Solved solved = solve_occupancy(scenario_of(50, target), cast, cards);
    const Scenario back = parse_scenario(to_toml(solved.scenario), "solved");
    EXPECT_EQ(back, solved.scenario);
    const Crowd crowd = make_crowd(back, cast, stage_view(back));
    EXPECT_EQ(crowd.x, solved.crowd.x);
    EXPECT_EQ(crowd.z, solved.crowd.z);
    EXPECT_EQ(cards(make_frame(back, cast, crowd, back.camera.at(0), 0)).occupancy, solved.search.achieved);
  }
}

TEST(Occupancy, SparseAndDenseCrowdsStandAtTheirSpacingAndOnlyThenInterpenetrate) {
  const Cast cast = pillar_cast();
  EXPECT_EQ(solve_occupancy(scenario_of(100, 0.15), cast, cards).scenario.crowd.stage, Stage::view);
  EXPECT_EQ(solve_occupancy(scenario_of(10, 0.97), cast, cards).scenario.crowd.stage, Stage::frustum);
}

TEST(Occupancy, SaysWhatOnePersonCannotCover) {
  const Solved solved = solve_occupancy(scenario_of(1, 0.9), pillar_cast(), cards);
  EXPECT_TRUE(solved.search.unreachable);
  EXPECT_GT(solved.search.achieved, 0.2);  // the nearest that it reached
  EXPECT_LT(solved.search.achieved, 0.89);
  const Solved small = solve_occupancy(scenario_of(1, 0.05), pillar_cast(), cards);
  EXPECT_FALSE(small.search.unreachable);
  EXPECT_EQ(count_on_screen(small.scenario, pillar_cast(), small.crowd, small.camera, 0).wholly, 1U);
}

TEST(Occupancy, AStandInThatIsOffStillLeadsToTheTarget) {
  const Cast cast = pillar_cast();
  for (const double target : {0.15, 0.9})
    for (const double bias : {0.85, 1.1}) {  // of the number of layers, as a thinner body has
      int drafts = 0;
      int measured = 0;
      const Solved solved = solve_occupancy(
          scenario_of(1000, target), cast,
          [&](const Frame& frame) {
            ++measured;
            return cards(frame);
          },
          [&](const Frame& frame) {
            ++drafts;
            Coverage coverage = cards(frame);
            coverage.occupancy = 1.0 - std::pow(1.0 - coverage.occupancy, bias);
            return coverage;
          });
      EXPECT_NEAR(solved.search.achieved, target, 0.005) << bias;
      EXPECT_EQ(solved.search.achieved,
                cards(make_frame(solved.scenario, cast, solved.crowd, solved.camera, 0)).occupancy);
      EXPECT_EQ(solved.search.measurements, measured);
      EXPECT_EQ(solved.search.drafts, drafts);
      EXPECT_LE(measured, 3);
      EXPECT_FALSE(solved.search.unreachable);
    }
}

TEST(Occupancy, AStandInThatMisleadsIsLeft) {
  const Solved solved = solve_occupancy(scenario_of(1000, 0.9), pillar_cast(), cards, [](const Frame& frame) {
    Coverage coverage = cards(frame);
    coverage.occupancy *= 0.8;  // can never show 90 %
    return coverage;
  });
  EXPECT_NEAR(solved.search.achieved, 0.9, 0.003);
}

TEST(Occupancy, IsDeterministic) {
  const Cast cast = pillar_cast();
  const Solved a = solve_occupancy(scenario_of(100, 0.3), cast, cards);
  const Solved b = solve_occupancy(scenario_of(100, 0.3), cast, cards);
  EXPECT_EQ(a.scenario, b.scenario);
  EXPECT_EQ(a.crowd.x, b.crowd.x);
}

TEST(Occupancy, KeepsDirectionLensAndEverythingElse) {
  Scenario s = scenario_of(100, 0.15);
  s.camera.keys[0].camera.eye = {1e6 + 20.0, 25.0, 0.0};
  s.camera.keys[0].camera.target = {1e6, 0.0, 0.0};
  s.camera.keys[0].camera.fov_y = 0.6;
  s.crowd.centre = {1e6, 5.0, 0.0};
  s.crowd.heading_deg = 45;
  const Solved solved = solve_occupancy(s, pillar_cast(), cards);
  EXPECT_NEAR(solved.search.achieved, 0.15, 0.003);
  const glm::dvec3 towards = glm::normalize(solved.camera.target - solved.camera.eye);
  EXPECT_NEAR(towards.x, -20.0 / std::hypot(20.0, 25.0), 1e-9);
  EXPECT_NEAR(towards.y, -25.0 / std::hypot(20.0, 25.0), 1e-9);
  EXPECT_EQ(solved.camera.fov_y, 0.6);
  EXPECT_EQ(solved.scenario.crowd.heading_deg, 45);
  EXPECT_EQ(solved.scenario.occupancy, 0.15);
}

TEST(Occupancy, ACrowdInLanesIsSolvedToo) {
  Scenario s = scenario_of(200, 0.15);
  s.crowd.motion = MotionKind::lanes;
  const Solved solved = solve_occupancy(s, pillar_cast(), cards);
  EXPECT_EQ(solved.scenario.crowd.stage, Stage::plaza);
  EXPECT_NEAR(solved.search.achieved, 0.15, 0.01);
}

TEST(Occupancy, CountsWhoIsWholePartlyAndNotOnScreen) {
  // Three pillars by hand: in the middle, across the right edge, behind the eye.
  const Cast cast = pillar_cast();
  Scenario s = scenario_of(3, 0.5);
  s.camera.keys[0].camera = Camera{{0.0, 0.9, 10.0}, {0.0, 0.9, 0.0}, {0.0, 1.0, 0.0}, 0.6};
  Crowd crowd = make_crowd(s, cast, stage_view(s));
  const double edge = 10.0 * std::tan(0.3) * 4 / 3;
  crowd.x = {0.0, edge, 0.0};
  crowd.z = {0.0, 0.0, 20.0};
  const OnScreen seen = count_on_screen(s, cast, crowd, s.camera.at(0), 0);
  EXPECT_EQ(seen.wholly, 1U);
  EXPECT_EQ(seen.partly, 1U);
  EXPECT_EQ(seen.off, 1U);
}

}  // namespace
}  // namespace crowdbench::scene
