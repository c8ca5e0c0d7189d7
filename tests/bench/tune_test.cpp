// Tune: what it measures of a small character, and what it makes of it.
#include "bench/experiments/tune.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::bench {
namespace {

TuneRequest request_of(const char* score, double value) {
  TuneRequest request;
  request.character = std::make_shared<const scene::Character>(scene::make_mannequin({.triangles = 500}));
  request.candidates = {renderers::reference_spec(), renderers::parse_spec("mesh:triangles=100")};
  request.heights_px = {60, 24, 10};
  request.agents = {1, 2, 30};
  request.azimuths_deg = {0, 90};
  request.elevations_deg = {10};
  request.clip = request.character->placement.default_clip;
  for (const metrics::Score* one : metrics::scores())
    if (one->name == score) request.error = request.pop = {one, value};
  request.cost.width = 160;
  request.cost.height = 120;
  request.cost.rounds = 4;
  request.cost_heights = 2;
  return request;
}

class TuneGl : public ::testing::Test {
 protected:
  gl::Context context_;
};

TEST_F(TuneGl, WhatMayErrIsDrawnByTheCheaperOneAndWhatMayNotByTheReference) {
  const TuneRequest lax = request_of("mae", 255);
  const TuneResult all = tune(context_, lax);
  ASSERT_TRUE(all.plan);
  ASSERT_EQ(all.errors.size(), 2U);
  for (size_t bin = 0; bin < 3; ++bin) {
    EXPECT_EQ(all.errors[0][bin].tail, 0) << "the reference against itself";
    EXPECT_GT(all.errors[1][bin].tail, 0);
    EXPECT_GE(all.errors[1][bin].interval.high, all.errors[1][bin].tail);
    EXPECT_LE(all.errors[1][bin].interval.low, all.errors[1][bin].tail);
    EXPECT_EQ(all.errors[1][bin].values.size(), 4U) << "two directions, two moments";
    const auto& cost = all.table.cost;
    EXPECT_EQ(all.plan->candidate[bin], cost[1][bin] < cost[0][bin] ? 1U : 0U) << bin;
  }

  const TuneResult none = tune(context_, request_of("mae", 0));
  ASSERT_TRUE(none.plan);
  EXPECT_EQ(none.plan->candidate, (std::vector<size_t>{0, 0, 0}));
  EXPECT_EQ(none.saving.low, 1);
  EXPECT_EQ(none.saving.high, 1);
  EXPECT_EQ(tuned_representation(lax, none).text(), renderers::reference_spec().text());
}

TEST_F(TuneGl, AThresholdBetweenTheErrorsOfTwoHeightsSwitchesThere) {
  TuneRequest request = request_of("mae", 255);
  const TuneResult errors = tune(context_, request);
  // Errors over the whole crop grow or fall with the height; whichever it is, one height of the two is allowed.
  const double near = errors.errors[1][0].interval.high;
  const double far = errors.errors[1][2].interval.high;
  ASSERT_NE(near, far);
  request.error.value = 0.5 * (near + far);
  request.pop.value = 255;
  const TuneResult result = tune(context_, request);
  ASSERT_TRUE(result.plan);
  EXPECT_EQ(result.errors[1][0].allowed, near < far);
  EXPECT_EQ(result.errors[1][2].allowed, far < near);
  // A pop of nothing forbids the change where the pictures differ.
  request.pop.value = 0;
  const TuneResult still = tune(context_, request);
  ASSERT_TRUE(still.plan);
  EXPECT_TRUE(still.switches.empty());
}

TEST(TunedRepresentation, NestsSwitchesByHeight) {
  TuneRequest request = request_of("mae", 1);
  request.candidates.push_back(renderers::parse_spec("rigid"));
  request.fade = 4;
  TuneResult result;
  result.plan = SwitchPlan{{0, 1, 2}, 0, 0};
  result.switches = {{.change = {0, 1, 1}, .height_px = 24},
                     {.change = {1, 2, 2}, .height_px = 10, .hysteresis = 0.25}};
  const renderers::Spec spec = tuned_representation(request, result);
  EXPECT_EQ(spec.text(),
            renderers::parse_spec("hybrid(mesh,hybrid((mesh:triangles=100),rigid,height=10,hysteresis=0.25,fade=4),"
                                  "height=24,fade=4)")
                .text());
}

TEST(TunedRepresentation, EnginesUnitsComeBackAsTheSameHeight) {
  const double fov = 35 * std::numbers::pi / 180;
  const glm::dvec3 bounds(0.8, 1.8, 0.6);
  for (const double height_px : {8.0, 60.0, 300.0}) {
    const double depth = depth_of_height(1.75, height_px, 720, fov);
    const EngineSizes sizes = engine_sizes(bounds, depth, fov, 16.0 / 9);
    const auto height_at = [&](double distance) { return 1.75 * 720 / (distance * 2 * std::tan(fov / 2)); };
    EXPECT_NEAR(height_at(sizes.godot_metres), height_px, 1e-9);
    EXPECT_NEAR(height_at(1.8 / (sizes.unity_height * 2 * std::tan(fov / 2))), height_px, 1e-9);
    const double radius = glm::length(bounds) / 2;
    const double widest = 1 / std::tan(fov / 2);  // P11; P00 is less in a picture wider than tall
    EXPECT_NEAR(height_at(widest * radius / sizes.unreal_size), height_px, 1e-9);
  }
}

TEST(SwitchCost, IsStraightInLogarithmsBetweenHeightsAndConstantBeyond) {
  std::vector<AgentCost> costs(2);
  costs[0].ns = 400;
  costs[1].ns = 100;
  const std::vector<double> at = costs_at({80, 20}, costs, {160, 80, 40, 20, 10});
  EXPECT_EQ(at[0], 400);
  EXPECT_EQ(at[1], 400);
  EXPECT_NEAR(at[2], 200, 1e-9);
  EXPECT_NEAR(at[3], 100, 1e-9);
  EXPECT_EQ(at[4], 100);
}

}  // namespace
}  // namespace crowdbench::bench
