// Other depth buffers than the usual one: what is stored, and that the usual one draws the usual picture.
#include "renderers/frame/depth_storage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

class DepthStorageGl : public GlTest {};

constexpr DepthFormat kAll[] = {DepthFormat::fixed16, DepthFormat::fixed24, DepthFormat::float32};

TEST(DepthStorage, TheUsualOneIsTheProjectionOfEveryPicture) {
  scene::Camera camera;
  for (const double far : {0.0, 50.0, 1e6}) {
    camera.far = far;
    const StoredDepth stored = stored_depth(camera, {});
    const glm::dmat4 projection = scene::projection(camera, 1.5);
    EXPECT_NEAR(-stored.offset, projection[2][2], 1e-15);
    EXPECT_NEAR(stored.slope, projection[3][2], 1e-15);
  }
}

TEST(DepthStorage, PlanesAreTheEndsOfWhatIsStored) {
  scene::Camera camera;
  camera.near = 1e-3;
  for (const double far : {0.0, 1e6})
    for (const bool reversed : {false, true}) {
      camera.far = far;
      const StoredDepth stored = stored_depth(camera, {DepthFormat::fixed24, reversed});
      EXPECT_NEAR(stored.at(camera.near), reversed ? 1 : 0, 1e-12);
      EXPECT_NEAR(stored.at(far > 0 ? far : 1e30), reversed ? 0 : 1, 1e-12);
      EXPECT_NEAR(stored.metres(stored.at(3.0)), 3, 1e-9);
    }
}

TEST(DepthStorage, StepsAreThoseOfTheFormat) {
  EXPECT_DOUBLE_EQ(stored_step({DepthFormat::fixed16, true}, 0.3), 1 / 65535.0);
  EXPECT_DOUBLE_EQ(stored_step({DepthFormat::fixed24, false}, 1e-6), 1 / 16777215.0);
  EXPECT_EQ(stored_step({DepthFormat::float32, true}, 0.75), 0x1p-24);
  EXPECT_EQ(stored_step({DepthFormat::float32, true}, 0x1p-20), 0x1p-43);
}

TEST_F(DepthStorageGl, TheUsualOneDrawsTheUsualPicture) {
  const scene::Cast& cast = testing::walker();
  scene::Frame frame = frame_of_one(5, 1.2, 96, 72, 40);
  add_agent(frame, cast, {0, 0, 0}, 1);
  add_agent(frame, cast, {0.2, 0, -1}, 2, 0.3);
  const auto mesh = testing::make(cast, reference_spec().text());
  Renderer renderer(context(), cast);
  const Capture usual = renderer.capture(frame, *mesh);
  EXPECT_EQ(capture_stored(context(), renderer, frame, *mesh, {}), usual);
  // A metre between two walkers is more than a step of any of them at 5 m.
  for (const DepthFormat format : kAll)
    for (const bool reversed : {false, true}) {
      const Capture other = capture_stored(context(), renderer, frame, *mesh, {format, reversed});
      size_t different = 0;
      double worst = 0;
      for (size_t i = 0; i < usual.ids.data.size(); ++i) {
        different += other.ids.data[i] != usual.ids.data[i] ? 1U : 0U;
        if (usual.ids.data[i] != 0)
          worst = std::max(worst, std::abs(static_cast<double>(other.depth.data[i] - usual.depth.data[i])));
      }
      EXPECT_EQ(different, 0U);
      // d^2 / near of a step.
      EXPECT_LT(worst, format == DepthFormat::fixed16 ? 36 / 0.1 / 65535 : 1e-3);
    }
}

TEST_F(DepthStorageGl, WhoSetsADepthFunctionIsRefusedTheOtherDirection) {
  const scene::Cast& cast = testing::walker();
  scene::Frame frame = frame_of_one(5, 1, 32, 24, 40);
  add_agent(frame, cast, {0, 0, 0}, 1);
  const auto twice = testing::make(cast, reference_spec().text() + ":passes=2");
  Renderer renderer(context(), cast);
  EXPECT_NO_THROW(capture_stored(context(), renderer, frame, *twice, {DepthFormat::fixed24, true}));
  EXPECT_THROW(capture_stored(context(), renderer, frame, *twice, {DepthFormat::fixed24, false}), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
