#include "scene/pose/pose.h"

#include <gtest/gtest.h>

#include "scene/mannequin/mannequin.h"
#include "scene/pose/pose_some.h"
#include "tests/scene/tiny_character.h"

namespace crowdbench::scene {
namespace {

void expect_near(const glm::dvec3& got, const glm::dvec3& want, double tolerance = 1e-12) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], want[axis], tolerance) << "axis " << axis;
}

glm::dvec3 tip(const Character& c, int clip, double time) {
  return skin_positions(c.mesh, joint_matrices(c, clip, time))[1];
}

Character rotating(std::vector<double> times, std::vector<double> values,
                   Interpolation interpolation = Interpolation::linear) {
  Character c = tiny_character();
  c.clips = {one_channel("turn", {1, Target::rotation, interpolation, std::move(times), std::move(values)})};
  return c;
}

TEST(Pose, BindPoseLeavesTheMeshWhereItIs) {
  const Character c = tiny_character();
  const auto posed = skin_positions(c.mesh, joint_matrices(c, -1, 7.0));
  expect_near(posed[1], {0, 2, 0});
  expect_near(posed[2], {0, 2, 0.5});
}

TEST(Pose, OfSomeNodesIsThatOfAllToTheBit) {
  const Character c = make_mannequin({.triangles = 500, .joints = 20, .normalise = {}});
  const std::vector<Node>& nodes = c.skeleton.nodes;
  std::vector<bool> wanted(nodes.size(), false);
  for (int n = static_cast<int>(nodes.size()) - 1; n >= 0; n = nodes[static_cast<size_t>(n)].parent)
    wanted[static_cast<size_t>(n)] = true;
  const double time = 0.3 * c.clips[0].duration();
  const auto all = node_matrices(c, 0, time);
  const auto some = some_node_matrices(c, 0, time, wanted);
  size_t left_out = 0;
  for (size_t n = 0; n < nodes.size(); ++n) {
    EXPECT_EQ(some[n], wanted[n] ? all[n] : glm::dmat4(1.0)) << n;
    left_out += wanted[n] ? 0 : 1;
  }
  EXPECT_GT(left_out, 3U);
}

TEST(Pose, QuarterTurnOfTheSecondBoneByHand) {
  // +90 degrees about Z carries the arm's +Y to -X: (0, 1, 0) + (-1, 0, 0).
  const Character c = rotating({0.0}, {0, 0, kHalf, kHalf});
  expect_near(tip(c, 0, 0.0), {-1, 1, 0});
  // Its normal turns along: +X to +Y.
  const auto normals = skin_normals(c.mesh, joint_matrices(c, 0, 0.0));
  expect_near(normals[1], {0, 1, 0});
  expect_near(normals[0], {1, 0, 0});
}

TEST(Pose, TwoWeightsBlendTheTwoBones) {
  Character c = rotating({0.0}, {0, 0, kHalf, kHalf});
  c.mesh.joints[1] = {0, 1, 0, 0};
  c.mesh.weights[1] = {0.25F, 0.75F, 0, 0};
  expect_near(tip(c, 0, 0.0), {-0.75, 0.25 * 2.0 + 0.75 * 1.0, 0});
}

TEST(Pose, SlerpTakesEqualAnglesInEqualTimes) {
  // 0 to 90 degrees about Z: a third of the time is 30 degrees (a normalised linear blend would give 28.7).
  const Character c = rotating({0.0, 3.0}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  expect_near(tip(c, 0, 1.0), {-0.5, 1.0 + 0.86602540378443865, 0});
}

TEST(Pose, SlerpTakesTheShortArcFromAnOppositeQuaternion) {
  const Character c = rotating({0.0, 1.0}, {0, 0, 0, 1, 0, 0, -kHalf, -kHalf});
  expect_near(tip(c, 0, 0.5), {-kHalf, 1.0 + kHalf, 0});
}

TEST(Pose, SlerpBetweenEqualAndNegatedRotationsStands) {
  for (const double sign : {1.0, -1.0}) {
    const Character c = rotating({0.0, 1.0}, {0, 0, kHalf, kHalf, 0, 0, sign * kHalf, sign * kHalf});
    expect_near(tip(c, 0, 0.37), {-1, 1, 0});
  }
}

TEST(Pose, StepHoldsTheEarlierKey) {
  const Character c = rotating({0.0, 1.0}, {0, 0, 0, 1, 0, 0, kHalf, kHalf}, Interpolation::step);
  expect_near(tip(c, 0, 0.999), {0, 2, 0});
  expect_near(tip(c, 0, 1.0), {-1, 1, 0});
}

TEST(Pose, CubicSplineMidpointByHand) {
  // x from 0 (out-tangent 2 a second) to 4 (in-tangent 0) over 2 s. At the middle the Hermite weights are 1/2, 1/8,
  // 1/2, -1/8, tangents times the interval: 0 + (1/8)(2)(2) + (1/2)(4) - 0 = 2.5.
  Character c = tiny_character();
  c.clips = {one_channel("spline", {0,
                                    Target::translation,
                                    Interpolation::cubic_spline,
                                    {1.0, 3.0},
                                    {9, 9, 9, 0, 0, 0, 2, 0, 0, /* in, value, out */ 0, 0, 0, 4, 0, 0, 9, 9, 9}})};
  expect_near(tip(c, 0, 2.0), {2.5, 2, 0});
  expect_near(tip(c, 0, 1.0), {0, 2, 0});
  expect_near(tip(c, 0, 3.0), {4, 2, 0});
}

TEST(Pose, CubicSplineRotationsAreRenormalised) {
  // Keys 0 and 90 degrees, no tangents: the middle is the normalised mean, 45 degrees.
  const Character c =
      rotating({0.0, 1.0}, {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kHalf, kHalf, 0, 0, 0, 0},
               Interpolation::cubic_spline);
  expect_near(tip(c, 0, 0.5), {-kHalf, 1.0 + kHalf, 0});
}

TEST(Pose, EveryChannelClampsToItsOwnKeys) {
  Character c = tiny_character();
  Clip clip = one_channel("late", {0, Target::translation, Interpolation::linear, {1.0, 2.0}, {1, 0, 0, 2, 0, 0}});
  clip.channels.push_back({1, Target::scale, Interpolation::linear, {0.0, 4.0}, {1, 1, 1, 1, 5, 1}});
  clip.start = 0.0;
  clip.end = 4.0;
  c.clips = {clip};
  expect_near(tip(c, 0, 0.5), {1, 1 + 1.5, 0});  // the translation waits at its first key, the scale runs
  expect_near(tip(c, 0, 3.0), {2, 1 + 4.0, 0});  // and stays at its last
  expect_near(tip(c, 0, -5.0), {1, 2, 0});
  expect_near(tip(c, 0, 99.0), {2, 6, 0});
}

TEST(Pose, AMatrixNodeIsTakenAsItIs) {
  Character c = tiny_character();
  c.skeleton.nodes[0].has_matrix = true;
  c.skeleton.nodes[0].matrix = glm::dmat4(0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 5, 0, 0, 1);  // columns
  const auto posed = skin_positions(c.mesh, joint_matrices(c, -1, 0.0));
  expect_near(posed[2], {5 + 2 * 0.5, 4, 0});
}

}  // namespace
}  // namespace crowdbench::scene
