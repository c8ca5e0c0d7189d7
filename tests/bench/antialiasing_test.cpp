// Samples a pixel, by multisampling or supersampling, are a condition of a scenario: every command that draws one takes
// them, from its options or from the file, draws with them, and says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files.h"
#include "core/image_io.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using nlohmann::json;

constexpr const char* kImpostor = "flat:views=sphere-8x3,texels=32,frames=2";
constexpr const char* kCharacter = " --character mannequin:triangles=500";
constexpr const char* kSmooth[] = {"--samples 4", "--supersample 3"};

class AntialiasingGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    fs::create_directories(work_);
  }
  support::Outcome run(const std::string& arguments, bool with_stderr = false) const {
    return support::run_driver("cd '" + work_.string() + "' && CROWDBENCH_CACHE_DIR=../cache", arguments, with_stderr);
  }
  json facts(const std::string& arguments) const {
    const support::Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << arguments << "\n" << run(arguments, true).text;
    json parsed = json::parse(outcome.text, nullptr, false);
    EXPECT_FALSE(parsed.is_discarded()) << arguments << "\n" << outcome.text;
    return parsed;
  }
  Image8 picture(const std::string& file) const { return decode_png(read_file(work_ / file), file); }
  // "samples" and "supersample" of what a command printed.
  static std::pair<int, int> said(const json& stage) {
    return {stage.at("samples").get<int>(), stage.at("supersample").get<int>()};
  }
  static std::pair<int, int> asked(const std::string& option) {
    return option.starts_with("--samples") ? std::pair{4, 1} : std::pair{1, 3};
  }

  support::ScratchFolder folder_;
  fs::path work_ = folder_ / "work";
};

TEST_F(AntialiasingGl, RenderSmoothsColoursAndNotMasks) {
  const std::string line = std::string("render --agents 5 --size 96x72 --representation ") + kImpostor + kCharacter;
  ASSERT_EQ(run(line + " --out one.png --mask one_mask.png").status, 0);
  for (const std::string option : kSmooth) {
    const json j = facts(line + " " + option + " --out more.png --mask more_mask.png --json");
    EXPECT_EQ(said(j.at("stage")), asked(option));
    EXPECT_NE(picture("more.png").data, picture("one.png").data) << option;
    EXPECT_EQ(picture("more_mask.png").data, picture("one_mask.png").data) << option << ": by the centre sample";
  }
}

TEST_F(AntialiasingGl, AScenarioSaysThemAsTheOptionsDo) {
  const std::string line = std::string("render --agents 5 --size 96x72") + kCharacter;
  for (const std::string option : kSmooth) {
    const auto [samples, supersample] = asked(option);
    write_file(work_ / "smooth.toml",
               "samples = " + std::to_string(samples) + "\nsupersample = " + std::to_string(supersample) + "\n");
    ASSERT_EQ(run(line + " " + option + " --out option.png").status, 0);
    ASSERT_EQ(run(line + " smooth.toml --out file.png").status, 0)
        << run(line + " smooth.toml --out file.png", true).text;
    EXPECT_EQ(picture("file.png").data, picture("option.png").data) << option;
  }
}

TEST_F(AntialiasingGl, QualityAndPopmapScoreWithThem) {
  const std::string quality =
      std::string("quality --height-px 40 --rows 64 --azimuth-deg 20 --json --representation ") + kImpostor +
      kCharacter;
  const std::string popmap = std::string(
                                 "popmap --azimuth-deg 20 --elevation-deg 0 --phase 0.1 --height-px 40 --json "
                                 "--representation ") +
                             kImpostor + kCharacter;
  const json rows = facts(quality).at("rows");
  const json sizes = facts(popmap).at("sizes");
  ASSERT_EQ(rows.size(), 1U);
  ASSERT_EQ(sizes.size(), 1U);
  for (const std::string option : kSmooth) {
    EXPECT_NE(facts(quality + " " + option).at("rows")[0].at("flip"), rows[0].at("flip")) << option;
    EXPECT_NE(facts(popmap + " " + option).at("sizes")[0].at("switch"), sizes[0].at("switch")) << option;
  }
}

TEST_F(AntialiasingGl, RatioAndBenchTimeThem) {
  CROWDBENCH_SKIP_SANITIZED("AntialiasingGl.RenderSmoothsColoursAndNotMasks");
  for (const std::string option : kSmooth) {
    const json ratio =
        facts("ratio --of mesh --to mesh:floor=1 --agents 4 --size 64x48 --pairs 20 --json " + option + kCharacter);
    EXPECT_TRUE(ratio.at("valid").get<bool>()) << ratio.at("faults");
    EXPECT_EQ(said(ratio.at("stage")), asked(option));
    const json bench = facts(std::string("bench --agents 4 --occupancy 0 --size 64x48 --rounds 10 --no-floors --out ") +
                             (option.starts_with("--samples") ? "samples" : "supersample") +
                             ".sqlite --json --representation " + kImpostor + " " + option + kCharacter);
    ASSERT_EQ(bench.at("stages").size(), 1U);
    EXPECT_EQ(said(bench.at("stages")[0].at("stage")), asked(option));
    for (const json& row : bench.at("measurements")) EXPECT_EQ(row.at("status"), "valid") << row.dump();
  }
}

TEST_F(AntialiasingGl, PairDrawsBothHalvesWithThem) {
  const std::string line =
      std::string("pair --a mesh --agents 4 --size 64x48 --frames 2 --json --b ") + kImpostor + kCharacter;
  const json plain = facts(line + " --out plain.mp4");
  for (const std::string option : kSmooth) {
    const json j = facts(line + " --out smooth.mp4 " + option);
    EXPECT_NE(j, plain) << option;
    const std::string scenario = j.dump();
    const std::string key = option.starts_with("--samples") ? "samples = 4" : "supersample = 3";
    EXPECT_NE(scenario.find(key), std::string::npos) << scenario;
  }
}

}  // namespace
}  // namespace crowdbench::bench
