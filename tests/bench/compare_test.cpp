// The command `compare`, run in this process as the driver runs it.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "test_paths.h"

namespace crowdbench::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kImages = fs::path(CROWDBENCH_TEST_DATA) / "ground-truth" / "images";

fs::path scratch() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const fs::path folder = fs::path(::testing::TempDir()) / fmt::format("crowdbench_compare_{}", test->name());
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string output_of(std::vector<std::string> arguments) {
  CLI::App app;
  Run run;
  Command program(app);
  add_compare(program, run);
  arguments.insert(arguments.begin(), "compare");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  int status = -1;
  try {
    status = run();
  } catch (...) {
    ::testing::internal::GetCapturedStdout();
    ::testing::internal::GetCapturedStderr();
    throw;
  }
  EXPECT_EQ(status, 0);
  std::fflush(stdout);
  ::testing::internal::GetCapturedStderr();
  return ::testing::internal::GetCapturedStdout();
}

json compared(const fs::path& reference, const fs::path& test, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {reference.string(), test.string(), "--json"});
  return json::parse(output_of(std::move(more)));
}

std::string error_of(const fs::path& reference, const fs::path& test, std::vector<std::string> more = {}) {
  try {
    compared(reference, test, std::move(more));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Compare, PrintsTheScoresThatAPairMustHave) {
  const json all = json::parse(read_text(kImages.parent_path() / "expected.json"));
  const json& contract = all["pairs"]["p14_render_alias"]["contract"];
  const json out = compared(kImages / "p14_render_alias_ref.png", kImages / "p14_render_alias_test.png");
  EXPECT_EQ(out["width"], 480);
  EXPECT_EQ(out["height"], 270);
  EXPECT_NEAR(out["scores"]["mae"].get<double>(), contract["mae"].get<double>(), 1e-6);
  EXPECT_NEAR(out["scores"]["mse"].get<double>(), contract["mse"].get<double>(), 1e-6);
  EXPECT_NEAR(out["scores"]["psnr"].get<double>(), contract["psnr"].get<double>(), 1e-6);
  EXPECT_NEAR(out["scores"]["ssim"].get<double>(), contract["ssim_luma601"].get<double>(), 1e-6);
  EXPECT_NEAR(out["scores"]["ms_ssim"].get<double>(), contract["ms_ssim_luma601"].get<double>(), 1e-5);
  EXPECT_NEAR(out["scores"]["gmsd"].get<double>(), contract["gmsd_luma601"].get<double>(), 1e-6);
  EXPECT_TRUE(out["reasons"].empty());
  EXPECT_TRUE(out["warnings"].empty());
}

TEST(Compare, SaysWhyAScoreDoesNotExistAndWritesInfinityAsText) {
  const json tiny = compared(kImages / "p10_tiny_1x1_ref.png", kImages / "p10_tiny_1x1_test.png");
  EXPECT_TRUE(tiny["scores"]["ssim"].is_null());
  EXPECT_NE(tiny["reasons"]["ssim"].get<std::string>().find("11 pixels"), std::string::npos);
  EXPECT_TRUE(tiny["scores"]["ms_ssim"].is_null());
  EXPECT_NE(tiny["reasons"]["ms_ssim"].get<std::string>().find("176 pixels"), std::string::npos);
  const json same = compared(kImages / "p07_identical_odd_ref.png", kImages / "p07_identical_odd_test.png");
  EXPECT_EQ(same["scores"]["psnr"], "inf");
  EXPECT_EQ(same["scores"]["mae"], 0);
  const std::string text =
      output_of({(kImages / "p10_tiny_1x1_ref.png").string(), (kImages / "p10_tiny_1x1_test.png").string()});
  EXPECT_NE(text.find("not available"), std::string::npos);
}

TEST(Compare, AlphaIsIgnoredWithAWarningOrComposited) {
  const json all = json::parse(read_text(kImages.parent_path() / "expected.json"))["pairs"];
  const fs::path reference = kImages / "p09_alpha_ref.png";
  const fs::path test = kImages / "p09_alpha_test.png";
  const json ignored = compared(reference, test);
  EXPECT_EQ(ignored["warnings"].size(), 2U);
  EXPECT_NEAR(ignored["scores"]["psnr"].get<double>(), all["p09_alpha"]["contract"]["psnr"].get<double>(), 1e-6);
  const json grey = compared(reference, test, {"--over", "#808080"});
  EXPECT_TRUE(grey["warnings"].empty());
  EXPECT_NEAR(grey["scores"]["psnr"].get<double>(), all["p09_alpha@over_gray50"]["contract"]["psnr"].get<double>(),
              1e-6);
  EXPECT_EQ(error_of(reference, test, {"--over", "red"}), "--over: 'red' is no colour; write it as '#rrggbb'");
  EXPECT_NE(error_of(reference, test, {"--over", "#12345g"}), "");
}

TEST(Compare, WritesThreeMaps) {
  const fs::path folder = scratch();
  const json out = compared(kImages / "p14_render_alias_ref.png", kImages / "p14_render_alias_test.png",
                            {"--maps", (folder / "maps").string()});
  ASSERT_EQ(out["maps"].size(), 3U);
  const auto map = [&](const char* name) { return decode_png(read_file(folder / "maps" / name), name); };
  EXPECT_EQ(map("absdiff.png"),
            decode_png(read_file(kImages.parent_path() / "maps" / "p14_render_alias_absdiff.png"), "expected"));
  EXPECT_EQ(map("ssim_map.png").width, 470);
  EXPECT_EQ(map("ssim_map.png").height, 260);
  EXPECT_EQ(map("error_pseudocolour.png").width, 480);
  EXPECT_GT(map("error_pseudocolour.png").height, 300);
  fs::remove_all(folder);
}

TEST(Compare, FloatPicturesHaveLinearErrorsOnly) {
  const fs::path folder = scratch();
  ImageF a(12, 12, 3);
  ImageF b = a;
  b.data[0] = 4.32F;
  write_exr(folder / "a.exr", a);
  write_exr(folder / "b.exr", b);
  const json out = compared(folder / "a.exr", folder / "b.exr", {"--maps", folder.string()});
  for (const char* score : {"mae", "mse", "psnr", "ssim"}) {
    EXPECT_TRUE(out["scores"][score].is_null()) << score;
    EXPECT_TRUE(out["reasons"].contains(score)) << score;
  }
  EXPECT_NEAR(out["scores"]["linear_mae"].get<double>(), 0.01, 1e-8);
  EXPECT_NEAR(out["scores"]["linear_rms"].get<double>(), 4.32 / std::sqrt(432.0), 1e-7);
  EXPECT_EQ(out["warnings"].size(), 1U);
  fs::remove_all(folder);
}

TEST(Compare, ScoresByAgent) {
  const fs::path folder = scratch();
  Image8 a(20, 16, 3);
  Image8 b = a;
  ImageU32 ids_a(20, 16, 1);
  ImageU32 ids_b(20, 16, 1);
  for (int x = 6; x < 10; ++x) *ids_a.at(x, 8) = 3;
  for (int x = 8; x < 12; ++x) *ids_b.at(x, 8) = 3;
  b.at(8, 8)[1] = 36;
  write_png(folder / "a.png", a);
  write_png(folder / "b.png", b);
  write_exr(folder / "a.exr", ids_a);
  write_exr(folder / "b.exr", ids_b);
  const json out = compared(folder / "a.png", folder / "b.png",
                            {"--ids-ref", (folder / "a.exr").string(), "--ids-test", (folder / "b.exr").string()});
  ASSERT_EQ(out["agents"].size(), 1U);
  EXPECT_EQ(out["agents"][0]["id"], 3);
  EXPECT_NEAR(out["agents"][0]["iou"].get<double>(), 2.0 / 6, 1e-12);
  EXPECT_NEAR(out["agents"][0]["mae"].get<double>(), 36.0 / 18, 1e-12);
  EXPECT_NEAR(out["silhouette"]["iou"].get<double>(), 2.0 / 6, 1e-12);
  EXPECT_THROW(compared(folder / "a.png", folder / "b.png", {"--ids-ref", "x.exr"}), CLI::ParseError);
  EXPECT_NE(error_of(folder / "a.png", folder / "b.png",
                     {"--ids-ref", (folder / "a.png").string(), "--ids-test", (folder / "b.exr").string()})
                .find("is no picture of agent ids"),
            std::string::npos);
  fs::remove_all(folder);
}

TEST(Compare, RefusesPicturesOfTwoSizesAndMissingFiles) {
  EXPECT_NE(error_of(kImages / "p10_tiny_1x1_ref.png", kImages / "p05_flat_offset_ref.png").find("is 64 x 48 pixels"),
            std::string::npos);
  EXPECT_NE(error_of(kImages / "p10_tiny_1x1_ref.png", kImages / "absent.png").find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::bench
