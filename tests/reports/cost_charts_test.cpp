// Charts of costs where there is nothing to show, or little.
#include "reports/charts/cost_charts.h"

#include <gtest/gtest.h>

#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

TEST(CostCharts, WhatWasNotMeasuredIsNoChart) {
  const Scene scene;
  EXPECT_EQ(prediction_chart(scene, {}), "");
  EXPECT_EQ(cheapest_chart(scene, {}), "");
  EXPECT_EQ(front_chart(scene, {}), "");
  EXPECT_TRUE(sampled_rows(scene, 0.15).empty());
  EXPECT_EQ(samples_chart(scene, {}), "");
  EXPECT_EQ(histogram_chart(scene, {}), "");
}

}  // namespace
}  // namespace crowdbench::reports
