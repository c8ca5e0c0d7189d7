#include "scene/pose/normalise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "scene/character/take_apart.h"
#include "scene/pose/pose.h"
#include "scene/pose/reach.h"
#include "scene/pose/visible.h"
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

// ---- what loading does before

glm::dmat4 transform_of(const Node& node) {
  glm::dmat4 out = glm::mat4_cast(node.rotation);
  for (int i = 0; i < 3; ++i) out[i] *= node.scale[i];
  out[3] = glm::dvec4(node.translation, 1.0);
  return out;
}

Node matrix_node(const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z, const glm::dvec3& place) {
  Node node;
  node.has_matrix = true;
  node.matrix = glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(place, 1));
  return node;
}

TEST(TakeApart, AQuarterTurnScaledAndMoved) {
  // About y by 90 degrees: x goes to -z and z to x; scaled by 2, 3 and 4 before.
  Node node = matrix_node({0, 0, -2}, {0, 3, 0}, {4, 0, 0}, {5, 6, 7});
  ASSERT_TRUE(take_apart(node));
  EXPECT_FALSE(node.has_matrix);
  EXPECT_EQ(node.matrix, glm::dmat4(1.0));
  EXPECT_EQ(node.translation, glm::dvec3(5, 6, 7));
  EXPECT_EQ(node.scale, glm::dvec3(2, 3, 4));
  EXPECT_NEAR(node.rotation.w, kHalf, 1e-15);
  EXPECT_NEAR(node.rotation.y, kHalf, 1e-15);
  EXPECT_NEAR(node.rotation.x, 0, 1e-15);
  EXPECT_NEAR(node.rotation.z, 0, 1e-15);
}

TEST(TakeApart, AMirrorBecomesANegativeScaleInX) {
  Node node = matrix_node({2, 0, 0}, {0, -3, 0}, {0, 0, 4}, {0, 0, 0});
  const glm::dmat4 wanted = node.matrix;
  ASSERT_TRUE(take_apart(node));
  EXPECT_EQ(node.scale, glm::dvec3(-2, 3, 4));
  const glm::dmat4 got = transform_of(node);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(got[i][j], wanted[i][j], 1e-14) << i << j;
}

TEST(TakeApart, ShearAndNoVolumeStayAsTheyAre) {
  for (Node node :
       {matrix_node({1, 0, 0}, {1, 1, 0}, {0, 0, 1}, {}), matrix_node({1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {})}) {
    const glm::dmat4 before = node.matrix;
    EXPECT_FALSE(take_apart(node));
    EXPECT_TRUE(node.has_matrix);
    EXPECT_EQ(node.matrix, before);
  }
  Node plain;
  plain.translation = {1, 2, 3};
  EXPECT_TRUE(take_apart(plain)) << "without a matrix there is nothing to do";
  EXPECT_EQ(plain.translation, glm::dvec3(1, 2, 3));
}

// The arm stands 1 above the root, and each step counts twice: a bound, as a cube's corner lies beyond its faces.
TEST(Reach, ABoundOfScalesAndDistancesDownTheHierarchy) {
  Character c = tiny_character();
  EXPECT_EQ(node_beyond_reach(c, 2), std::nullopt) << "0 + 2 * 1 * 1";
  EXPECT_EQ(node_beyond_reach(c, 1.99), 1U);
  EXPECT_EQ(node_beyond_reach(c, 0.5), 0U) << "the root's own scale is 1";
  // A clip that makes the root three times as large takes the arm along: 2 * 3 * 1.
  c.clips = {one_channel("grow", {0, Target::scale, Interpolation::linear, {0.0, 1.0}, {1, 1, 1, 1, -3, 1}})};
  EXPECT_EQ(node_beyond_reach(c, 6), std::nullopt);
  EXPECT_EQ(node_beyond_reach(c, 5.99), 1U);
  EXPECT_EQ(node_beyond_reach(c, 2.99), 0U);
  // The tangents of a spline count by the time between keys: twice over one second.
  c.clips = {one_channel("sway", {1,
                                  Target::translation,
                                  Interpolation::cubic_spline,
                                  {0.0, 1.0},
                                  {0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0}})};
  EXPECT_EQ(node_beyond_reach(c, 8), std::nullopt) << "2 * 1 * (2 * 2)";
  EXPECT_EQ(node_beyond_reach(c, 7.99), 1U);
  // Rotations reach nowhere, and no bound holds what is not a number.
  c.clips = {one_channel("turn", {1, Target::rotation, Interpolation::step, {0.0}, {100, 0, 0, 0}})};
  EXPECT_EQ(node_beyond_reach(c, 2), std::nullopt);
  c.skeleton.nodes[1].translation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(node_beyond_reach(c, 1e300), 1U);
  c.skeleton.nodes[0].scale.x = std::numeric_limits<double>::infinity();
  EXPECT_EQ(node_beyond_reach(c, 1e300), 0U);
  EXPECT_EQ(node_beyond_reach(Character{}, 1), std::nullopt);
}

TEST(Visible, DropsWhatNoPoseShowsAndNeverAll) {
  Character c = tiny_character();
  EXPECT_EQ(drop_invisible(c).removed, 0U);
  // A triangle without area beside the one that has some.
  c.mesh.indices = {0, 1, 2, 0, 1, 1};
  c.mesh.primitives[0].index_count = 6;
  EXPECT_EQ(drop_invisible(c).removed, 1U);
  EXPECT_EQ(c.mesh.indices, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(c.mesh.primitives[0].index_count, 3U);
  // Flat in the bind pose, and opened by a clip that moves the arm away from the root's vertex: it stays.
  c.mesh.positions[2] = {0, 1, 0};
  c.mesh.joints[2] = {0, 0, 0, 0};
  Character opened = c;
  opened.clips = {one_channel("open", {1, Target::translation, Interpolation::linear, {0.0, 1.0}, {0, 1, 0, 1, 1, 0}})};
  opened.mesh.indices = {0, 1, 2, 0, 1, 1};
  opened.mesh.primitives[0].index_count = 6;
  EXPECT_EQ(drop_invisible(opened).removed, 1U) << "the other one";
  EXPECT_EQ(opened.mesh.indices, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(drop_invisible(c).removed, 0U) << "nothing would be left";
  EXPECT_TRUE(drop_invisible(c).all) << "without area, whatever its material";
  EXPECT_FALSE(drop_invisible(opened).all);
  EXPECT_EQ(c.mesh.indices.size(), 3U);
}

TEST(Visible, AMaskThatLeavesNothing) {
  Character c = tiny_character();
  EXPECT_FALSE(drop_invisible(c).all);
  c.materials[0].alpha_cutoff = 0.5F;
  c.materials[0].base_colour.a = 0.5F;
  EXPECT_FALSE(drop_invisible(c).all) << "alpha 0.5 passes a cutoff of 0.5";
  c.materials[0].base_colour.a = 0.25F;
  EXPECT_TRUE(drop_invisible(c).all);
}

}  // namespace
}  // namespace crowdbench::scene
