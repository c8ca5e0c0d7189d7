#include "bench/experiments/point_rows.h"

#include <gtest/gtest.h>

#include "bench/experiments/point_name.h"

namespace crowdbench::bench {
namespace {

VariantTimes times_of(int64_t cpu_ns, int64_t wall_ns, std::optional<int64_t> gpu_ns = std::nullopt) {
  VariantTimes times;
  for (int round = 0; round < 20; ++round) times.samples.push_back({round, 0, wall_ns, cpu_ns, 0, gpu_ns});
  return times;
}
const PointKey kPoint{"flat", "mannequin", 250, 640, 480, 0.15};

TEST(RatioRows, SpeedIsTheReferencesTimeOverOnesOwnAndFloorOnesOwnOverTheFloors) {
  const VariantTimes flat = times_of(10, 20);
  const VariantTimes mesh = times_of(80, 50);
  const VariantTimes floor = times_of(4, 16);
  const std::vector<RatioRow> rows = ratio_rows(7, kPoint, flat, "mesh", &mesh, &floor);
  ASSERT_EQ(rows.size(), 4U);
  const struct {
    const char* kind;
    const char* to;
    const char* metric;
    double ratio;
  } wanted[] = {{"speed", "mesh", "cpu", 8.0},
                {"floor", "floor=1", "cpu", 2.5},
                {"speed", "mesh", "wall", 2.5},
                {"floor", "floor=1", "wall", 1.25}};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rows[i].run, 7);
    EXPECT_EQ(rows[i].of, kPoint);
    EXPECT_EQ(rows[i].kind, wanted[i].kind);
    EXPECT_EQ(rows[i].to, wanted[i].to);
    EXPECT_EQ(rows[i].metric, wanted[i].metric);
    EXPECT_DOUBLE_EQ(rows[i].ratio, wanted[i].ratio);
    EXPECT_DOUBLE_EQ(rows[i].low, wanted[i].ratio);
    EXPECT_DOUBLE_EQ(rows[i].high, wanted[i].ratio);
    EXPECT_EQ(rows[i].pairs, 20);
  }
}

TEST(RatioRows, WhatWasNotTimedHasNone) {
  const VariantTimes flat = times_of(10, 20, 5);
  const VariantTimes mesh = times_of(80, 50, 15);
  VariantTimes dropped;
  dropped.dropped = true;
  EXPECT_TRUE(ratio_rows(1, kPoint, flat, "mesh", nullptr, nullptr).empty());
  EXPECT_TRUE(ratio_rows(1, kPoint, flat, "mesh", &dropped, &dropped).empty());
  // With a GPU timer a third metric.
  const std::vector<RatioRow> rows = ratio_rows(1, kPoint, flat, "mesh", &mesh, nullptr);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[2].metric, "gpu");
  EXPECT_DOUBLE_EQ(rows[2].ratio, 3.0);
}

TEST(PutStage, AchievedIsTheStagesAndEachCountHasItsPlace) {
  StageFacts facts;
  facts.coverage.occupancy = 0.151;
  facts.on_screen = {5, 3, 1};
  MeasurementRow row;
  put_stage(row, facts);
  EXPECT_EQ(row.achieved_occupancy, 0.151);
  EXPECT_EQ(row.agents_wholly, 5U);
  EXPECT_EQ(row.agents_partly, 3U);
  EXPECT_EQ(row.agents_off, 1U);
}

TEST(PointName, SaysAgentsAndView) {
  EXPECT_EQ(agents_text(1), "1 agent");
  EXPECT_EQ(agents_text(0), "0 agents");
  EXPECT_EQ(percent_text(0.125), "12.5 %");
  EXPECT_EQ(view_name(0.9), "90 %");
  EXPECT_EQ(view_name(0), "the scenario's camera");
}

}  // namespace
}  // namespace crowdbench::bench
