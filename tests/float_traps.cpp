// Tests that draw nothing run under FloatTraps. Those that draw do not: drivers divide as they like.
#include "core/float_traps.h"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>

namespace {

class Traps : public ::testing::EmptyTestEventListener {
  void OnTestStart(const ::testing::TestInfo& test) override {
    const std::string_view suite = test.test_suite_name();
    if (!suite.ends_with("Gl") && !suite.ends_with("Window")) traps_.emplace();
  }
  void OnTestEnd(const ::testing::TestInfo& /*test*/) override { traps_.reset(); }
  std::optional<crowdbench::FloatTraps> traps_;
};

[[maybe_unused]] const bool listens = [] {
  if (crowdbench::float_traps_work()) ::testing::UnitTest::GetInstance()->listeners().Append(new Traps);
  return true;
}();

}  // namespace
