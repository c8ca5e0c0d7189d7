// How near FLIP's figures must come to those of the reference tool.
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "metrics/flip.h"

namespace crowdbench::metrics {

// Mean and quartiles within 2e-4, least and greatest within 1e-3: the contract of the expected values.
inline void expect_pooled(const FlipPooled& actual, const nlohmann::json& expected, const std::string& what,
                          double tolerance = 2e-4) {
  const auto either = [&](const char* a, const char* b) { return expected.value(a, expected.value(b, -1.0)); };
  EXPECT_NEAR(actual.mean, expected["mean"].get<double>(), tolerance) << what;
  EXPECT_NEAR(actual.weighted_median, expected["weighted_median"].get<double>(), tolerance) << what;
  EXPECT_NEAR(actual.q1, either("q1_weighted", "q1"), tolerance) << what;
  EXPECT_NEAR(actual.q3, either("q3_weighted", "q3"), tolerance) << what;
  EXPECT_NEAR(actual.min, expected["min"].get<double>(), 1e-3) << what;
  EXPECT_NEAR(actual.max, expected["max"].get<double>(), 1e-3) << what;
}

}  // namespace crowdbench::metrics
