#include "scene/frame/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/colour.h"
#include "scene/frame/frame.h"
#include "scene/frame/light.h"

namespace crowdbench::scene {
namespace {

constexpr double kPi = 3.14159265358979323846;

glm::dvec3 ndc(const Camera& camera, double aspect, const glm::dvec3& world) {
  const glm::dvec4 clip = projection(camera, aspect) * glm::dvec4(view_rotation(camera) * (world - camera.eye), 1.0);
  return glm::dvec3(clip) / clip.w;
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

TEST(Camera, LooksAlongMinusZWithXRightAndYUp) {
  Camera camera;
  camera.eye = {0.0, 0.0, 5.0};
  camera.target = {0.0, 0.0, 0.0};
  const glm::dmat3 rotation = view_rotation(camera);
  expect_near(rotation * glm::dvec3(1, 0, 0), {1, 0, 0}, 1e-15);
  expect_near(rotation * glm::dvec3(0, 1, 0), {0, 1, 0}, 1e-15);
  expect_near(rotation * glm::dvec3(0, 0, -1), {0, 0, -1}, 1e-15);
}

TEST(Camera, FromTheRightOfTheSceneMinusZIsOnTheRight) {
  Camera camera;
  camera.eye = {5.0, 0.0, 0.0};
  camera.target = {0.0, 0.0, 0.0};
  expect_near(view_rotation(camera) * glm::dvec3(0, 0, -1), {1, 0, 0}, 1e-15);
}

TEST(Camera, ProjectsAPointByHand) {
  // fov 90 degrees: the picture's edge is as far out as the point is deep. 2 right, 1 up, 4 deep, aspect 2.
  Camera camera;
  camera.eye = {10.0, 20.0, 30.0};
  camera.target = {10.0, 20.0, 0.0};
  camera.fov_y = kPi / 2;
  camera.near = 0.5;
  expect_near(ndc(camera, 2.0, {12.0, 21.0, 26.0}), {2.0 / 4 / 2, 1.0 / 4, 0.5 / 4}, 1e-14);
}

TEST(Camera, ReversedDepthIsOneAtNearAndNearOverDepthToInfinity) {
  Camera camera;
  camera.eye = {0, 0, 0};
  camera.target = {0, 0, -1};
  camera.near = 0.25;
  EXPECT_DOUBLE_EQ(ndc(camera, 1.0, {0, 0, -0.25}).z, 1.0);
  EXPECT_DOUBLE_EQ(ndc(camera, 1.0, {0, 0, -1.0}).z, 0.25);
  EXPECT_DOUBLE_EQ(ndc(camera, 1.0, {0, 0, -1e6}).z, 0.25e-6);
  EXPECT_GT(ndc(camera, 1.0, {0, 0, -1e12}).z, 0.0);
}

TEST(Camera, ReversedDepthIsZeroAtAFiniteFarPlane) {
  Camera camera;
  camera.eye = {0, 0, 0};
  camera.target = {0, 0, -1};
  camera.near = 1.0;
  camera.far = 101.0;
  EXPECT_NEAR(ndc(camera, 1.0, {0, 0, -1}).z, 1.0, 1e-15);
  EXPECT_NEAR(ndc(camera, 1.0, {0, 0, -101}).z, 0.0, 1e-15);
  // n / (f - n) * (f / d - 1) at d = 2: 1/100 * (50.5 - 1)
  EXPECT_NEAR(ndc(camera, 1.0, {0, 0, -2}).z, 0.495, 1e-15);
}

TEST(Camera, StraightDownHasMinusZUpAndStraightUpHasPlusZ) {
  Camera camera;
  camera.eye = {0, 10, 0};
  camera.target = {0, 0, 0};
  expect_near(view_rotation(camera) * glm::dvec3(0, 0, -1), {0, 1, 0}, 1e-15);
  expect_near(view_rotation(camera) * glm::dvec3(1, 0, 0), {1, 0, 0}, 1e-15);
  camera.target = {0, 20, 0};
  expect_near(view_rotation(camera) * glm::dvec3(0, 0, 1), {0, 1, 0}, 1e-15);
}

TEST(Camera, EveryDegenerateViewStillGivesARotation) {
  for (const glm::dvec3& target : {glm::dvec3{0, 0, 0}, {0, 0, 3}, {0, 0, -3}, {0, 7, 0}, {1e-300, 0, 0}})
    for (const glm::dvec3& up : {glm::dvec3{0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {1e-200, 0, 0}}) {
      Camera camera;
      camera.eye = {0, 0, 0};
      camera.target = target;
      camera.up = up;
      const glm::dmat3 rotation = view_rotation(camera);
      EXPECT_NEAR(glm::determinant(rotation), 1.0, 1e-12);
      const glm::dmat3 product = rotation * glm::transpose(rotation);
      for (int i = 0; i < 3; ++i) expect_near(product[i], glm::dmat3(1.0)[i], 1e-12);
    }
}

TEST(Camera, PixelSizeIsTheViewsHeightOverItsRows) {
  Camera camera;
  camera.fov_y = kPi / 2;
  EXPECT_NEAR(pixel_size_at(camera, 10.0, 100), 0.2, 1e-15);
  camera.fov_y = 1e-6;
  EXPECT_NEAR(pixel_size_at(camera, 10.0, 1), 1e-5, 1e-17);
}

TEST(CameraPath, IsLinearBetweenKeysAndClampedOutside) {
  CameraPath path;
  path.keys = {{1.0, Camera{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.5, 0.1}},
               {3.0, Camera{{4, 8, 0}, {2, 0, -1}, {0, 0, 1}, 1.5, 0.2}}};
  EXPECT_EQ(path.at(0.0), path.keys[0].camera);
  EXPECT_EQ(path.at(1.0), path.keys[0].camera);
  EXPECT_EQ(path.at(3.0), path.keys[1].camera);
  EXPECT_EQ(path.at(9.0), path.keys[1].camera);
  const Camera middle = path.at(1.5);
  expect_near(middle.eye, {1, 2, 0}, 1e-15);
  expect_near(middle.target, {0.5, 0, -1}, 1e-15);
  EXPECT_DOUBLE_EQ(middle.fov_y, 0.75);
  EXPECT_EQ(middle.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(middle.near, 0.1);
}

// What the header says of a light that nobody sets: towards (0.4, 0.8, 0.45), and 1 on a surface that faces it.
TEST(Light, TheDefaultComesFromAboveTheFrontAndTheLeft) {
  const Light light;
  expect_near(glm::normalize(glm::dvec3(light.direction)), glm::normalize(glm::dvec3(0.4, 0.8, 0.45)), 1e-5);
  EXPECT_EQ(light.ambient + light.diffuse, 1.0F);
  Light other = light;
  EXPECT_EQ(other, light);
  other.direction.x += 1;
  EXPECT_NE(other, light);
}

TEST(Frame, TheDefaultBackgroundIsTheMiddleCodeValueAndAnAgentFacesPlusZ) {
  const Frame frame;
  for (int c = 0; c < 3; ++c) EXPECT_EQ(linear_to_srgb8(frame.background[c]), 128) << c;
  EXPECT_EQ(frame.background.a, 1.0F);
  EXPECT_TRUE(frame.agents.empty());
  EXPECT_EQ(frame.antialiasing, (Antialiasing{1, 1}));
  const FrameAgent agent;
  EXPECT_EQ(agent.heading, glm::vec2(0, 1));  // (sin, cos) of 0: model +Z maps to world (sin, 0, cos)
  EXPECT_EQ(agent.id, 1U) << "0 is nothing in an id buffer";
}

}  // namespace
}  // namespace crowdbench::scene
