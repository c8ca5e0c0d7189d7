#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>
#include <vector>

#include "core/error.h"
#include "renderers/gl/context.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/window.h"
#include "tests/support/xvfb.h"

namespace crowdbench::gl {
namespace {

TEST(PictureWindow, ShowsThePictureWholeAndUpright) {
  if (!test::Xvfb::installed()) GTEST_SKIP() << "Xvfb is not installed";
  const test::Xvfb server;
  ASSERT_FALSE(server.display().empty());
  ::setenv("DISPLAY", server.display().c_str(), 1);

  Image8 picture(100, 50, 4);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 100; ++x) {
      uint8_t* pixel = picture.at(x, y);
      pixel[0] = static_cast<uint8_t>(2 * x);
      pixel[1] = static_cast<uint8_t>(5 * y);
      pixel[2] = x < 50 ? 200 : 30;
      pixel[3] = 255;
    }
  }
  Context headless;  // current before the window is there, and afterwards
  Window window(200, 150, "test");
  window.poll();
  window.show(picture);
  window.poll();
  const Image8 shown = window.show_and_read(picture);
  ASSERT_EQ(shown.width, 200);
  ASSERT_EQ(shown.height, 150);
  // 100x50 fits 200x150 twice as large, with 25 black rows above and below.
  size_t wrong = 0;
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) {
      const uint8_t black[3] = {0, 0, 0};
      const uint8_t* expected = y < 25 || y >= 125 ? black : picture.at(x / 2, (y - 25) / 2);
      if (!std::equal(expected, expected + 3, shown.at(x, y))) ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0U);
  const std::vector<int> values = {1, 2, 3};
  const Buffer buffer(headless, values);
  std::vector<int> back(values.size());
  buffer.read(back.data(), back.size() * sizeof(int));
  EXPECT_EQ(back, values);
}

TEST(PictureWindow, NoDisplayIsAnError) {
  ::setenv("DISPLAY", ":99999", 1);
  ::unsetenv("WAYLAND_DISPLAY");
  try {
    const Window window(200, 150, "test");
    FAIL() << "a window without a display";
  } catch (const Error& error) {
    EXPECT_EQ(error.where, "window");
    EXPECT_NE(error.wrong.find("display"), std::string::npos) << error.wrong;
  }
}

}  // namespace
}  // namespace crowdbench::gl
