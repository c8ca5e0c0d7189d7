// Whoever waits for a bake is told how far it has come: often, never backwards, to the end; and may stop it.
#include "renderers/bake/bake_progress.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/progress.h"
#include "gl_test_support.h"
#include "renderers/relief/relief_tiers.h"
#include "renderers/surfel/surfel_cloud.h"
#include "scene/cast/cast.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::walker;

struct Told {
  std::vector<size_t> done;
  size_t total = 0;
  BakeProgress progress() {
    return [this](size_t now, size_t of) {
      done.push_back(now);
      EXPECT_TRUE(total == 0 || total == of) << "another total: " << of;
      total = of;
    };
  }
  // Calls that went on from the one before.
  size_t advances() const {
    size_t count = 0;
    for (size_t i = 1; i < done.size(); ++i) count += done[i] > done[i - 1] ? 1 : 0;
    return count;
  }
  size_t longest_leap() const {
    size_t most = 0;
    for (size_t i = 1; i < done.size(); ++i) most = std::max(most, done[i] - std::min(done[i], done[i - 1]));
    return most;
  }
};

TEST(BakeSteps, EachHasTheShareOfItsWeight) {
  Told told;
  BakeSteps steps(told.progress(), {1, 0, 3});
  steps.of(0)(1, 2);
  steps.of(1)(5, 5);
  steps.of(2)(1, 3);
  steps.of(2)(2, 3);
  steps.of(0)(2, 2);  // too late
  steps.end();
  EXPECT_EQ(told.done, (std::vector<size_t>{0, 125, 250, 500, 750, 750, 1000}));
  EXPECT_EQ(told.total, BakeSteps::kTotal);
}

TEST(BakeSteps, NobodyNeedsToListenAndNothingNeedsAWeight) {
  BakeSteps silent({}, {1});
  silent.of(0)(1, 1);
  Told told;
  BakeSteps none(told.progress(), {0, 0});
  none.of(1)(1, 2);
  EXPECT_EQ(told.done.back(), 750U) << "half of the second of two that are alike";
  none.end();
  EXPECT_EQ(told.done.back(), BakeSteps::kTotal);
}

// Cells of skin, maps, farther tiers, cones: none of these steps is silent.
TEST(BakeProgressCalls, ReliefTellsOfAllItsSteps) {
  CROWDBENCH_SKIP_SANITIZED("ReliefStopsWhenItIsToldTo");
  ReliefTierOptions options;
  options.maps.map_size = 32;
  options.maps.by_area = false;
  options.capture = "best";
  options.resolution = "none";
  options.cones = true;
  options.merge = 0.25;
  options.bend = 1;
  options.part = 0.27;
  Told told;
  bake_tiers(*walker().characters[0], *walker().banks[0], options, {uint64_t{1} << 30, uint64_t{1} << 30},
             told.progress());
  EXPECT_EQ(told.done.front(), 0U);
  EXPECT_EQ(told.done.back(), told.total);
  EXPECT_TRUE(std::is_sorted(told.done.begin(), told.done.end()));
  EXPECT_GT(told.advances(), 60U);
  EXPECT_LT(told.longest_leap(), told.total / 4);
}

TEST(BakeProgressCalls, ReliefStopsWhenItIsToldTo) {
  ReliefTierOptions options;
  options.maps.map_size = 16;
  options.capture = "bind";
  options.resolution = "none";
  options.bend = 1;
  options.cells = 32;
  for (const size_t last : {0U, 300U, 700U}) {
    size_t reached = 0;
    const auto stop = [&](size_t done, size_t) {
      reached = done;
      if (done >= last) throw Interrupted{};
    };
    EXPECT_THROW(
        bake_tiers(*walker().characters[0], *walker().banks[0], options, {uint64_t{1} << 30, uint64_t{1} << 30}, stop),
        Interrupted);
    EXPECT_GE(reached, last);
    EXPECT_LT(reached, BakeSteps::kTotal) << "it went on to the end";
  }
}

TEST(BakeProgressCalls, SurfelsTellOfTheirOrder) {
  Told told;
  make_surfel_cloud(*walker().characters[0], *walker().banks[0], 4096, 1.5, told.progress());
  ASSERT_GE(told.done.size(), 16U);
  EXPECT_EQ(told.advances(), told.done.size() - 1) << "each time farther than before";
  EXPECT_GT(told.done.back(), told.total * 9 / 10);
  EXPECT_LE(told.done.back(), told.total);
  EXPECT_THROW(make_surfel_cloud(*walker().characters[0], *walker().banks[0], 4096, 1.5,
                                 [](size_t, size_t) { throw Interrupted{}; }),
               Interrupted);
}

}  // namespace
}  // namespace crowdbench::renderers
