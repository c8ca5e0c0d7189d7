// The command `view` on a virtual display.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/stage/stage_scenario.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/load_cast.h"
#include "tests/support/xvfb.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

int view(std::vector<std::string> arguments) {
  CLI::App app;
  Run run;
  Command program(app);
  add_view(program, run);
  arguments.insert(arguments.begin(), "view");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return run();
}

class ViewWindow : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("crowdbench-view-" + std::to_string(::getpid()));
  void SetUp() override {
    ::unsetenv("WAYLAND_DISPLAY");
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
};

TEST_F(ViewWindow, ShowsTheVeryPixelsThatACaptureHolds) {
  if (!test::Xvfb::installed()) GTEST_SKIP() << "Xvfb is not installed";
  const test::Xvfb server;
  ASSERT_FALSE(server.display().empty());
  ::setenv("DISPLAY", server.display().c_str(), 1);
  const fs::path file = folder / "window.png";
  ASSERT_EQ(view({"--agents", "12", "--size", "320x240", "--frames", "8", "--screenshot", file.string()}), 0);
  const Image8 shown = decode_png(read_file(file), file.string());

  // The same tick by the library, without a window. The window's orbit camera is the scenario's up to rounding, which
  // may move a silhouette by a pixel here and there.
  SceneOptions options;
  options.agents = 12;
  options.size = "320x240";
  ChosenScenario chosen = read_scenario(options);
  chosen.scenario.ground = true;
  const scene::Cast cast = scene::load_cast(chosen.scenario, chosen.folder);
  gl::Context context;
  const Staged staged = stage_scenario(chosen.scenario, cast, context);
  renderers::Renderer renderer(context, cast);
  const auto mesh = renderers::make_representation({context, cast}, renderers::parse_spec("mesh"));
  const auto capture_at = [&](uint64_t tick) {
    return renderer
        .capture(scene::make_frame(staged.scenario, cast, staged.crowd, staged.scenario.camera.at(0), tick), *mesh)
        .colour;
  };
  const Image8 drawn = capture_at(7);
  ASSERT_EQ(shown.width, drawn.width);
  ASSERT_EQ(shown.height, drawn.height);
  const auto differing = [&](const Image8& picture) {
    size_t count = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x)
        count += !std::equal(shown.at(x, y), shown.at(x, y) + 3, picture.at(x, y));
    }
    return count;
  };
  EXPECT_LT(differing(drawn), drawn.pixels() / 1000);
  EXPECT_GT(differing(capture_at(0)), drawn.pixels() / 100);  // the crowd walked: another tick is another picture
}

TEST_F(ViewWindow, EscapeEnds) {
  if (!test::Xvfb::installed()) GTEST_SKIP() << "Xvfb is not installed";
  if (!fs::exists("/usr/bin/xdotool")) GTEST_SKIP() << "xdotool is not installed";
  const test::Xvfb server;
  ASSERT_FALSE(server.display().empty());
  ::setenv("DISPLAY", server.display().c_str(), 1);
  // Types into the window once it is there; a window manager is not needed, focus is given by hand.
  const std::string typing =
      "(w=; for i in $(seq 100); do w=$(xdotool search --name '^crowdbench: mesh' 2>/dev/null | head -1); "
      "[ -n \"$w\" ] && break; sleep 0.1; done; "
      "xdotool windowfocus --sync $w key s; sleep 0.3; xdotool key Escape) >/dev/null 2>&1 &";
  ASSERT_EQ(std::system(typing.c_str()), 0);
  // Without the key it would go on for 100,000 frames, and the test would run into its time limit.
  EXPECT_EQ(view({"--agents", "3", "--size", "160x120", "--frames", "100000", "--representation", "mesh",
                  "--representation", "mesh:floor=1"}),
            0);
}

TEST_F(ViewWindow, NoDisplayIsAnErrorBeforeAnythingIsLoaded) {
  ::setenv("DISPLAY", ":99999", 1);
  try {
    view({"--character", "no-such-file.glb"});
    FAIL() << "a window without a display";
  } catch (const Error& error) {
    EXPECT_EQ(error.where, "window");
  }
}

TEST_F(ViewWindow, ScreenshotNeedsAnEnd) { EXPECT_THROW(view({"--screenshot", (folder / "x.png").string()}), Error); }

}  // namespace
}  // namespace crowdbench::bench
