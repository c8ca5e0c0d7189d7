// The driver's `render` from outside: the same bytes whatever the thread count, the EGL platform and the run; one line
// and status 2 for what a user gets wrong.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/files.h"
#include "core/image_io.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using support::Outcome;
const auto run = [](const std::string& prefix, const std::string& arguments) {
  return support::run_driver(prefix, arguments);
};

class RenderGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  support::ScratchFolder folder_;
};

TEST_F(RenderGl, BytesDoNotDependOnThreadsPlatformOrRun) {
  CROWDBENCH_SKIP_SANITIZED("RenderGl.ASwitchWithHistoryIsTheSameAtAnyThreadCount");
  const std::string common =
      "render --character mannequin:triangles=500 --agents 30 --seed 7 --size 200x150 --tick 12 --out ";
  const struct {
    const char* name;
    const char* environment;
    const char* arguments;
  } variants[] = {
      {"a.png", "", ""},
      {"again.png", "", ""},
      {"one_thread.png", "LP_NUM_THREADS=0", ""},
      {"two_threads.png", "LP_NUM_THREADS=2", ""},
      {"surfaceless.png", "", " --device surfaceless"},
      {"narrow.png", "LP_NATIVE_VECTOR_WIDTH=128", ""},
  };
  std::vector<uint8_t> first;
  for (const auto& v : variants) {
    const Outcome outcome = run(v.environment, common + "'" + file(v.name) + "'" + v.arguments);
    ASSERT_EQ(outcome.status, 0) << v.name << ": " << outcome.text;
    const std::vector<uint8_t> bytes = read_file(file(v.name));
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << v.name;
  }
  const Image8 picture = decode_png(first, "a.png");
  EXPECT_EQ(picture.width, 200);
  EXPECT_EQ(picture.height, 150);
  size_t drawn = 0;
  for (size_t i = 0; i < picture.pixels(); ++i) drawn += picture.data[3 * i] != 128 || picture.data[3 * i + 1] != 128;
  EXPECT_GT(drawn, 500U) << "something was drawn";
  const std::string text(first.begin(), first.end());
  for (const char* key : {"scenario", "seed", "backend", "version"})
    EXPECT_NE(text.find(std::string("tEXt") + key), std::string::npos) << key;
  EXPECT_EQ(text.find(folder_.path().string()), std::string::npos) << "no path of this machine";
}

// llvmpipe's shader cache does not know the vector width: code of one width must not run at another, either way. A tier
// of 13 or 9 boxes of 4 corners has no multiple of 8 vertices, which code 8 lanes wide would write.
TEST_F(RenderGl, ANarrowedDriverSharesNoShaderCache) {
  CROWDBENCH_SKIP_SANITIZED("BytesDoNotDependOnThreadsPlatformOrRun");
  const auto render = [&](const std::string& shaders, const std::string& representation,
                          const std::string& environment) {
    const Outcome outcome =
        run("unset MESA_SHADER_CACHE_DISABLE; CROWDBENCH_CACHE_DIR='" + file("bakes") + "' MESA_SHADER_CACHE_DIR='" +
                file(shaders) + "' " + environment,
            "render --representation " + representation +
                " --character mannequin:triangles=500 --agents 20 --occupancy 0.15 --size 160x120 --device software "
                "--out '" +
                file("x.png") + "'");
    EXPECT_EQ(outcome.status, 0) << environment << ": " << outcome.text;
    return outcome.status == 0 ? read_file(file("x.png")) : std::vector<uint8_t>();
  };
  const auto cached = [&](const std::string& shaders) {
    size_t files = 0;
    std::error_code absent;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(file(shaders), absent))
      files += entry.is_regular_file() && entry.file_size() > 0 ? 1U : 0U;
    return files;
  };
  const std::string relief = "relief:map=32,capture=bind";
  const std::string narrow = "LP_NATIVE_VECTOR_WIDTH=128";
  const std::vector<uint8_t> wide = render("after wide", relief, "");
  if (cached("after wide") == 0) GTEST_SKIP() << "the driver keeps no shader cache";
  EXPECT_EQ(render("after wide", relief, narrow), wide);
  render("narrow first", "mesh", narrow);
  EXPECT_EQ(cached("narrow first"), 0U) << "left for another width";
}

// A hybrid with a memory, at a tick in the middle of its cross-fades: the ticks before are played, whatever the
// threads.
TEST_F(RenderGl, ASwitchWithHistoryIsTheSameAtAnyThreadCount) {
  const std::string scenario = R"(
name = "dolly"
[crowd]
agents = 40
[[character]]
source = "mannequin:triangles=500"
[[camera.key]]
time = 0.0
eye = [0.0, 2.0, 6.0]
target = [0.0, 1.0, 0.0]
[[camera.key]]
time = 1.0
eye = [0.0, 2.0, 10.0]
target = [0.0, 1.0, 0.0]
)";
  write_file(file("dolly.toml"), scenario);
  const auto render = [&](const std::string& environment, const std::string& representation, const std::string& name) {
    const Outcome outcome = run("CROWDBENCH_CACHE_DIR='" + file("cache") + "' " + environment,
                                "render '" + file("dolly.toml") + "' --size 200x150 --tick 12 --representation '" +
                                    representation + "' --out '" + file(name) + "'");
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return decode_png(read_file(file(name)), name);
  };
  const std::string flat = "(flat:views=sphere-8x2,frames=2,texels=32)";
  const std::string fading = "hybrid(mesh," + flat + ",distance=8,hysteresis=0.05,fade=8)";
  const Image8 first = render("", fading, "a.png");
  EXPECT_EQ(render("LP_NUM_THREADS=0", fading, "b.png"), first);
  EXPECT_EQ(render("LP_NUM_THREADS=2", fading, "c.png"), first);
  EXPECT_NE(render("", "hybrid(mesh," + flat + ",distance=8)", "d.png"), first) << "the history shows";
}

TEST_F(RenderGl, SingleWritesAMaskThatAgreesWithTheIds) {
  const Outcome outcome =
      run("",
          "render --single --character mannequin:triangles=500 --clip none --height as_is --eye 0,1,5 --target 0,1,0 "
          "--size 120x160 --background '#204060' --out '" +
              file("x.png") + "' --mask '" + file("m.png") + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const Image8 colour = decode_png(read_file(file("x.png")), "x.png");
  const Image8 mask = decode_png(read_file(file("m.png")), "m.png");
  ASSERT_EQ(mask.channels, 1);
  size_t inside = 0;
  for (size_t i = 0; i < mask.pixels(); ++i) {
    ASSERT_TRUE(mask.data[i] == 0 || mask.data[i] == 255);
    inside += mask.data[i] == 255 ? 1U : 0U;
    if (mask.data[i] == 0) {
      ASSERT_EQ(colour.data[3 * i], 0x20);
      ASSERT_EQ(colour.data[3 * i + 1], 0x40);
      ASSERT_EQ(colour.data[3 * i + 2], 0x60);
    }
  }
  EXPECT_GT(inside, 500U);
}

TEST_F(RenderGl, WhatAUserGetsWrongIsOneLineAndStatusTwo) {
  const struct {
    const char* arguments;
    const char* says;
  } wrong[] = {
      {"render", "no picture is asked for"},
      {"render --out x.png --size 12", "'12' is not a size"},
      {"render --out x.png --size 0x4", "is not a size"},
      {"render --out x.png --representation messh", "did you mean 'mesh'"},
      {"render --out x.png --device 77", "there is no EGL device 77"},
      {"render --out x.png --single --background red", "'#rrggbb'"},
      {"render --out x.png --single --eye 1,2", "is not a point"},
      {"render --out x.png --single --height -1", "is not a height"},
      {"render --out x.png --single --fov-y-deg 180", "from 0.1 to 179"},
      {"render --out x.png --single --clip no_such_clip", "no_such_clip"},
      {"render --out x.png --supersample 2", "odd"},
      {"render --out x.png --samples 3", "a power of two from 1 to 8"},
      {"render nowhere.toml --out x.png", "nowhere.toml"},
      {"render --out /proc/nowhere/x.png --agents 1 --size 8x8", "/proc/nowhere"},
  };
  for (const auto& w : wrong) {
    SCOPED_TRACE(w.arguments);
    const Outcome outcome = run("cd '" + folder_.path().string() + "';", w.arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_NE(outcome.text.find(w.says), std::string::npos) << outcome.text;
    size_t lines = 0;
    size_t begin = 0;
    while (begin < outcome.text.size()) {
      const size_t end = std::min(outcome.text.find('\n', begin), outcome.text.size());
      // The line that names the renderer is no complaint.
      if (outcome.text.compare(begin, 22, "crowdbench: drawing on") != 0) ++lines;
      begin = end + 1;
    }
    EXPECT_EQ(lines, 1U) << outcome.text;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.png")) << "nothing half-written";
  }
}

}  // namespace
}  // namespace crowdbench::bench
