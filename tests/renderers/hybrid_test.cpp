#include "renderers/hybrid/hybrid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "renderers/shaders/dither.shared.h"
#include "scene/cast/cast.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;

scene::FrameAgent agent_at(const glm::vec3& position, float scale = 1) {
  scene::FrameAgent a;
  a.position = position;
  a.scale = scale;
  return a;
}

TEST(LodPolicy, SwitchDistanceIsTheGeometry) {
  scene::Camera camera;
  camera.fov_y = std::numbers::pi / 2;  // tan(45 degrees) = 1: a pixel at depth d is 2 d / rows
  const LodCharacter character{1.8, 0.015};
  // At 480 rows a texel of 15 mm covers a pixel at 0.015 * 480 / 2 = 3.6 m.
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 1}, character, camera, 480), 3.6, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 0.5}, character, camera, 480), 7.2, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::ratio, 2}, character, camera, 480), 1.8, 1e-12);
  EXPECT_NEAR(switch_distance({LodPolicy::Rule::height, 120}, character, camera, 480), 3.6, 1e-12);
  EXPECT_EQ(switch_distance({LodPolicy::Rule::distance, 20}, character, camera, 480), 20);
}

TEST(LodPolicy, SplitsByEachRuleAndKeepsOrder) {
  scene::Frame frame = frame_of_one(5, 0.9, 640, 480, 90);  // looks along -Z
  // Middle 0.9 m over the pivot: put pivots so that middles lie on a level with the eye.
  frame.agents[0] = {agent_at({0, -0.9F, -10}), agent_at({0, -0.9F, -30}), agent_at({18, -0.9F, -10}),
                     agent_at({0, -0.9F, -25}, 2)};
  const AgentLists all = {{0, 1, 2, 3}};
  for (uint32_t i = 0; i < 4; ++i) frame.agents[0][i].id = i + 1;
  const std::vector<LodCharacter> character = {{1.8, 0.015}};
  const auto split = [&](const LodPolicy& policy) { return LodSwitch(policy, character).split(frame, all); };
  LodSplit s = split({LodPolicy::Rule::distance, 20});
  EXPECT_EQ(s.near[0], (std::vector<uint32_t>{0}));
  EXPECT_EQ(s.far[0], (std::vector<uint32_t>{1, 2, 3})) << "20.6 m away off the axis is beyond 20";
  // By height: 1.8 m at 20 m depth are 21.6 pixels of 480 rows.
  s = split({LodPolicy::Rule::height, 21.6});
  EXPECT_EQ(s.near[0], (std::vector<uint32_t>{0, 2, 3})) << "depth counts, not distance; twice as tall is near at 25 m";
  EXPECT_EQ(s.far[0], (std::vector<uint32_t>{1}));
  s = split({LodPolicy::Rule::ratio, 0.18});
  EXPECT_EQ(s.far[0], (std::vector<uint32_t>{1})) << "0.015 * 480 / (2 * 20) = 0.18: the same place";
  s = split({LodPolicy::Rule::nearest, 2});
  EXPECT_EQ(s.near[0], (std::vector<uint32_t>{0, 2}));
  EXPECT_EQ(split({LodPolicy::Rule::nearest, 0}).near[0], std::vector<uint32_t>{});
  EXPECT_EQ(split({LodPolicy::Rule::nearest, 9}).far[0], std::vector<uint32_t>{});
  for (auto& a : frame.agents[0]) a.position = {0, 0, -7};
  EXPECT_EQ(split({LodPolicy::Rule::nearest, 3}).near[0], (std::vector<uint32_t>{0, 1, 2}))
      << "exactly as many as asked for, ties by id";
}

// One agent walked through distances, a tick each; what the switch says at each.
struct Seen {
  bool near, far;
  int share;  // of the fade, 0 where there is none
  bool operator==(const Seen&) const = default;
};
Seen step(LodSwitch& lod, uint64_t tick, double distance) {
  scene::Frame frame = frame_of_one(5, 0.9, 640, 480, 90);
  frame.tick = tick;
  frame.agents[0] = {agent_at({0, 0, static_cast<float>(-distance)})};
  const LodSplit& split = lod.split(frame, {{0}});
  Seen seen{!split.near[0].empty(), !split.far[0].empty(), 0};
  for (size_t m = 1; m < split.fading.size(); ++m)
    if (!split.fading[m][0].empty()) seen.share = static_cast<int>(m);
  EXPECT_EQ(seen.near + seen.far + (seen.share != 0), 1) << "in exactly one list";
  return seen;
}

TEST(LodSwitch, NothingFlapsInsideTheBand) {
  const std::vector<LodCharacter> character = {{1.8, 0.015}};
  for (const double hysteresis : {0.0, 0.1}) {
    LodPolicy policy{LodPolicy::Rule::distance, 20};
    policy.hysteresis = hysteresis;
    LodSwitch lod(policy, character);
    int changes = 0;
    bool far = step(lod, 0, 20.5).far;
    EXPECT_TRUE(far) << "the first frame follows the rule alone";
    for (uint64_t tick = 1; tick <= 40; ++tick) {
      const bool now = step(lod, tick, tick % 2 == 0 ? 20.5 : 18.5).far;
      changes += now != far ? 1 : 0;
      far = now;
    }
    EXPECT_EQ(changes, hysteresis > 0 ? 0 : 40);
  }
  // The band's ends: 22 and 20 / 1.1 = 18.18 m.
  LodPolicy policy{LodPolicy::Rule::distance, 20};
  policy.hysteresis = 0.1;
  LodSwitch lod(policy, character);
  EXPECT_TRUE(step(lod, 0, 10).near);
  EXPECT_TRUE(step(lod, 1, 21.9).near);
  EXPECT_TRUE(step(lod, 2, 22.1).far);
  EXPECT_TRUE(step(lod, 3, 18.3).far);
  EXPECT_TRUE(step(lod, 4, 18.1).near);
}

// Agents at these distances, ids from 1 on; the ids of those that are near.
std::vector<uint32_t> near_ids(LodSwitch& lod, uint64_t tick, const std::vector<double>& distances) {
  scene::Frame frame = frame_of_one(5, 0.9, 640, 480, 90);
  frame.tick = tick;
  frame.agents[0].clear();
  AgentLists all(1);
  for (size_t i = 0; i < distances.size(); ++i) {
    frame.agents[0].push_back(agent_at({0, 0, static_cast<float>(-distances[i])}));
    frame.agents[0].back().id = static_cast<uint32_t>(i) + 1;
    all[0].push_back(static_cast<uint32_t>(i));
  }
  std::vector<uint32_t> ids;
  for (const uint32_t i : lod.split(frame, all).near[0]) ids.push_back(i + 1);
  return ids;
}

TEST(LodSwitch, TheNearestDoNotFlapEither) {
  using Ids = std::vector<uint32_t>;
  const std::vector<LodCharacter> character = {{1.8, 0.015}};
  for (const double hysteresis : {0.0, 0.1}) {
    LodPolicy policy{LodPolicy::Rule::nearest, 2};
    policy.hysteresis = hysteresis;
    LodSwitch lod(policy, character);
    Ids last = near_ids(lod, 0, {5, 10.2, 10, 40});
    EXPECT_EQ(last, (Ids{1, 3})) << "the first frame follows the rule alone";
    int changes = 0;
    for (uint64_t tick = 1; tick <= 40; ++tick) {
      const Ids now = near_ids(lod, tick, {5, tick % 2 == 0 ? 10.2 : 9.8, 10, 40});
      EXPECT_EQ(now.size(), 2U) << "as many as asked for";
      changes += now != last ? 1 : 0;
      last = now;
    }
    EXPECT_EQ(changes, hysteresis > 0 ? 0 : 40);
  }
  // The band's ends: 1.1^2 = 1.21 times nearer.
  LodPolicy policy{LodPolicy::Rule::nearest, 1};
  policy.hysteresis = 0.1;
  LodSwitch lod(policy, character);
  EXPECT_EQ(near_ids(lod, 0, {10, 11}), Ids{1});
  EXPECT_EQ(near_ids(lod, 1, {12.0, 10}), Ids{1});
  EXPECT_EQ(near_ids(lod, 1, {12.0, 10}), Ids{1}) << "the same tick is the same moment";
  EXPECT_EQ(near_ids(lod, 2, {12.2, 10}), Ids{2});
  EXPECT_EQ(near_ids(lod, 3, {10, 12.0}), Ids{2});
  EXPECT_EQ(near_ids(lod, 4, {10, 12.2}), Ids{1});
  // Equal distances: whoever is near stays; without a state before it, the lower id.
  EXPECT_EQ(near_ids(lod, 5, {20, 10}), Ids{2});
  EXPECT_EQ(near_ids(lod, 6, {10, 10}), Ids{2});
  EXPECT_EQ(near_ids(lod, 6 + LodSwitch::kMostTicks + 1, {10, 10}), Ids{1}) << "a jump begins anew";
}

TEST(LodSwitch, FadesTickByTickAndTurnsBackWhereItIs) {
  LodPolicy policy{LodPolicy::Rule::distance, 20};
  policy.fade = 3;
  LodSwitch lod(policy, {{1.8, 0.015}});
  const auto share = [&](uint64_t tick, double distance) { return step(lod, tick, distance).share; };
  EXPECT_TRUE(step(lod, 10, 19).near);
  EXPECT_EQ(share(11, 21), 1);
  EXPECT_EQ(share(12, 21), 2);
  EXPECT_EQ(share(12, 21), 2) << "the same tick is the same moment";
  EXPECT_EQ(share(13, 21), 3);
  EXPECT_TRUE(step(lod, 14, 21).far);
  // Towards near the far one's share falls.
  EXPECT_EQ(share(15, 19), 3);
  EXPECT_EQ(share(16, 19), 2);
  EXPECT_EQ(share(17, 21), 3) << "turned round";
  EXPECT_TRUE(step(lod, 18, 21).far);
  EXPECT_EQ(share(19, 19), 3);
  EXPECT_EQ(share(21, 19), 1) << "two ticks later";
  EXPECT_TRUE(step(lod, 22, 19).near);
  // Random access: a jump begins anew, by the rule alone.
  EXPECT_EQ(share(23, 21), 1);
  EXPECT_TRUE(step(lod, 23 + LodSwitch::kMostTicks + 1, 19).near);
  EXPECT_TRUE(step(lod, 3, 21).far);
}

TEST(LodSwitch, IsAFunctionOfTheSequence) {
  LodPolicy policy{LodPolicy::Rule::distance, 20};
  policy.fade = 5;
  policy.hysteresis = 0.05;
  const auto distance = [](uint64_t tick) { return 20 + 3 * std::sin(0.3 * static_cast<double>(tick)); };
  LodSwitch once(policy, {{1.8, 0.015}});
  LodSwitch stuttering(policy, {{1.8, 0.015}});
  step(stuttering, 1000, 5);  // what was drawn before the sequence began does not matter
  int fading = 0;
  for (uint64_t tick = 0; tick < 60; ++tick) {
    const Seen a = step(once, tick, distance(tick));
    for (int again = 0; again < 3; ++again) EXPECT_EQ(step(stuttering, tick, distance(tick)), a) << tick;
    fading += a.share != 0 ? 1 : 0;
  }
  EXPECT_GT(fading, 20);
}

TEST(LodSwitch, AnAgentThatWasAwayBeginsAnew) {
  LodPolicy policy{LodPolicy::Rule::distance, 20};
  policy.hysteresis = 0.5;
  LodSwitch lod(policy, {{1.8, 0.015}});
  EXPECT_TRUE(step(lod, 0, 25).far);
  EXPECT_TRUE(step(lod, 1, 15).far) << "within the band";
  scene::Frame empty = frame_of_one(5, 0.9, 640, 480, 90);
  empty.tick = 2;
  lod.split(empty, {{}});
  EXPECT_TRUE(step(lod, 3, 15).near);
}

using HybridGl = GlTest;

TEST_F(HybridGl, OfOneRepresentationTwiceIsThatRepresentation) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto mesh = make(cast, "mesh");
  const auto both = make(cast, "hybrid(mesh,mesh,distance=8)");
  Renderer renderer(context(), cast);
  scene::Frame frame = frame_of_one(6, 1.5, 160, 120, 40);
  for (uint32_t i = 0; i < 6; ++i) add_agent(frame, cast, {0.5 * i - 1.2, 0, -1.5 * i}, i + 1, 0.1 * i);
  const Capture a = renderer.capture(frame, *mesh);
  const Capture b = renderer.capture(frame, *both);
  EXPECT_GT(testing::covered(a), 500U);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.colour, b.colour);
  const auto& hybrid = dynamic_cast<const HybridRepresentation&>(*both);
  EXPECT_EQ(hybrid.near_agents() + hybrid.far_agents(), 6U);
  EXPECT_GT(hybrid.near_agents(), 0U);
  EXPECT_GT(hybrid.far_agents(), 0U);
}

TEST_F(HybridGl, DrawsNearAgentsAsTheMeshAndFarOnesAsImpostors) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string flat_spec = "flat:views=sphere-4x1,frames=2,texels=32";
  const auto mesh = make(cast, "mesh");
  const auto flat = make(cast, flat_spec);
  const auto both = make(cast, "hybrid(mesh," + flat_spec + ",distance=10)");
  Renderer renderer(context(), cast);
  for (const double distance : {6.0, 14.0}) {
    scene::Frame frame = frame_of_one(distance, 0.9, 120, 120, 25);
    add_agent(frame, cast, {0, 0, 0}, 1, 0.0);
    const auto expected = renderer.capture(frame, distance < 10 ? *mesh : *flat).colour;
    EXPECT_EQ(renderer.capture(frame, *both).colour, expected) << distance;
    EXPECT_NE(renderer.capture(frame, distance < 10 ? *flat : *mesh).colour, expected);
  }
  EXPECT_EQ(both->footprint().gpu_bytes(), mesh->footprint().gpu_bytes() + flat->footprint().gpu_bytes());
}

TEST_F(HybridGl, RefusesRulesThatCannotDecide) {
  const scene::Cast cast = cast_of(testing::two_bones());
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,ratio=1)"), Error) << "a mesh has no texels";
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,distance=5,height=30)"), Error);
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,height=0)"), Error);
  EXPECT_THROW(make(cast, "hybrid(mesh)"), Error);
  EXPECT_THROW(make(cast, "hybrid(mesh,mesh,fade=61)"), Error);
}

// However its agents are divided and share their pixels, a hybrid of one representation is that representation: every
// pixel of a fading agent is drawn by exactly one part, also where parts are hybrids that fade themselves.
TEST_F(HybridGl, CrossFadesCoverEveryPixelOnce) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const auto mesh = make(cast, "mesh");
  const auto three = make(cast, "hybrid(mesh,hybrid(mesh,mesh,distance=6.5,fade=6),distance=6,fade=9,hysteresis=0.02)");
  const auto& hybrid = dynamic_cast<const HybridRepresentation&>(*three);
  Renderer renderer(context(), cast);
  size_t fading = 0;
  for (uint64_t tick = 0; tick < 30; ++tick) {
    const double away = 5 + 0.1 * static_cast<double>(tick);
    scene::Frame frame = frame_of_one(away, 1.5, 160, 120, 40);
    frame.tick = tick;
    for (uint32_t i = 0; i < 4; ++i) add_agent(frame, cast, {0.5 * i - 1.2, 0, -0.3 * i}, i + 1, 0.1 * i);
    const Capture expected = renderer.capture(frame, *mesh);
    ASSERT_GT(testing::covered(expected), 500U) << tick;
    ASSERT_EQ(renderer.capture(frame, *three), expected) << tick;
    fading += hybrid.fading_agents();
  }
  EXPECT_GT(fading, 20U) << "agents that fade, over the ticks";
}

TEST_F(HybridGl, CrossFadeShowsEachSideAtItsPixels) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string flat_spec = "flat:views=sphere-4x1,frames=2,texels=32";
  const auto mesh = make(cast, "mesh");
  const auto flat = make(cast, flat_spec);
  const auto both = make(cast, "hybrid(mesh,(" + flat_spec + "),distance=8,fade=3)");
  Renderer renderer(context(), cast);
  const auto at = [&](uint64_t tick, double distance) {
    scene::Frame frame = frame_of_one(distance, 0.9, 120, 120, 25);
    frame.tick = tick;
    add_agent(frame, cast, {0, 0, 0}, 1, 0.0);
    return frame;
  };
  EXPECT_EQ(renderer.capture(at(0, 7.9), *both), renderer.capture(at(0, 7.9), *mesh));
  for (uint64_t tick = 1; tick <= 3; ++tick) {
    const scene::Frame frame = at(tick, 8.1);
    const Capture a = renderer.capture(frame, *mesh);
    const Capture b = renderer.capture(frame, *flat);
    const Capture mixed = renderer.capture(frame, *both);
    size_t from_far = 0;
    for (uint y = 0; y < 120; ++y)
      for (uint x = 0; x < 120; ++x) {
        const size_t i = y * 120 + x;
        const bool far = (dither_rank(x, 119 - y) + 0.5) / 64 < static_cast<double>(tick) / 4;
        ASSERT_EQ(mixed.ids.data[i], (far ? b : a).ids.data[i]) << x << " " << y;
        for (size_t c = 0; c < 3; ++c)
          ASSERT_EQ(mixed.colour.data[4 * i + c], (far ? b : a).colour.data[4 * i + c]) << x << " " << y;
        from_far += far && b.ids.data[i] != 0 ? 1U : 0U;
      }
    EXPECT_GT(from_far, 10U);
  }
  EXPECT_EQ(renderer.capture(at(4, 8.1), *both), renderer.capture(at(4, 8.1), *flat));
}

// Within a tenth of the switch distance the mesh shows the stored frame that the impostor is about to show.
TEST_F(HybridGl, PosesMatchAtTheSwitch) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string flat_spec = "flat:views=sphere-4x1,frames=5,texels=32";
  const auto mesh = make(cast, "mesh");
  const auto flat = make(cast, flat_spec);
  // Stored: 0, 0.2, 0.4, ...
  EXPECT_DOUBLE_EQ(flat->shown_phase(0, 0, 0.29), static_cast<double>(0.2F));
  EXPECT_DOUBLE_EQ(flat->shown_phase(0, 0, 0.31), static_cast<double>(0.4F));
  EXPECT_EQ(flat->shown_phase(0, 0, 0.95), 0) << "the cycle closes";
  EXPECT_EQ(mesh->shown_phase(0, 0, 0.29), 0.29);
  const auto matched = make(cast, "hybrid(mesh,(" + flat_spec + "),distance=10)");
  const auto unmatched = make(cast, "hybrid(mesh,(" + flat_spec + "),distance=10,match=0)");
  Renderer renderer(context(), cast);
  const auto picture = [&](Representation& r, double distance, double phase) {
    scene::Frame frame = frame_of_one(distance, 0.0, 120, 120, 25);
    add_agent(frame, cast, {0, 0, 0}, 1, phase, 0.25F);
    add_agent(frame, cast, {1, 0, distance - 4}, 2, phase);  // a near one, whose pose is its own
    return renderer.capture(frame, r).colour;
  };
  const auto expected = [&](double distance, double first, double second) {
    scene::Frame frame = frame_of_one(distance, 0.0, 120, 120, 25);
    add_agent(frame, cast, {0, 0, 0}, 1, first, 0.25F);
    add_agent(frame, cast, {1, 0, distance - 4}, 2, second);
    return renderer.capture(frame, *mesh).colour;
  };
  EXPECT_EQ(picture(*matched, 9.5, 0.29), expected(9.5, static_cast<double>(0.2F), 0.29));
  EXPECT_NE(picture(*matched, 9.5, 0.29), expected(9.5, 0.29, 0.29));
  EXPECT_EQ(picture(*matched, 8.5, 0.29), expected(8.5, 0.29, 0.29));
  EXPECT_EQ(picture(*unmatched, 9.5, 0.29), expected(9.5, 0.29, 0.29));
}

TEST_F(HybridGl, AdvancingIsDrawingWithoutAPicture) {
  const scene::Cast cast = cast_of(testing::two_bones());
  const std::string spec =
      "hybrid(mesh,hybrid(mesh,(flat:views=sphere-4x1,frames=2,texels=32),distance=9,fade=6),distance=8,hysteresis=0."
      "05,fade=4)";
  const auto drawn = make(cast, spec);
  const auto played = make(cast, spec);
  const auto jumped = make(cast, spec);
  EXPECT_TRUE(drawn->has_history());
  EXPECT_FALSE(make(cast, "hybrid(mesh,mesh,distance=8)")->has_history());
  EXPECT_TRUE(make(cast, "hybrid(mesh,hybrid(mesh,mesh,fade=3),distance=8)")->has_history());
  Renderer renderer(context(), cast);
  const auto at = [&](uint64_t tick) {
    scene::Frame frame = frame_of_one(7 + 0.12 * static_cast<double>(tick), 0.9, 120, 120, 25);
    frame.tick = tick;
    for (uint32_t i = 0; i < 4; ++i) add_agent(frame, cast, {0.4 * i - 0.6, 0, -0.2 * i}, i + 1, 0.1 * i);
    return frame;
  };
  constexpr uint64_t kTick = 12;
  Capture expected;
  for (uint64_t tick = 0; tick <= kTick; ++tick) expected = renderer.capture(at(tick), *drawn);
  for (uint64_t tick = 0; tick < kTick; ++tick) played->advance(at(tick), all_agents(at(tick)));
  EXPECT_EQ(renderer.capture(at(kTick), *played), expected);
  EXPECT_NE(renderer.capture(at(kTick), *jumped), expected) << "in the middle of a fade, or this test tests nothing";
}

}  // namespace
}  // namespace crowdbench::renderers
