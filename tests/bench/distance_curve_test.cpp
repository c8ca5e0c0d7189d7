#include "bench/experiments/distance_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/random.h"

namespace crowdbench::bench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

metrics::Score error_score() {
  metrics::Score score;
  score.name = "error";
  score.direction = metrics::Direction::lower_is_better;
  return score;
}

// One frame of each agent at distances 1, 2, 3, ...
std::vector<CurvePoint> points_of(const std::vector<double>& values) {
  std::vector<CurvePoint> out;
  for (size_t i = 0; i < values.size(); ++i)
    out.push_back({static_cast<uint32_t>(i + 1), static_cast<double>(i + 1), values[i]});
  return out;
}

// An error that falls from 100 by 1 a metre, with noise of at most `noise` on either side.
std::vector<CurvePoint> falling(size_t agents, double noise) {
  std::vector<CurvePoint> out = points_of(std::vector<double>(agents));
  for (CurvePoint& p : out) p.value = 100 - p.x + noise * (2 * random_unit(5, p.agent, 1) - 1);
  return out;
}

TEST(DistanceCurve, BinsHoldEquallyManyAndStateTheirMediansByHand) {
  const ScoreCurve curve = make_curve(points_of({9, 7, 8, 5, 6, 1, 2, 4, 3, 0}), 8, 1);
  ASSERT_EQ(curve.bins.size(), 2U) << "five agents a bin at least";
  EXPECT_EQ(curve.points, 10U);
  EXPECT_EQ(curve.agents, 10U);
  EXPECT_EQ(curve.bins[0].from, 1);
  EXPECT_EQ(curve.bins[0].to, 5);
  EXPECT_EQ(curve.bins[0].x, 3);
  EXPECT_EQ(curve.bins[0].value, 7);
  EXPECT_EQ(curve.bins[1].x, 8);
  EXPECT_EQ(curve.bins[1].value, 2);
  for (const CurveBin& bin : curve.bins) {
    EXPECT_EQ(bin.points, 5U);
    EXPECT_EQ(bin.agents, 5U);
    EXPECT_LE(bin.low, bin.value);
    EXPECT_GE(bin.high, bin.value);
    EXPECT_LT(bin.low, bin.high);
  }
  // Ranks 10 8 9 6 7 2 3 5 4 1 against 1..10: the squares of the differences sum to 308.
  EXPECT_NEAR(curve.rank_correlation.value(), 1 - 6 * 308.0 / 990, 1e-12);
  EXPECT_EQ(make_curve(points_of(std::vector<double>(20, 3.0)), 4, 1).rank_correlation, std::nullopt);
  EXPECT_TRUE(make_curve({}, 4, 1).bins.empty());
}

TEST(DistanceCurve, HeightsAreOrderedFromNearToFarToo) {
  std::vector<CurvePoint> points = falling(40, 0);
  const ScoreCurve by_distance = make_curve(points, 4, 1);
  for (CurvePoint& p : points) p.x = 500 / p.x;
  const ScoreCurve by_height = make_curve(points, 4, 1, true);
  ASSERT_EQ(by_height.bins.size(), 4U);
  EXPECT_GT(by_height.bins.front().x, by_height.bins.back().x);
  for (size_t b = 0; b < 4; ++b) EXPECT_EQ(by_height.bins[b].value, by_distance.bins[b].value);
  EXPECT_NEAR(by_height.rank_correlation.value(), -1, 1e-12);
  EXPECT_NEAR(by_distance.rank_correlation.value(), -1, 1e-12);
}

TEST(DistanceCurve, TheSamePointsInAnyOrderGiveTheSameBand) {
  std::vector<CurvePoint> points = falling(60, 20);
  const ScoreCurve first = make_curve(points, 2, 7);
  std::reverse(points.begin(), points.end());
  const ScoreCurve second = make_curve(points, 2, 7);
  EXPECT_EQ(first.resampled, second.resampled);
  for (size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(first.bins[b].low, second.bins[b].low);
    EXPECT_EQ(first.bins[b].high, second.bins[b].high);
  }
  EXPECT_NE(first.resampled, make_curve(points, 2, 8).resampled) << "another seed draws otherwise";
}

// The frames of one agent are not independent: many frames of few agents do not make a band narrow.
TEST(DistanceCurve, WholeAgentsAreDrawnAnew) {
  std::vector<CurvePoint> once = points_of({10, 20, 30, 40, 50, 60});
  for (CurvePoint& p : once) p.x = 5;
  std::vector<CurvePoint> often;
  std::vector<CurvePoint> as_others;
  for (const CurvePoint& p : once)
    for (uint32_t frame = 0; frame < 50; ++frame) {
      often.push_back(p);
      as_others.push_back({p.agent + 100 * frame, p.x, p.value});
    }
  const CurveBin few = make_curve(once, 1, 3).bins[0];
  const CurveBin many_frames = make_curve(often, 1, 3).bins[0];
  const CurveBin many_agents = make_curve(as_others, 1, 3).bins[0];
  EXPECT_EQ(many_frames.points, 300U);
  EXPECT_EQ(many_frames.agents, 6U);
  EXPECT_EQ(many_frames.low, few.low);
  EXPECT_EQ(many_frames.high, few.high);
  EXPECT_LT(many_agents.high - many_agents.low, many_frames.high - many_frames.low);
}

TEST(DistanceCurve, InfiniteValuesAreValues) {
  std::vector<double> values(20, kInfinity);
  for (size_t i = 0; i < 10; ++i) values[i] = 30;
  metrics::Score score;
  score.direction = metrics::Direction::higher_is_better;
  const ScoreCurve curve = make_curve(points_of(values), 2, 1);
  EXPECT_EQ(curve.bins[0].high, 30);
  EXPECT_EQ(curve.bins[1].low, kInfinity);
  EXPECT_EQ(curve.bins[1].value, kInfinity);
  const ThresholdPlace place = threshold_place(curve, score, 40);
  EXPECT_EQ(place.reached, Reached::from);
  EXPECT_EQ(place.at, curve.bins[1].x) << "nothing lies straight between a number and infinity";
}

TEST(DistanceThreshold, AKnownCrossingIsFoundWithinItsInterval) {
  const metrics::Score score = error_score();
  const ScoreCurve exact = make_curve(falling(100, 0), 10, 1);
  const ThresholdPlace without_noise = threshold_place(exact, score, 60);
  EXPECT_EQ(without_noise.reached, Reached::from);
  EXPECT_NEAR(without_noise.at.value(), 40, 1e-9);
  const ThresholdPlace noisy = threshold_place(make_curve(falling(100, 8), 10, 1), score, 60);
  EXPECT_EQ(noisy.reached, Reached::from);
  EXPECT_NEAR(noisy.at.value(), 40, 8);
  EXPECT_LE(noisy.low.value(), 40);
  EXPECT_GE(noisy.high.value(), 40);
  EXPECT_LT(*noisy.low, *noisy.high);
  // A score that is better high, against heights that fall.
  metrics::Score likeness;
  likeness.direction = metrics::Direction::higher_is_better;
  std::vector<CurvePoint> points = falling(100, 0);
  for (CurvePoint& p : points) p = {p.agent, 1000 - p.x, -p.value};
  const ThresholdPlace by_height = threshold_place(make_curve(points, 10, 1, true), likeness, -60);
  EXPECT_EQ(by_height.reached, Reached::from);
  EXPECT_NEAR(by_height.at.value(), 960, 1e-9);
  EXPECT_GT(by_height.low.value(), by_height.high.value()) << "the nearer end is the taller one";
}

TEST(DistanceThreshold, SaysWhereItIsNotReachedAndWhereItAlwaysIs) {
  const metrics::Score score = error_score();
  const ScoreCurve curve = make_curve(falling(100, 8), 10, 1);
  const ThresholdPlace never = threshold_place(curve, score, -50);
  EXPECT_EQ(never.reached, Reached::never);
  EXPECT_FALSE(never.at || never.low || never.high);
  const ThresholdPlace everywhere = threshold_place(curve, score, 150);
  EXPECT_EQ(everywhere.reached, Reached::everywhere);
  EXPECT_FALSE(everywhere.at || everywhere.low || everywhere.high);
  // Good in the middle and bad again at the end is not reached.
  std::vector<double> values(50, 10.0);
  std::fill(values.begin() + 20, values.begin() + 30, 1.0);
  EXPECT_EQ(threshold_place(make_curve(points_of(values), 5, 1), score, 2).reached, Reached::never);
}

TEST(DistanceThreshold, WhatTheIntervalDoesNotCarryIsNotDistinguishable) {
  const metrics::Score score = error_score();
  // Half of the farthest agents are good and half are bad: medians fall on either side.
  std::vector<double> values(60, 10.0);
  for (size_t i = 30; i < 60; ++i) values[i] = i % 2 == 0 ? 0.0 : 4.1;
  const ThresholdPlace place = threshold_place(make_curve(points_of(values), 2, 1), score, 2.1);
  EXPECT_EQ(place.reached, Reached::not_distinguishable);
  EXPECT_TRUE(place.at.has_value()) << "the medians alone would have said so";
  EXPECT_FALSE(place.high.has_value());
  // So few agents say nothing, whatever they score.
  EXPECT_EQ(threshold_place(make_curve(points_of({1, 1, 1, 1}), 2, 1), score, 5).reached, Reached::not_distinguishable);
  EXPECT_EQ(threshold_place(make_curve(points_of({1, 1, 1, 1, 1}), 2, 1), score, 5).reached, Reached::everywhere);
  EXPECT_EQ(threshold_place(make_curve({}, 2, 1), score, 5).reached, Reached::not_distinguishable);
  EXPECT_EQ(std::string(reached_name(Reached::not_distinguishable)), "not_distinguishable");
}

}  // namespace
}  // namespace crowdbench::bench
