// Who draws whom in a hybrid, and a frame drawn without some of its switches.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "renderers/hybrid/hybrid.h"
#include "scene/cast/cast.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::make;

const std::string kFlat = "flat:views=sphere-4x1,frames=2,texels=32";

class HybridHoldGl : public testing::GlTest {
 protected:
  // Agents 1 .. 4 on a line away from the eye, 0.4 m apart, the first at `distance`.
  scene::Frame frame(uint64_t tick, double distance) const {
    scene::Frame out = frame_of_one(distance, 0.9, 160, 120, 40);
    out.tick = tick;
    for (uint32_t i = 0; i < 4; ++i) add_agent(out, cast_, {0.7 * i - 1.05, 0, -0.4 * i}, i + 1, 0.1 * i);
    return out;
  }
  static std::vector<AgentShares> shares(Representation& of, const scene::Frame& frame) {
    return of.shares(frame, all_agents(frame));
  }
  const scene::Cast cast_ = cast_of(testing::two_bones());
  Renderer renderer_{context(), cast_};
};

TEST_F(HybridHoldGl, NamesItsComponentsNearestFirst) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(make(cast_, "hybrid(mesh,(" + kFlat + "),distance=6)")->components(), (Names{"mesh", kFlat}));
  EXPECT_EQ(make(cast_, "hybrid(hybrid(mesh,rigid,distance=5),(" + kFlat + "),distance=6)")->components(),
            (Names{"mesh", "rigid", kFlat}));
  const auto mesh = make(cast_, "mesh");
  EXPECT_TRUE(mesh->components().empty());
  EXPECT_TRUE(shares(*mesh, frame(0, 5)).empty());
}

TEST_F(HybridHoldGl, SharesFollowTheRule) {
  const auto hybrid = make(cast_, "hybrid(mesh,hybrid(rigid,mesh,distance=6.5),distance=6)");
  // Distances to the pivots: the eye is 0.9 m above the ground.
  const scene::Frame now = frame(0, 5.5);
  const std::vector<AgentShares> all = shares(*hybrid, now);
  ASSERT_EQ(all.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    const float distance = glm::length(now.agents[0][i].position);
    const std::vector<float> expected = distance <= 6.0F   ? std::vector<float>{1, 0, 0}
                                        : distance <= 6.5F ? std::vector<float>{0, 1, 0}
                                                           : std::vector<float>{0, 0, 1};
    EXPECT_EQ(all[i], (AgentShares{static_cast<uint32_t>(i) + 1, expected})) << distance;
  }
  EXPECT_EQ(all[0].shares[0], 1);
  EXPECT_EQ(all[2].shares[1], 1);
  EXPECT_EQ(all[3].shares[2], 1);
}

TEST_F(HybridHoldGl, AskingForSharesChangesNothing) {
  const std::string spec =
      "hybrid(mesh,hybrid(mesh,(" + kFlat + "),distance=6.5,fade=6),distance=6,hysteresis=0.05,fade=4)";
  const auto asked = make(cast_, spec);
  const auto plain = make(cast_, spec);
  size_t fading = 0;
  for (uint64_t tick = 0; tick < 24; ++tick) {
    const scene::Frame now = frame(tick, 5 + 0.1 * static_cast<double>(tick));
    const Capture expected = renderer_.capture(now, *plain);
    ASSERT_EQ(renderer_.capture(now, *asked), expected) << tick;
    for (const AgentShares& agent : shares(*asked, now)) {
      ASSERT_EQ(agent.shares.size(), 3U);
      EXPECT_NEAR(agent.shares[0] + agent.shares[1] + agent.shares[2], 1, 1e-6);
      fading += agent.shares[0] > 0 && agent.shares[0] < 1 ? 1U : 0U;
    }
  }
  EXPECT_GT(fading, 8U);
}

// All agents held as the rule has them: the same bytes, also in the middle of fades within fades.
TEST_F(HybridHoldGl, HeldAsItIsDrawnIsTheSameFrame) {
  const auto hybrid =
      make(cast_, "hybrid(mesh,hybrid(rigid,(" + kFlat + "),distance=6.5,fade=6),distance=6,fade=9,hysteresis=0.02)");
  for (uint64_t tick = 0; tick < 24; ++tick) {
    const scene::Frame now = frame(tick, 5 + 0.1 * static_cast<double>(tick));
    const Capture expected = renderer_.capture(now, *hybrid);
    hybrid->hold(shares(*hybrid, now));
    EXPECT_EQ(renderer_.capture(now, *hybrid), expected) << tick;
    hybrid->hold({});
    EXPECT_EQ(renderer_.capture(now, *hybrid), expected) << tick;
  }
}

// Held near, a frame beyond the switch is the frame of a hybrid that switches farther away.
TEST_F(HybridHoldGl, HeldFramesAreThoseWithoutTheSwitch) {
  const auto hybrid = make(cast_, "hybrid(mesh,(" + kFlat + "),distance=6,match=0)");
  const auto later = make(cast_, "hybrid(mesh,(" + kFlat + "),distance=6.3,match=0)");
  const scene::Frame now = frame(1, 5.6);
  const Capture switched = renderer_.capture(now, *hybrid);
  std::vector<AgentShares> held = shares(*hybrid, now);
  const std::vector<AgentShares> expected = shares(*later, now);
  size_t apart = 0;
  for (size_t i = 0; i < held.size(); ++i) apart += held[i] == expected[i] ? 0U : 1U;
  ASSERT_EQ(apart, 1U) << "one agent stands between 6 and 6.3 m";
  hybrid->hold(expected);
  const Capture without = renderer_.capture(now, *hybrid);
  EXPECT_EQ(without, renderer_.capture(now, *later));
  EXPECT_NE(without.colour, switched.colour);
}

// What is held is not remembered: the sequence goes on as if nobody had been held.
TEST_F(HybridHoldGl, HoldingLeavesTheHistoryAsItIs) {
  const std::string spec =
      "hybrid(mesh,hybrid(rigid,(" + kFlat + "),nearest=2,hysteresis=0.2,fade=5),distance=6,fade=3,hysteresis=0.05)";
  const auto held = make(cast_, spec);
  const auto plain = make(cast_, spec);
  std::vector<AgentShares> last;
  size_t differing = 0;
  for (uint64_t tick = 0; tick < 40; ++tick) {
    const scene::Frame now = frame(tick, 6 + std::sin(0.35 * static_cast<double>(tick)));
    const Capture expected = renderer_.capture(now, *plain);
    ASSERT_EQ(renderer_.capture(now, *held), expected) << tick;
    const std::vector<AgentShares> all = shares(*held, now);
    ASSERT_EQ(all, shares(*plain, now)) << tick;
    if (!last.empty()) {
      held->hold(last);
      differing += renderer_.capture(now, *held) == expected ? 0U : 1U;
      held->hold({});
    }
    last = all;
  }
  EXPECT_GT(differing, 10U) << "or nothing was held that changes";
}

}  // namespace
}  // namespace crowdbench::renderers
