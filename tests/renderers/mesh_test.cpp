#include <gtest/gtest.h>

#include <cmath>

#include "core/image_io.h"
#include "gl_test_support.h"

namespace crowdbench::renderers {
namespace {

using testing::add_agent;
using testing::card;
using testing::cast_of;
using testing::context;
using testing::frame_of_one;
using testing::GlTest;

class MeshGl : public GlTest {};

std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec) {
  return make_representation({.context = context(), .cast = cast}, parse_spec(spec));
}

// A card 1 m wide and 0.5 m high at 4 m: with a focal length of f pixels a metre covers f / 4 pixels.
TEST_F(MeshGl, CardCoversExactlyItsPixelsAtItsDepth) {
  const int size = 200;
  const double f = 400.0;  // pixels: 100 pixels a metre at 4 m
  const double fov = 2.0 * std::atan(size / 2.0 / f) * 180.0 / 3.14159265358979323846;
  const scene::Cast cast = cast_of(card(1.0F, 0.5F));
  scene::Frame frame = frame_of_one(4.0, 0.25, size, size, fov);
  add_agent(frame, cast, {0, 0, 0}, 7);
  Renderer renderer(context(), cast);
  const auto mesh = make(cast, "mesh");
  const Capture c = renderer.capture(frame, *mesh);
  if (const char* dir = std::getenv("CROWDBENCH_TEST_OUT")) write_png(std::string(dir) + "/card.png", c.colour);
  // 100 x 50 pixels in the middle: columns 50..149, rows 75..124.
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const bool inside = x >= 50 && x < 150 && y >= 75 && y < 125;
      ASSERT_EQ(c.ids.at(x, y)[0], inside ? 7U : 0U) << x << ", " << y;
      if (inside) {
        ASSERT_NEAR(c.depth.at(x, y)[0], 4.0F, 4.0e-6F);
      } else {
        ASSERT_TRUE(std::isinf(c.depth.at(x, y)[0]));
        ASSERT_EQ(c.colour.at(x, y)[0], 128);
      }
    }
}

}  // namespace
}  // namespace crowdbench::renderers
