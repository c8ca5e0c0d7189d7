#include "renderers/dynamic/dynamic.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "renderers/dynamic/pose_probe.h"
#include "renderers/dynamic/tile_atlas.h"
#include "renderers/dynamic/tile_states.h"
#include "renderers/dynamic/tile_view.h"
#include "renderers/frame/frame_resources.h"
#include "scene/cast/cast.h"
#include "tests/renderers/compare_captures.h"
#include "tests/renderers/gl_test_support.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::context;
using testing::fact;
using testing::frame_of_one;
using testing::GlTest;
using testing::make;
using testing::walker;

constexpr double kDegree = std::numbers::pi / 180;
const Box kUnitBox{glm::dvec3(-0.5), glm::dvec3(0.5)};

TEST(TileView, HoldsTheBoxAsTheEyeSeesIt) {
  const TileView view = tile_view(kUnitBox, {0, 0, 10}, {1, 0, 0}, 0.1).value();
  // The corners nearest to the eye, 9.5 before it.
  EXPECT_NEAR(view.high.x, 0.5 * 10 / 9.5, 1e-12);
  EXPECT_NEAR(view.low.y, -0.5 * 10 / 9.5, 1e-12);
  EXPECT_NEAR(view.nearest, 9.5, 1e-12);
  EXPECT_EQ(tile_texels(view), glm::ivec2(11, 11));
  EXPECT_FALSE(tile_view(kUnitBox, {0, 0, 0.3}, {1, 0, 0}, 0.1)) << "within the box";
  EXPECT_FALSE(tile_view(kUnitBox, {0, 0, 0}, {1, 0, 0}, 0.1));
}

TEST(TileView, LiesAlongThePictureFromEverySide) {
  // Over the pole by a little: what is right stays right.
  const glm::dvec3 right(0.8, 0, 0.6);
  const TileView before = tile_view(kUnitBox, {0, 5, 1e-7}, right, 0.1).value();
  const TileView after = tile_view(kUnitBox, {0, 5, -1e-7}, right, 0.1).value();
  EXPECT_LT(glm::distance(before.right, after.right), 1e-6);
  EXPECT_LT(glm::distance(before.right, right), 1e-6);
  for (const glm::dvec3& eye : {glm::dvec3(0, 5, 0), glm::dvec3(3, -1, 2), glm::dvec3(5, 0, 0)})
    for (const glm::dvec3& wanted : {right, glm::dvec3(2, 0, 0), glm::dvec3(0, 3, 1)}) {
      const TileView view = tile_view(kUnitBox, eye, wanted, 0.1).value();
      EXPECT_NEAR(glm::dot(glm::cross(view.right, view.up), view.to_eye), 1.0, 1e-12);
      EXPECT_NEAR(glm::length(view.right), 1.0, 1e-12);
      EXPECT_GE(glm::dot(view.right, wanted), -1e-12);
    }
}

TEST(TileView, RowsPutPointsWhereTheEyeSeesThem) {
  const glm::vec2 heading(std::sin(0.7F), std::cos(0.7F));
  const TileView view = tile_view(kUnitBox, {3, 4, 5}, {5, 0, -3}, 0.05).value();
  const TileRows rows = tile_rows(view, heading, {20, 30}, 512);
  const auto texel_of = [&](const glm::dvec3& p) {
    const glm::vec4 world(turned(p, heading), 1.0);
    const double w = static_cast<double>(glm::dot(rows.w, world));
    return glm::dvec3((static_cast<double>(glm::dot(rows.x, world)) / w + 1) * 256,
                      (static_cast<double>(glm::dot(rows.y, world)) / w + 1) * 256,
                      static_cast<double>(glm::dot(rows.z, world)) / w);
  };
  const glm::dvec3 eye(3, 4, 5);
  const glm::dvec3 on_plane = 0.2 * view.right - 0.3 * view.up;
  const glm::dvec3 at = texel_of(on_plane);
  EXPECT_NEAR(at.x, 20 + (0.2 - view.low.x) / 0.05, 1e-3);
  EXPECT_NEAR(at.y, 30 + (-0.3 - view.low.y) / 0.05, 1e-3);
  // What lies on one ray falls on one texel, and the nearer is the larger
  // depth.
  const glm::dvec3 nearer = texel_of(glm::mix(on_plane, eye, 0.05));
  EXPECT_NEAR(nearer.x, at.x, 1e-3);
  EXPECT_NEAR(nearer.y, at.y, 1e-3);
  EXPECT_GT(nearer.z, at.z);
  EXPECT_LT(nearer.z, 1.0);
}

TEST(TileAtlas, GivesUpWhatWasNotUsedForLongest) {
  TileAtlas atlas(1);
  EXPECT_EQ(atlas.take(1, {200, 500}, 1)->corner, glm::ivec2(0, 0));
  EXPECT_EQ(atlas.take(2, {256, 400}, 2)->corner, glm::ivec2(256, 0));
  EXPECT_EQ(atlas.take(3, {250, 450}, 3)->corner, glm::ivec2(0, 0));
  EXPECT_FALSE(atlas.find(1));
  EXPECT_EQ(atlas.take(4, {100, 100}, 4)->size, glm::ivec2(128, 128)) << "cells of another size: the whole page";
  EXPECT_EQ(atlas.tiles(), 1U);
}

TEST(TileAtlas, KeepsWhatIsInUse) {
  TileAtlas atlas(1);
  const auto a = atlas.take(1, {200, 400}, 1);
  const auto b = atlas.take(2, {200, 400}, 1);
  ASSERT_TRUE(a && b);
  EXPECT_NE(a->corner, b->corner);
  EXPECT_EQ(a->size, glm::ivec2(256, 512)) << "of the next sizes";
  EXPECT_FALSE(atlas.take(3, {200, 400}, 1)) << "both are in use";
  EXPECT_FALSE(atlas.take(3, {20, 40}, 1)) << "and so is the page";
  atlas.use(1, 2);
  const auto c = atlas.take(3, {200, 400}, 2);
  ASSERT_TRUE(c);
  EXPECT_EQ(*c, *b);
  EXPECT_FALSE(atlas.find(2));
  EXPECT_TRUE(atlas.take(4, {20, 40}, 3)) << "nobody uses the page";
  EXPECT_FALSE(atlas.find(1));
  EXPECT_FALSE(atlas.take(5, {513, 10}, 4));
}

TEST(PoseProbe, SeesAJointBend) {
  const scene::Cast cast = testing::cast_of(testing::two_bones());
  const scene::PoseBank& bank = *cast.banks[0];
  const std::vector<JointPoint> points = choose_joint_points(*cast.characters[0], bank, 6);
  ASSERT_EQ(points.size(), 2U) << "no more than there are joints";
  const PoseProbe probe(bank, points);
  // The distance of the two points is a chord: it changes as the upper one
  // turns, and is the poses' own.
  float before = -1;
  for (const double phase : {0.0, 0.2, 0.4}) {
    const scene::PoseSample pose = bank.sample(0, phase);
    const std::vector<scene::Mat3x4> palette = bank.palette(pose);
    std::array<glm::vec3, 2> posed;
    for (size_t i = 0; i < 2; ++i)
      for (int r = 0; r < 3; ++r)
        posed.at(i)[r] = glm::dot(palette[points[i].joint].rows[r], glm::vec4(points[i].place, 1.0F));
    const std::vector<float> d = probe.distances(pose);
    ASSERT_EQ(d.size(), 1U);
    EXPECT_NEAR(d[0], glm::distance(posed[0], posed[1]), 1e-5F);
    EXPECT_GT(std::abs(d[0] - before), 0.005F);
    before = d[0];
  }
}

TEST(PoseProbe, LooserThresholdsShowOlderPoses) {
  const scene::PoseBank& bank = *walker().banks[0];
  const scene::Character& character = *walker().characters[0];
  const PoseProbe probe(bank, choose_joint_points(character, bank, 6));
  const auto stale = [&](double threshold) { return pose_staleness(character, bank, probe, threshold); };
  EXPECT_NEAR(stale(0).refreshes, 60, 0.1);
  EXPECT_EQ(stale(0).rms, 0);
  EXPECT_LT(stale(0.1).refreshes, 0.7 * stale(0.03).refreshes);
  EXPECT_GT(stale(0.1).rms, 1.5 * stale(0.03).rms);
  EXPECT_EQ(stale(10).refreshes, 0);
}

TileStates states_of(const TileRules& rules, uint32_t pages = 8) {
  const scene::PoseBank& bank = *walker().banks[0];
  return {rules,
          {{{bank.bounds_min(), bank.bounds_max()},
            PoseProbe(bank, choose_joint_points(*walker().characters[0], bank, 6))}},
          pages};
}

// One agent, turned by `degrees`, seen from `distance`.
scene::Frame seen_agent(uint64_t tick, double degrees, double distance = 10, double phase = 0.1) {
  scene::Frame frame = frame_of_one(distance, 1.0, 200, 200, 20);
  frame.tick = tick;
  add_agent(frame, walker(), {0, 0, 0}, 3, phase, static_cast<float>(degrees / 360));
  return frame;
}

TEST(TileStates, TestsAngleSizeAndPose) {
  const TileRules rules{.pose = 0.05, .angle = 4 * kDegree, .size = 0.1};
  const auto refreshes = [&](const scene::Frame& first, const scene::Frame& second) {
    TileStates states = states_of(rules);
    states.begin(first);
    EXPECT_NE(states.update(first, 0, 0), nullptr);
    EXPECT_EQ(states.refreshes(), 1U);
    states.begin(second);
    EXPECT_NE(states.update(second, 0, 0), nullptr);
    return states.refreshes();
  };
  const scene::Frame first = seen_agent(5, 0);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0)), 0U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 3.8)), 0U) << "seen from nearly level: the angle is the heading's";
  EXPECT_EQ(refreshes(first, seen_agent(6, 4.2)), 1U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0, 10.9)), 0U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0, 11.2)), 1U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0, 8.9)), 1U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0, 10, 0.102)), 0U);
  EXPECT_EQ(refreshes(first, seen_agent(6, 0, 10, 0.3)), 1U);
  EXPECT_EQ(refreshes(first, seen_agent(6 + TileStates::kMostTicks, 0)), 1U) << "no continuation";
  EXPECT_EQ(refreshes(first, seen_agent(4, 0)), 1U);
  scene::Frame darker = seen_agent(6, 0);
  darker.light.diffuse *= 0.9F;
  EXPECT_EQ(refreshes(first, darker), 1U);
  scene::Frame dressed = seen_agent(6, 0);
  dressed.agents[0][0].outfit = 1;
  EXPECT_EQ(refreshes(first, dressed), 1U);
}

TEST(TileStates, TheSameFrameIsTheSameMoment) {
  TileStates states = states_of({.pose = 0.05, .angle = 4 * kDegree, .size = 0.1});
  for (int again = 0; again < 2; ++again) {
    states.begin(seen_agent(5, 0));
    EXPECT_NE(states.update(seen_agent(5, 0), 0, 0), nullptr);
    EXPECT_EQ(states.refreshes(), 1U);
  }
  EXPECT_EQ(states.tiles(), 1U);
  states.begin(seen_agent(5, 90));
  EXPECT_EQ(states.tiles(), 0U) << "another frame of the same tick: anew";
}

TEST(TileStates, WhoIsTooNearOrTooTallHasNoTile) {
  const TileRules rules{.pose = 0.05, .angle = 4 * kDegree, .size = 0.1, .largest = 100};
  TileStates states = states_of(rules);
  for (const auto& [distance, has] : {std::pair(0.5, false), std::pair(7.0, false), std::pair(14.0, true)}) {
    const scene::Frame frame = seen_agent(1, 0, distance);
    states.begin(frame);
    EXPECT_EQ(states.update(frame, 0, 0) != nullptr, has) << distance;
  }
}

class DynamicGl : public GlTest {};

scene::Frame tiled_row(uint64_t tick, double phase = 0, double slide = 0) {
  scene::Frame frame = frame_of_one(14, 1.2, 480, 96, 14);
  frame.tick = tick;
  for (uint32_t i = 0; i < 8; ++i)
    add_agent(frame, walker(), {1.1 * i - 4 + slide, 0, -0.2 * i}, i + 1, std::fmod(0.13 * i + phase, 1.0),
              0.1F * static_cast<float>(i), 0.8F + 0.03F * static_cast<float>(i));
  return frame;
}

Capture tiled(const scene::Frame& frame, const std::string& spec) {
  Renderer renderer(context(), walker());
  return renderer.capture(frame, *make(walker(), spec));
}

TEST_F(DynamicGl, FreshItIsTheMeshAgain) {
  const scene::Frame frame = tiled_row(0);
  const testing::Difference d = testing::difference(tiled(frame, "mesh"), tiled(frame, "dynamic"));
  EXPECT_GT(d.iou, 0.93);
  EXPECT_EQ(d.holes, 0);
  EXPECT_EQ(d.strays, 0);
  EXPECT_LT(d.mean_colour, 8);
  const testing::Difference fine = testing::difference(tiled(frame, "mesh"), tiled(frame, "dynamic:ratio=3"));
  EXPECT_GT(fine.iou, 0.95) << d.iou;
  EXPECT_LT(fine.mean_colour, d.mean_colour);
}

TEST_F(DynamicGl, WithinItsThresholdsItShowsWhatItShowed) {
  const auto one = make(walker(), "dynamic:pose=10,angle=90,size=10");
  EXPECT_TRUE(one->has_history());
  Renderer renderer(context(), walker());
  const Capture first = renderer.capture(tiled_row(0), *one);
  EXPECT_EQ(renderer.capture(tiled_row(1, 0.25), *one), first) << "another pose, the same tiles";
  EXPECT_NE(renderer.capture(tiled_row(2, 0.25, 0.5), *one), first) << "tiles move with their agents";
  EXPECT_EQ(renderer.capture(tiled_row(300, 0.25), *one), tiled(tiled_row(0, 0.25), "dynamic")) << "anew";
  const auto tight = make(walker(), "dynamic:pose=0.01");
  (void)renderer.capture(tiled_row(0), *tight);
  EXPECT_EQ(renderer.capture(tiled_row(1, 0.25), *tight), tiled(tiled_row(0, 0.25), "dynamic"));
}

TEST_F(DynamicGl, WithoutThresholdsThereIsNoHistory) {
  const std::string spec = "dynamic:pose=0,angle=0,size=0";
  const auto one = make(walker(), spec);
  EXPECT_FALSE(one->has_history());
  Renderer renderer(context(), walker());
  for (const uint64_t tick : {0, 1, 2, 1}) {
    const scene::Frame frame = tiled_row(tick, 0.003 * static_cast<double>(tick));
    EXPECT_EQ(renderer.capture(frame, *one), tiled(frame, spec)) << tick;
  }
}

TEST_F(DynamicGl, AdvancingIsDrawingWithoutAPicture) {
  const std::string spec = "dynamic:pose=0.1";
  const auto drawn = make(walker(), spec);
  const auto played = make(walker(), spec);
  Renderer renderer(context(), walker());
  const auto at = [](uint64_t tick) {
    return tiled_row(tick, 0.01 * static_cast<double>(tick), 0.01 * static_cast<double>(tick));
  };
  constexpr uint64_t kTick = 9;
  Capture expected;
  for (uint64_t tick = 0; tick <= kTick; ++tick) expected = renderer.capture(at(tick), *drawn);
  for (uint64_t tick = 0; tick < kTick; ++tick) played->advance(at(tick), all_agents(at(tick)));
  EXPECT_EQ(renderer.capture(at(kTick), *played), expected);
  EXPECT_NE(tiled(at(kTick), spec), expected) << "or this tests nothing";
}

TEST_F(DynamicGl, ListsInAnyOrderShowTheSame) {
  const scene::Frame frame = tiled_row(0);
  const Capture whole = tiled(frame, "dynamic");
  const auto one = make(walker(), "dynamic");
  Renderer renderer(context(), walker());
  const Target target(context(), frame.width, frame.height, {.ids = true});
  scene::Frame empty = frame;
  for (auto& agents : empty.agents) agents.clear();
  renderer.draw(empty, *one, target);
  renderer.resources().upload(frame);
  for (const AgentLists& list : std::vector<AgentLists>{{{5, 6}}, {{7}}, {{0, 1, 2}}, {{3, 4}}})
    one->draw(frame, renderer.resources(), list, target.pass());
  // Tiles lie elsewhere on their pages, where floats round otherwise.
  const Capture parts = target.read();
  EXPECT_LE(testing::different_ids(parts, whole), 4U);
  EXPECT_LT(testing::mean_colour_difference(parts, whole), 0.05);
}

// One page of 512 x 512 texels: the others are drawn as the mesh, and all are
// there.
TEST_F(DynamicGl, WhoFindsNoPlaceIsTheMesh) {
  CROWDBENCH_SKIP_SANITIZED("TileAtlas.KeepsWhatIsInUse");
  scene::Frame frame = frame_of_one(30, 1.2, 640, 480, 14);
  for (uint32_t i = 0; i < 120; ++i)
    add_agent(frame, walker(), {0.5 * (i % 20) - 5, 0, -1.0 * (i / 20)}, i + 1, 0.01 * i);
  const Capture test = tiled(frame, "dynamic:budget=1,ratio=2");
  const Capture mesh = tiled(frame, "mesh");
  std::map<uint32_t, std::pair<int, int>> pixels;
  for (const uint32_t id : mesh.ids.data) ++pixels[id].first;
  for (const uint32_t id : test.ids.data) ++pixels[id].second;
  EXPECT_GT(pixels.size(), 110U);
  for (const auto& [id, count] : pixels) EXPECT_NEAR(count.second, count.first, 8 + 0.2 * count.first) << id;
  EXPECT_GT(testing::iou(mesh, test), 0.97);
  EXPECT_NE(test.colour, mesh.colour);
  EXPECT_EQ(tiled(frame, "dynamic:largest=8"), mesh) << "who is too tall is the mesh";
}

TEST_F(DynamicGl, BytesAreTheBudgets) {
  const auto bytes = [](const char* spec) { return make(walker(), spec)->footprint().texture_bytes; };
  EXPECT_EQ(bytes("dynamic:budget=9") - bytes("dynamic:budget=4"), 5U << 20U);
  EXPECT_GT(fact(make(walker(), "dynamic")->bake_info().facts, "pose_refreshes_a_second"), 1);
}

}  // namespace
}  // namespace crowdbench::renderers
