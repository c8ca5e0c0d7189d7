#include "bench/commands/viewer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace crowdbench::bench {
namespace {

const scene::Camera kStart{{3.0, 4.0, 12.0}, {0.0, 1.0, 0.0}, {0.0, 1.0, 0.0}, 0.6};

gl::WindowInput keys(const std::u32string& typed) {
  gl::WindowInput input;
  input.keys = typed;
  return input;
}

ViewerState start_state() {
  ViewerState state;
  state.orbit = orbit_of(kStart);
  return state;
}

// Where a point stands in the picture, pixels from its middle, x to the right and y down.
glm::dvec2 project(const glm::dvec3& point, const scene::Camera& camera, int rows) {
  const glm::dvec3 eye = scene::view_rotation(camera) * (point - camera.eye);
  const double pixels = rows / (2 * std::tan(camera.fov_y / 2)) / -eye.z;
  return {eye.x * pixels, -eye.y * pixels};
}

TEST(Viewer, OrbitStartsAtTheCamera) {
  const scene::Camera camera = camera_of(orbit_of(kStart), kStart);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(camera.eye[axis], kStart.eye[axis], 1e-12) << axis;
  EXPECT_EQ(camera.target, kStart.target);
  EXPECT_EQ(camera.fov_y, kStart.fov_y);
}

TEST(Viewer, DraggingRightTurnsTheNearSideRight) {
  ViewerState state = start_state();
  const glm::dvec3 near_point = state.orbit.target + 0.1 * (kStart.eye - kStart.target);
  const double before = project(near_point, camera_of(state.orbit, kStart), 480).x;
  gl::WindowInput input;
  input.left_x = 20;
  apply_input(state, input, 1, 480, kStart);
  EXPECT_GT(project(near_point, camera_of(state.orbit, kStart), 480).x, before);
  EXPECT_DOUBLE_EQ(glm::length(camera_of(state.orbit, kStart).eye - kStart.target), state.orbit.distance);
  input.left_x = 0;
  input.left_y = 1e6;  // straight up is never reached
  apply_input(state, input, 1, 480, kStart);
  EXPECT_LT(state.orbit.elevation, 1.5707);
  EXPECT_GT(state.orbit.elevation, 1.5);
}

TEST(Viewer, PanningMovesTheTargetWithTheCursor) {
  ViewerState state = start_state();
  const glm::dvec3 was = state.orbit.target;
  gl::WindowInput input;
  input.right_x = 37;
  input.right_y = -21;
  apply_input(state, input, 1, 480, kStart);
  const glm::dvec2 now = project(was, camera_of(state.orbit, kStart), 480);
  EXPECT_NEAR(now.x, 37, 1e-9);
  EXPECT_NEAR(now.y, -21, 1e-9);
}

TEST(Viewer, WheelZooms) {
  ViewerState state = start_state();
  const double before = state.orbit.distance;
  gl::WindowInput input;
  input.wheel = 2;
  apply_input(state, input, 1, 480, kStart);
  EXPECT_LT(state.orbit.distance, before);
  input.wheel = -2;
  apply_input(state, input, 1, 480, kStart);
  EXPECT_NEAR(state.orbit.distance, before, 1e-12);
}

TEST(Viewer, KeysDoWhatTheHelpSays) {
  ViewerState state = start_state();
  apply_input(state, keys(U" "), 3, 480, kStart);
  EXPECT_TRUE(state.paused);
  apply_input(state, keys(U" "), 3, 480, kStart);
  EXPECT_FALSE(state.paused);
  apply_input(state, keys(U".."), 3, 480, kStart);
  EXPECT_TRUE(state.paused);
  EXPECT_EQ(state.tick, 2U);
  apply_input(state, keys(U"3"), 3, 480, kStart);
  EXPECT_EQ(state.current, 2U);
  EXPECT_EQ(state.beside, 0U);
  apply_input(state, keys(U"4"), 3, 480, kStart);  // there are three
  EXPECT_EQ(state.current, 2U);
  apply_input(state, keys(U"2s"), 3, 480, kStart);
  EXPECT_EQ(state.current, 1U);
  EXPECT_EQ(state.beside, 2U);
  EXPECT_TRUE(state.side_by_side);
  apply_input(state, keys(U"h"), 3, 480, kStart);
  EXPECT_FALSE(state.help);
  EXPECT_FALSE(state.quit);
  apply_input(state, keys(U"\x1b"), 3, 480, kStart);
  EXPECT_TRUE(state.quit);
}

TEST(Viewer, TitleSaysWhatIsShown) {
  ViewerState state = start_state();
  state.tick = 42;
  EXPECT_EQ(viewer_title(state, {"mesh", "flat"}, 100), "crowdbench: mesh | 100 agents | tick 42");
  state.paused = state.side_by_side = true;
  state.current = 1;
  EXPECT_EQ(viewer_title(state, {"mesh", "flat"}, 100),
            "crowdbench: mesh, flat (left, right) | 100 agents | tick 42 (paused)");
}

TEST(Viewer, SideBySideKeepsBothPictures) {
  Image8 left(2, 1, 4);
  Image8 right(1, 1, 4);
  left.data = {1, 2, 3, 255, 4, 5, 6, 255};
  right.data = {7, 8, 9, 255};
  const Image8 both = beside_each_other(left, right);
  EXPECT_EQ(both.width, 5);
  EXPECT_EQ(both.data,
            (std::vector<uint8_t>{1, 2, 3, 255, 4, 5, 6, 255, 255, 255, 255, 255, 255, 255, 255, 255, 7, 8, 9, 255}));
}

TEST(Viewer, HelpStaysInsideAnyPicture) {
  for (const int side : {1, 40, 600}) {
    Image8 picture(side, side, 4);
    std::fill(picture.data.begin(), picture.data.end(), uint8_t{128});
    draw_help(picture, {"mesh", "flat"});
    EXPECT_NE(*picture.at(0, 0), 128);
    EXPECT_EQ(*picture.at(side - 1, side - 1) == 128, side == 600);
  }
}

}  // namespace
}  // namespace crowdbench::bench
