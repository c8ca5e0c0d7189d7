#include "scene/pose/normalise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "scene/pose/pose.h"
#include "tests/scene/tiny_character.h"

namespace crowdbench::scene {
namespace {

Clip sway(const std::string& name, double amplitude, double seconds = 1.0) {
  return one_channel(name, {0,
                            Target::translation,
                            Interpolation::linear,
                            {0.0, 0.5 * seconds, seconds},
                            {0, 0, 0, amplitude, 0, 0, 0, 0, 0}});
}

Clip still(const std::string& name) {
  return one_channel(name, {0, Target::translation, Interpolation::linear, {0.0}, {0, 0, 0}});
}

Character with(std::vector<Clip> clips) {
  Character c = tiny_character();
  c.clips = std::move(clips);
  normalise(c, {});
  return c;
}

TEST(Normalise, DefaultClipIsTheFirstThatWalks) {
  EXPECT_EQ(with({sway("Run", 1), sway("Slow_WALKING", 0), sway("walk", 1)}).placement.default_clip, 1);
  EXPECT_EQ(with({still("walk pose"), sway("idle", 0), sway("run", 1)}).placement.default_clip, 2);  // moves the feet
  EXPECT_EQ(with({still("pose"), sway("breathe", 0), sway("breathe", 0)}).placement.default_clip, 1);
  EXPECT_EQ(with({still("pose")}).placement.default_clip, -1);
  EXPECT_EQ(with({}).placement.default_clip, -1);
}

TEST(Normalise, ScalesThePosedHeightAndStandsOnThePivot) {
  // The root stands at x = 3 and its swing of 1 has the mean 1/2; it hovers at y = 4. The figure is 2 tall.
  Character c = tiny_character();
  c.clips = {one_channel(
      "walk", {0, Target::translation, Interpolation::linear, {0.0, 1.0, 2.0}, {3, 4, -1, 4, 4, -1, 3, 4, -1}})};
  normalise(c, {});
  EXPECT_NEAR(c.placement.scale, 0.875, 1e-9);
  EXPECT_NEAR(c.placement.height, 1.75, 1e-9);
  const glm::dvec4 foot = c.placement.model_from_gltf * glm::dvec4(3.5, 4.0, -1.0, 1.0);
  EXPECT_NEAR(foot.x, 0.0, 1e-6);
  EXPECT_NEAR(foot.y, 0.0, 1e-6);
  EXPECT_NEAR(foot.z, 0.0, 1e-6);
  const auto posed = skin_positions(c.mesh, model_matrices(c, 0, 0.5));
  EXPECT_NEAR(posed[0].x, 0.5 * 0.875, 1e-6);
  EXPECT_NEAR(posed[1].y, 1.75, 1e-6);
}

TEST(Normalise, AsIsIsTheIdentity) {
  Character c = tiny_character();
  c.clips = {sway("walk", 0.5)};
  normalise(c, {std::nullopt});
  EXPECT_EQ(c.placement.model_from_gltf, glm::dmat4(1.0));
  EXPECT_NEAR(c.placement.height, 2.0, 1e-9);
}

TEST(Normalise, StripsTheRootsTravelAndCallsItGroundSpeed) {
  // 3 units forwards and 1 up in 2 s, at a scale of 0.875: 1.3125 m/s; the rise stays.
  Character c = tiny_character();
  c.clips = {one_channel(
      "walk", {0, Target::translation, Interpolation::linear, {0.0, 1.0, 2.0}, {0, 0, 0, 0, 1, 2.5, 0, 0, 3}})};
  normalise(c, {});
  EXPECT_NEAR(c.motion[0].ground_speed, 3.0 * 0.875 / 2.0, 1e-6);
  EXPECT_FALSE(c.motion[0].from_stance);
  EXPECT_EQ(c.motion[0].closing_seconds, 0.0);
  EXPECT_NEAR(c.motion[0].root_displacement.z, 3.0 * 0.875, 1e-9);
  const auto start = skin_positions(c.mesh, model_matrices(c, 0, 0.0));
  const auto middle = skin_positions(c.mesh, model_matrices(c, 0, 0.5));
  const auto end = skin_positions(c.mesh, model_matrices(c, 0, 1.0));
  EXPECT_NEAR(end[0].z, start[0].z, 1e-9);
  EXPECT_NEAR(middle[0].z - start[0].z, (2.5 - 1.5) * 0.875, 1e-9);
  EXPECT_NEAR(middle[0].y - start[0].y, 0.875, 1e-9);
}

TEST(Normalise, ALoopThatDoesNotRepeatItsFirstKeyIsClosedByOneInterval) {
  // A full turn in four quarter keys: 0, 90, 180, 270 degrees about Z. The cycle lasts one more interval, in which 270
  // goes on to 360.
  Character c = tiny_character();
  c.clips = {one_channel("spin", {1,
                                  Target::rotation,
                                  Interpolation::linear,
                                  {1.0, 1.25, 1.5, 1.75},
                                  {0, 0, 0, 1, 0, 0, kHalf, kHalf, 0, 0, 1, 0, 0, 0, kHalf, -kHalf}})};
  normalise(c, {std::nullopt});
  EXPECT_NEAR(c.motion[0].closing_seconds, 0.25, 1e-12);
  EXPECT_NEAR(cycle_seconds(c, 0), 1.0, 1e-12);
  const auto at = [&](double phase) { return skin_positions(c.mesh, model_matrices(c, 0, phase))[1]; };
  EXPECT_NEAR(at(0.75).x, 1.0, 1e-12);  // 270 degrees
  EXPECT_NEAR(at(0.875).x, kHalf, 1e-12);
  EXPECT_NEAR(at(0.875).y, 1.0 + kHalf, 1e-12);
  EXPECT_NEAR(at(1.0).y, 2.0, 1e-12);
  EXPECT_NEAR(phase_of_time(c, 0, 1.5), 0.5, 1e-12);
  EXPECT_NEAR(phase_of_time(c, 0, 1.75), 0.75, 1e-12);
  EXPECT_EQ(phase_of_time(c, 0, -3.0), 0.0);
  // A clip that must not wrap is left alone.
  c.clips[0].loops = false;
  normalise(c, {std::nullopt});
  EXPECT_EQ(cycle_seconds(c, 0), 0.75);
  EXPECT_LT(phase_of_time(c, 0, 9.0), 1.0);
  EXPECT_GT(phase_of_time(c, 0, 9.0), 0.999);
}

TEST(Normalise, AClipOfZeroLengthIsAStillPose) {
  Character c = with({still("pose")});
  EXPECT_EQ(cycle_seconds(c, 0), 0.0);
  EXPECT_EQ(phase_of_time(c, 0, 3.0), 0.0);
  EXPECT_EQ(model_matrices(c, 0, 0.7), model_matrices(c, -1, 0.0));
}

TEST(Normalise, StanceFootGivesTheGroundSpeedOfAWalkInPlace) {
  // Vertex 0 is the sole: back by 1.2 units on the ground for 0.6 s, then lifted forwards for 0.4 s.
  Character c = tiny_character();
  c.skeleton.nodes.push_back({});
  c.skeleton.nodes[2].parent = 0;
  c.skeleton.joints.push_back({});
  c.skeleton.joints[2].node = 2;
  c.mesh.joints[0] = {2, 0, 0, 0};
  c.clips = {one_channel("step", {2,
                                  Target::translation,
                                  Interpolation::linear,
                                  {0.0, 0.6, 0.8, 1.0},
                                  {0, 0, 0.6, 0, 0, -0.6, 0, 0.5, 0, 0, 0, 0.6}})};
  normalise(c, {std::nullopt});
  EXPECT_TRUE(c.motion[0].from_stance);
  EXPECT_NEAR(c.motion[0].ground_speed, 2.0, 1e-6);
}

TEST(Normalise, ContentHashFollowsWhatABakeDependsOn) {
  Character c = with({sway("walk", 1)});
  const std::string hash = c.content_hash;
  EXPECT_EQ(hash.size(), 64u);
  EXPECT_EQ(compute_content_hash(c), hash);
  Character renamed = c;
  renamed.name = renamed.source = "elsewhere";
  EXPECT_EQ(compute_content_hash(renamed), hash);
  Character other = c;
  other.mesh.positions[1].x += 1e-4F;
  EXPECT_NE(compute_content_hash(other), hash);
  other = c;
  other.clips[0].channels[0].values[3] += 1e-9;
  EXPECT_NE(compute_content_hash(other), hash);
  other = c;
  other.materials[0].slot = 3;
  EXPECT_NE(compute_content_hash(other), hash);
}

TEST(Clips, ANameWinsOverAnIndex) {
  Character c = with({sway("1", 1), sway("b", 1)});
  EXPECT_EQ(find_clip(c, "1"), 0);
  EXPECT_EQ(find_clip(c, "0"), 0);
  EXPECT_EQ(find_clip(c, "b"), 1);
  EXPECT_EQ(find_clip(c, "2"), std::nullopt);
  EXPECT_EQ(find_clip(c, "-1"), std::nullopt);
  EXPECT_EQ(find_clip(c, "99999999999999999999"), std::nullopt);
  EXPECT_EQ(find_clip(c, ""), std::nullopt);
  try {
    require_clip(c, "run");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("1, b"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace crowdbench::scene
