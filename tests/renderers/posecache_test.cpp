#include "renderers/posecache/posecache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/random.h"
#include "renderers/posecache/cache_trade.h"
#include "renderers/posecache/key_choice.h"
#include "renderers/posecache/pose_slots.h"
#include "scene/cast/cast.h"
#include "scene/scenario/parse_scenario.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::context;
using testing::covered;
using testing::different_ids;
using testing::fact;
using testing::GlTest;
using testing::make;
using testing::row_of_walkers;
using testing::walker;
using testing::worst_colour_difference;

KeyDemand demand_of(std::vector<KeyCircle> circles, std::vector<uint32_t> agents, double fresh_cost = 0) {
  const size_t keys = agents.size();
  return {std::move(circles), std::move(agents), KeySet(keys, 0), fresh_cost};
}

TEST(KeyPlace, IsTheIntervalOnTheCircle) {
  const KeyCircle circle{10, 4};
  EXPECT_EQ(key_place(circle, 0.0F).key, 10U);
  EXPECT_EQ(key_place(circle, 0.8125F).key, 13U);
  EXPECT_EQ(key_place(circle, 0.8125F).blend, 0.25F);
  EXPECT_EQ(circle.next(13), 10U);
  EXPECT_EQ(key_place({3, 1}, 0.5F).key, 3U);
  EXPECT_EQ((KeyCircle{3, 1}.next(3)), 3U);
}

// Five agents beside each other, and four and four about one key pose: with three places the rule that takes the best
// next step takes the five, and cannot use the third place.
TEST(KeyRule, RulesAsByHand) {
  const KeyDemand d = demand_of({{0, 6}}, {5, 0, 0, 4, 4, 0});
  EXPECT_EQ(choose_greedy(d, 2), (KeySet{1, 1, 0, 0, 0, 0}));
  EXPECT_EQ(choose_greedy(d, 3), (KeySet{1, 1, 0, 0, 0, 0}));
  EXPECT_EQ(choose_exact(d, 3), (KeySet{0, 0, 0, 1, 1, 1}));
  EXPECT_EQ(hits_of(d, choose_exact(d, 3)), 8U);
  EXPECT_EQ(choose_popular(d, 3), (KeySet{1, 1, 0, 0, 1, 0})) << "four is beside most, its neighbours are not taken";
  EXPECT_EQ(choose_greedy(d, 5), (KeySet{1, 1, 0, 1, 1, 1}));
  EXPECT_EQ(choose_greedy(d, 1), (KeySet(6, 0))) << "one alone completes no interval";
  EXPECT_EQ(choose_keys(d, 5, KeyRule::popular), (KeySet{1, 1, 0, 1, 1, 1})) << "all that are needed fit";
  // Across the circle's end, and a still clip, which needs one place.
  const KeyDemand two = demand_of({{0, 3}, {3, 1}}, {0, 0, 6, 4});
  EXPECT_EQ(choose_greedy(two, 1), (KeySet{0, 0, 0, 1}));
  EXPECT_EQ(choose_exact(two, 2), (KeySet{1, 0, 1, 0}));
  EXPECT_EQ(choose_greedy(two, 3), (KeySet{1, 0, 1, 1}));
}

TEST(KeyRule, WhatMustBeSkinnedFirstCountsLess) {
  KeyDemand d = demand_of({{0, 6}}, {5, 0, 0, 4, 0, 0}, 1);
  EXPECT_EQ(choose_greedy(d, 2), (KeySet{1, 1, 0, 0, 0, 0}));
  d.cached = {0, 0, 0, 1, 1, 0};
  for (const KeySet& set : {choose_greedy(d, 2), choose_exact(d, 2)}) EXPECT_EQ(set, (KeySet{0, 0, 0, 1, 1, 0}));
  EXPECT_EQ(value_of(d, {1, 1, 0, 1, 1, 0}), 5 + 4 - 2);
  d.fresh_cost = 3;
  EXPECT_EQ(choose_greedy(d, 6), (KeySet{0, 0, 0, 1, 1, 0})) << "five agents are not worth two poses at three each";
}

// Against all sets there are; and how far the greedy rule stays below.
TEST(KeyRule, ExactIsTheBestOfAllSets) {
  double worst = 1;
  for (uint64_t trial = 0; trial < 60; ++trial) {
    const auto random = [&](uint64_t index, uint64_t below) {
      return static_cast<uint32_t>(random_below(7, trial * 100 + index, 1, below));
    };
    const uint32_t a = 1 + random(0, 5);
    const uint32_t b = 1 + random(1, 5);
    KeyDemand d = demand_of({{0, a}, {a, b}}, {}, trial % 2 == 0 ? 0 : 1.5);
    for (uint32_t key = 0; key < a + b; ++key) {
      d.agents.push_back(random(10 + key, 6));
      d.cached.push_back(static_cast<uint8_t>(random(30 + key, 2)));
    }
    const uint32_t most = 1 + random(2, a + b);
    double best = 0;
    for (uint32_t bits = 0; bits < 1U << (a + b); ++bits) {
      KeySet set;
      for (uint32_t key = 0; key < a + b; ++key) set.push_back(bits >> key & 1U);
      if (std::accumulate(set.begin(), set.end(), 0U) <= most) best = std::max(best, value_of(d, set));
    }
    const KeySet exact = choose_exact(d, most);
    EXPECT_LE(std::accumulate(exact.begin(), exact.end(), 0U), most);
    ASSERT_DOUBLE_EQ(value_of(d, exact), best) << trial;
    for (const KeySet& set : {choose_greedy(d, most), choose_popular(d, most)}) {
      EXPECT_LE(std::accumulate(set.begin(), set.end(), 0U), most);
      EXPECT_LE(value_of(d, set), best);
    }
    if (best > 0) worst = std::min(worst, value_of(d, choose_greedy(d, most)) / best);
  }
  EXPECT_LT(worst, 1.0) << "or this tests nothing";
  EXPECT_GT(worst, 0.5);
}

TEST(PoseSlots, KeepWhatIsNeededAndForgetWhatWasNotForLongest) {
  PoseSlots slots(6, 3);
  const auto filled = [&](const KeySet& set) {
    std::vector<std::pair<uint32_t, uint32_t>> out;
    for (const PoseSlots::Fill& f : slots.take(set)) out.emplace_back(f.slot, f.key);
    return out;
  };
  using Fills = std::vector<std::pair<uint32_t, uint32_t>>;
  EXPECT_EQ(filled({1, 1, 0, 0, 0, 0}), (Fills{{0, 0}, {1, 1}}));
  EXPECT_EQ(filled({1, 1, 0, 0, 0, 0}), Fills{});
  EXPECT_EQ(filled({0, 1, 1, 0, 0, 0}), (Fills{{2, 2}})) << "an empty place first";
  EXPECT_EQ(filled({0, 0, 1, 1, 0, 0}), (Fills{{0, 3}})) << "pose 0 has been out for longest";
  EXPECT_EQ(filled({0, 1, 1, 0, 0, 0}), Fills{}) << "pose 1 was still there";
  EXPECT_EQ(filled({1, 0, 0, 0, 1, 1}), (Fills{{0, 0}, {1, 4}, {2, 5}}));
  EXPECT_EQ(slots.slot(4), 1U);
}

// Skinning is linear in the matrices, and the bank's poses are blends of its samples.
TEST(BlendError, IsNoneAtTheBanksSamplesAndFallsWithTheSquare) {
  const scene::PoseBank& bank = *walker().banks[0];
  const auto error = [&](uint32_t keys) { return blend_error(*walker().characters[0], bank, key_circles(bank, keys)); };
  EXPECT_LT(error(0).max, 2e-6);
  EXPECT_GT(error(8).rms, 1e-3);
  EXPECT_LT(error(8).rms, error(8).max);
  EXPECT_NEAR(std::log2(error(4).rms / error(8).rms), 2.0, 0.6) << "twice the key poses, a quarter";
}

TEST(CacheTrade, AllAreHitsWhereAllKeyPosesFit) {
  const scene::PoseBank& bank = *walker().banks[0];
  const std::vector<KeyCircle> circles = key_circles(bank, 16);
  const CacheTrade all = cache_trade(bank, circles, 16, KeyRule::greedy, 0, 50);
  EXPECT_DOUBLE_EQ(all.hits, 50);
  EXPECT_EQ(all.skinned, 0);
  const CacheTrade half = cache_trade(bank, circles, 8, KeyRule::greedy, 0, 50);
  EXPECT_GT(half.hits, 15);
  EXPECT_LT(half.hits, 35);
  EXPECT_GT(half.skinned, 0);
  const CacheTrade exact = cache_trade(bank, circles, 8, KeyRule::exact, 0, 50);
  EXPECT_GE(exact.hits, half.hits);
  EXPECT_LT(cache_trade(bank, circles, 8, KeyRule::popular, 0, 50).hits, half.hits);
  EXPECT_LT(cache_trade(bank, circles, 8, KeyRule::greedy, 40, 50).skinned, half.skinned);
}

class PoseCacheGl : public GlTest {};

Capture drawn_as(const scene::Frame& frame, const std::string& spec) {
  Renderer renderer(context(), walker());
  return renderer.capture(frame, *make(walker(), spec));
}

// Phases of a crowd that walks on.
std::vector<double> phases_at(uint64_t tick, size_t agents) {
  std::vector<double> out;
  for (size_t i = 0; i < agents; ++i) {
    const double at = random_unit(3, i, 0) + 0.013 * static_cast<double>(tick);
    out.push_back(at - std::floor(at));
  }
  return out;
}

TEST_F(PoseCacheGl, BlendedFromTheBanksSamplesItIsTheMesh) {
  const scene::Frame frame = row_of_walkers(phases_at(0, 12));
  const Capture mesh = drawn_as(frame, "mesh");
  const Capture test = drawn_as(frame, "posecache:poses=64");
  EXPECT_LE(different_ids(mesh, test), 4U);
  EXPECT_LE(worst_colour_difference(mesh, test), 3);
  EXPECT_EQ(covered(drawn_as(frame, "posecache:poses=64,debug=misses")), 0U);
}

TEST_F(PoseCacheGl, WhoFindsNoPosesIsTheMesh) {
  const scene::Frame frame = row_of_walkers(phases_at(0, 6));
  EXPECT_EQ(drawn_as(frame, "posecache:poses=1"), drawn_as(frame, "mesh"));
  const Capture some = drawn_as(frame, "posecache:keys=16,poses=4,debug=misses");
  EXPECT_GT(covered(some), 0U);
  EXPECT_LT(covered(some), covered(drawn_as(frame, "mesh")));
}

// In a key pose nothing is blended: the pose that pseudo-instancing shows.
TEST_F(PoseCacheGl, InAKeyPoseItIsThatPose) {
  const scene::Frame frame = row_of_walkers({0.0, 0.25, 0.5, 0.75});
  const Capture test = drawn_as(frame, "posecache:keys=4");
  const Capture pose = drawn_as(frame, "pseudo:poses=4");
  EXPECT_EQ(test.ids, pose.ids);
  EXPECT_LE(worst_colour_difference(test, pose), 1);
  EXPECT_GT(different_ids(drawn_as(row_of_walkers({0.125, 0.375}), "posecache:keys=4"),
                          drawn_as(row_of_walkers({0.125, 0.375}), "mesh")),
            20U);
}

// Places that are skinned anew, and used again: pictures are those of a cache that saw nothing before.
TEST_F(PoseCacheGl, PicturesDoNotDependOnWhatCameBefore) {
  const std::string spec = "posecache:keys=16,poses=5";
  const auto one = make(walker(), spec);
  EXPECT_FALSE(one->has_history());
  Renderer renderer(context(), walker());
  for (const uint64_t tick : {0, 9, 3, 3, 40, 41, 0}) {
    const scene::Frame frame = row_of_walkers(phases_at(tick, 10));
    EXPECT_EQ(renderer.capture(frame, *one), drawn_as(frame, spec)) << tick;
  }
}

TEST_F(PoseCacheGl, KeepingHasAHistoryAndAdvancingIsDrawing) {
  const std::string spec = "posecache:keys=16,poses=5,keep=2";
  const auto drawn = make(walker(), spec);
  const auto played = make(walker(), spec);
  const auto jumped = make(walker(), spec);
  EXPECT_TRUE(drawn->has_history());
  Renderer renderer(context(), walker());
  const auto at = [](uint64_t tick) {
    scene::Frame frame = row_of_walkers(phases_at(tick, 10));
    frame.tick = tick;
    return frame;
  };
  constexpr uint64_t kTick = 10;
  Capture expected;
  for (uint64_t tick = 0; tick <= kTick; ++tick) expected = renderer.capture(at(tick), *drawn);
  for (uint64_t tick = 0; tick < kTick; ++tick) played->advance(at(tick), all_agents(at(tick)));
  EXPECT_EQ(renderer.capture(at(kTick), *played), expected);
  EXPECT_EQ(renderer.capture(at(kTick), *played), expected) << "the same moment again";
  EXPECT_NE(renderer.capture(at(kTick), *jumped), expected) << "or this tests nothing";
}

TEST_F(PoseCacheGl, PassesShowTheSame) {
  CROWDBENCH_SKIP_SANITIZED("PreskinnedGl.PassesShowTheSameAndCostTheirVertices");
  const scene::Frame frame = row_of_walkers(phases_at(0, 8));
  const Capture three = drawn_as(frame, "posecache:keys=16,poses=5,passes=3");
  const Capture one = drawn_as(frame, "posecache:keys=16,poses=5");
  EXPECT_EQ(three.ids, one.ids);
  EXPECT_LE(worst_colour_difference(three, one), 1) << "what is invariant is contracted otherwise";
}

TEST_F(PoseCacheGl, BytesAreThoseOfItsPlaces) {
  const auto bytes = [](const std::string& spec) { return make(walker(), spec)->footprint().buffer_bytes; };
  const uint64_t one = bytes("posecache:keys=16,poses=2") - bytes("posecache:keys=16,poses=1");
  EXPECT_EQ(bytes("posecache:keys=16,poses=11") - bytes("posecache:keys=16,poses=1"), 10 * one);
  EXPECT_EQ(bytes("posecache:keys=16,poses=99"), bytes("posecache:keys=16,poses=16")) << "no more than there are";
  const auto facts = make(walker(), "posecache:keys=16,mib=0.05")->bake_info().facts;
  EXPECT_LE(fact(facts, "cache_mib"), 0.05);
  EXPECT_GT(fact(facts, "cache_mib") * (1 + 1 / fact(facts, "places")), 0.05);
  EXPECT_THROW((void)make(walker(), "posecache:mib=0.001"), std::exception);
}

}  // namespace
}  // namespace crowdbench::renderers
