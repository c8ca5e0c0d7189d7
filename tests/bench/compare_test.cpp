// The command `compare`, run in this process as the driver runs it.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
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

std::string output_of(std::vector<std::string> arguments, int expected_status = 0) {
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
  EXPECT_EQ(status, expected_status);
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
  const json& flip = contract["flip"]["67.0206"];
  EXPECT_NEAR(out["scores"]["flip"]["mean"].get<double>(), flip["mean"].get<double>(), 2e-4);
  EXPECT_NEAR(out["scores"]["flip"]["q3"].get<double>(), flip["q3_weighted"].get<double>(), 2e-4);
  EXPECT_EQ(out["scores"]["flip"].size(), 6U);
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
  EXPECT_EQ(error_of(reference, test, {"--over", "red"}),
            "--over: 'red' is not a colour; write '#rrggbb' in hexadecimal");
  EXPECT_NE(error_of(reference, test, {"--over", "#12345g"}), "");
}

TEST(Compare, WritesMaps) {
  const fs::path folder = scratch();
  const json out = compared(kImages / "p14_render_alias_ref.png", kImages / "p14_render_alias_test.png",
                            {"--maps", (folder / "maps").string()});
  ASSERT_EQ(out["maps"].size(), 5U);
  const auto map = [&](const char* name) { return decode_png(read_file(folder / "maps" / name), name); };
  EXPECT_EQ(map("absdiff.png"),
            decode_png(read_file(kImages.parent_path() / "maps" / "p14_render_alias_absdiff.png"), "expected"));
  EXPECT_EQ(map("ssim_map.png").width, 470);
  EXPECT_GT(map("ssim_map.png").height, 300) << "260 rows and the bar";
  EXPECT_EQ(map("error_pseudocolour.png").width, 480);
  EXPECT_GT(map("error_pseudocolour.png").height, 300);
  EXPECT_GT(map("flip_map.png").height, 300);
  EXPECT_GT(map("cvvdp_map.png").height, 300);
  compared(kImages / "p14_render_alias_ref.png", kImages / "p14_render_alias_test.png",
           {"--maps", (folder / "plain").string(), "--colours", "plain", "--scores", "ssim,flip"});
  const auto plain = [&](const char* name) { return decode_png(read_file(folder / "plain" / name), name); };
  EXPECT_EQ(plain("ssim_map.png").height, 260);
  EXPECT_EQ(plain("flip_map.png").height, 270);
  fs::remove_all(folder);
}

TEST(Compare, FloatPicturesHaveScoresOfFloatsOnly) {
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
  EXPECT_TRUE(out["scores"]["hdr_flip"].is_null());
  EXPECT_NE(out["reasons"]["hdr_flip"].get<std::string>().find("the reference is black"), std::string::npos);
  EXPECT_EQ(out["not_finite"]["test"], json::parse(R"({"nan": 0, "infinite": 0})"));
  EXPECT_EQ(out["warnings"][0], "no maps of code values: the pictures have none");
  fs::remove_all(folder);
}

// What does not count may be no number; and floats are compared with floats alone.
TEST(Compare, WhatIsLeftOutNeedNotBeFinite) {
  const fs::path folder = scratch();
  ImageF a(12, 12, 3);
  std::fill(a.data.begin(), a.data.end(), 0.5F);
  ImageF b = a;
  b.at(9, 9)[0] = 0.5F + 4.32F;
  a.at(2, 3)[1] = std::numeric_limits<float>::quiet_NaN();
  b.at(3, 3)[1] = std::numeric_limits<float>::infinity();
  write_exr(folder / "a.exr", a);
  write_exr(folder / "b.exr", b);
  const json out = compared(folder / "a.exr", folder / "b.exr", {"--ignore", "2,3,2,1"});
  EXPECT_NEAR(out["scores"]["linear_mae"].get<double>(), 0.01, 1e-7);
  EXPECT_TRUE(out["warnings"].empty()) << out["warnings"];
  const json half = compared(folder / "a.exr", folder / "b.exr", {"--ignore", "2,3,1,1"});
  EXPECT_EQ(half["reasons"]["linear_mae"], "the test has 1 pixel that is infinite, the first at (3, 3)");
  write_png(folder / "b.png", Image8(12, 12, 3));
  std::string error;
  try {
    compared(folder / "a.exr", folder / "b.png");
  } catch (const Error& refused) {
    error = refused.what();
  }
  EXPECT_NE(error.find("b.png: holds code values, "), std::string::npos) << error;
  EXPECT_NE(error.find("a.exr floats; compare two of one kind"), std::string::npos) << error;
  fs::remove_all(folder);
}

// The error and exposure maps, the range that was chosen, and a pixel that is not a number, which is placed.
TEST(Compare, HdrFlipSaysItsExposuresAndRefusesWhatIsNotFinite) {
  const fs::path folder = scratch();
  const fs::path reference = kImages.parent_path() / "hdr" / "h03_half_exposure_ref.exr";
  ImageF half = std::get<ImageF>(read_image(reference));
  for (float& v : half.data) v *= 0.5F;
  write_exr(folder / "half.exr", half);
  const json expected = json::parse(
      read_text(kImages.parent_path() / "expected.json"))["hdr"]["h03_half_exposure"]["hdrflip_aces_default"];
  const json out = compared(reference, folder / "half.exr", {"--maps", (folder / "maps").string()});
  EXPECT_NEAR(out["scores"]["hdr_flip"]["mean"].get<double>(), expected["mean"].get<double>(), 2e-4);
  const json& details = out["details"]["hdr_flip"];
  EXPECT_NEAR(details["start_exposure"].get<double>(), expected["start_exposure"].get<double>(), 1e-4);
  EXPECT_NEAR(details["stop_exposure"].get<double>(), expected["stop_exposure"].get<double>(), 1e-4);
  EXPECT_EQ(details["exposures"], 9);
  EXPECT_NE(out["conditions"]["hdr_flip"].get<std::string>().find("ACES, 9 exposures"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "maps" / "hdr_flip_map.png"));
  EXPECT_TRUE(fs::exists(folder / "maps" / "hdr_flip_exposures.png"));
  half.at(9, 4)[2] = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder / "half.exr", half);
  const json broken = compared(reference, folder / "half.exr");
  EXPECT_EQ(broken["not_finite"]["test"], json::parse(R"({"nan": 1, "infinite": 0, "first": [9, 4]})"));
  for (const char* score : {"hdr_flip", "linear_mae", "linear_rms"}) {
    EXPECT_TRUE(broken["scores"][score].is_null()) << score;
    EXPECT_EQ(broken["reasons"][score], "the test has 1 pixel that is not a number, the first at (9, 4)");
  }
  fs::remove_all(folder);
}

// FLIP keeps to its own default where no display is given; what is asked for by name says why it is not there.
TEST(Compare, DisplayAndScoresAreChosen) {
  const json all = json::parse(read_text(kImages.parent_path() / "expected.json"));
  const json& contract = all["pairs"]["p14_render_alias"]["contract"]["flip"];
  const fs::path reference = kImages / "p14_render_alias_ref.png";
  const fs::path test = kImages / "p14_render_alias_test.png";
  const fs::path folder = scratch();
  write_file(folder / "d.json",
             std::string_view(R"({"name": "mine", "pixels_per_degree": 33.5, "max_luminance": 200})"));
  const json out =
      compared(reference, test, {"--scores", "flip,ssim,depth_mae", "--display", (folder / "d.json").string()});
  EXPECT_EQ(out["scores"].size(), 3U);
  EXPECT_NEAR(out["scores"]["flip"]["mean"].get<double>(), contract["33.5"]["mean"].get<double>(), 2e-4);
  EXPECT_EQ(out["conditions"]["flip"], "33.5000 pixels/degree");
  EXPECT_EQ(out["display"]["given"], true);
  EXPECT_EQ(out["display"]["pixels_per_degree"], 33.5);
  EXPECT_EQ(out["reasons"]["depth_mae"], "no agent ids are given");
  const json own = compared(reference, test, {"--scores", "flip"});
  EXPECT_NEAR(own["scores"]["flip"]["mean"].get<double>(), contract["67.0206"]["mean"].get<double>(), 2e-4);
  EXPECT_EQ(own["display"]["given"], false);
  EXPECT_EQ(own["conditions"]["flip"], "67.0206 pixels/degree, FLIP's own default");
  EXPECT_EQ(error_of(reference, test, {"--scores", "flip,flop"}),
            "--scores: there is no score 'flop'; did you mean 'flip'?");
  EXPECT_NE(error_of(reference, test, {"--display", "standard_5k"}).find("--display"), std::string::npos);
  EXPECT_NE(error_of(reference, test, {"--chart", (folder / "c.html").string()}).find("--chart"), std::string::npos);
  EXPECT_NE(error_of(reference, test, {"--padding", "none"}).find("choose replicate or symmetric"), std::string::npos);
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
                .find("is not a picture of agent ids"),
            std::string::npos);
  fs::remove_all(folder);
}

// Two grey pictures whose left half differs by 40 and whose right half by 10.
class CompareRegions : public ::testing::Test {
 protected:
  CompareRegions() {
    Image8 a(200, 180, 3);
    std::fill(a.data.begin(), a.data.end(), uint8_t{100});
    Image8 b = a;
    Image8 mask(200, 180, 1);
    for (int y = 0; y < 180; ++y)
      for (int x = 0; x < 200; ++x) {
        for (int c = 0; c < 3; ++c) b.at(x, y)[c] = x < 100 ? 140 : 110;
        *mask.at(x, y) = x < 100 ? 255 : 0;
      }
    write_png(reference, a);
    write_png(test, b);
    write_png(left, mask);
  }
  ~CompareRegions() override { fs::remove_all(folder); }
  json scores(std::vector<std::string> more) { return compared(reference, test, std::move(more)); }

  fs::path folder = scratch(), reference = folder / "a.png", test = folder / "b.png", left = folder / "left.png";
};

TEST_F(CompareRegions, WhatIsIgnoredHasNoSay) {
  EXPECT_FALSE(scores({}).contains("region"));
  const json right = scores({"--ignore", "0,0,100,180"});
  EXPECT_EQ(right["region"]["pixels"], 100 * 180);
  EXPECT_EQ(right["region"]["ignore"], json({{0, 0, 100, 180}}));
  EXPECT_TRUE(right["region"]["mask"].is_null());
  EXPECT_EQ(right["scores"]["mae"], 10);
  EXPECT_EQ(right["scores"]["mse"], 100);
  EXPECT_EQ(right["worst"]["difference"], 10);
  EXPECT_EQ(scores({"--mask", left.string()})["scores"]["mae"], 40);
  // Both together leave the lower left quarter.
  const json quarter = scores({"--mask", left.string(), "--ignore", "0,0,200,90"});
  EXPECT_EQ(quarter["region"]["pixels"], 100 * 90);
  EXPECT_EQ(quarter["region"]["mask"], left.string());
  // Scores of the whole picture see no difference either in what is left out, and some in the rest.
  EXPECT_GT(right["scores"]["ssim"].get<double>(), scores({})["scores"]["ssim"].get<double>());
  EXPECT_LT(right["scores"]["ssim"].get<double>(), 1);
  // Rectangles may reach over the edge; several add up.
  EXPECT_EQ(scores({"--ignore", "150,0,9999,9999", "--ignore", "0,0,100,180"})["region"]["pixels"], 50 * 180);
}

TEST_F(CompareRegions, EqualPicturesButForWhatIsIgnoredScoreAsEqual) {
  Image8 b = decode_png(read_file(reference), "a.png");
  for (int y = 20; y < 40; ++y) b.at(60, y)[1] = 255;
  write_png(test, b);
  EXPECT_LT(scores({})["scores"]["ssim"].get<double>(), 1);
  const json out = scores({"--ignore", "60,20,1,20"});
  for (const char* name : {"ssim", "ms_ssim", "ssim_union"}) EXPECT_EQ(out["scores"][name], 1) << name;
  EXPECT_EQ(out["scores"]["gmsd"], 0);
  EXPECT_EQ(out["scores"]["psnr"], "inf");
}

TEST_F(CompareRegions, WrongRegionsAreRefused) {
  for (const char* wrong : {"1,2,3", "1,2,3,4,5", "-1,0,5,5", "0,0,0,5", "a,b,c,d", "0,0,5,5 ", ""})
    EXPECT_NE(error_of(reference, test, {"--ignore", wrong}).find("is not a rectangle"), std::string::npos) << wrong;
  EXPECT_NE(error_of(reference, test, {"--ignore", "200,0,5,5"}).find("lies outside the picture"), std::string::npos);
  EXPECT_NE(error_of(reference, test, {"--ignore", "0,0,200,180"}).find("leaves no pixel"), std::string::npos);
  write_png(left, Image8(10, 10, 1));
  EXPECT_NE(error_of(reference, test, {"--mask", left.string()}).find("is 10 x 10 pixels"), std::string::npos);
}

TEST_F(CompareRegions, AMasksColoursDecideAndANoteTellsWhereAlphaWouldNot) {
  // The left half by alpha alone; by colour alone; by both alike.
  const auto mask = [&](auto&& colour, auto&& alpha) {
    Image8 out(200, 180, 4);
    for (int y = 0; y < 180; ++y)
      for (int x = 0; x < 200; ++x) {
        std::fill_n(out.at(x, y), 3, static_cast<uint8_t>(colour(x)));
        out.at(x, y)[3] = static_cast<uint8_t>(alpha(x));
      }
    write_png(left, out);
  };
  const auto all = [](int) { return 255; };
  const auto none = [](int) { return 0; };
  const auto half = [](int x) { return x < 100 ? 255 : 0; };
  const auto note = [&](int pixels, size_t notes, const std::string& said) {
    const json out = scores({"--mask", left.string()});
    EXPECT_EQ(out["region"]["pixels"], pixels * 180);
    ASSERT_EQ(out["warnings"].size(), notes) << out["warnings"];
    if (notes > 0) EXPECT_NE(out["warnings"][0].get<std::string>().find(said), std::string::npos) << out["warnings"];
  };
  mask(all, half);
  note(200, 1, "alpha, which would decide otherwise in 18000 of 36000 pixels");
  mask(half, [](int x) { return x < 100 ? 0 : 255; });
  note(100, 1, "alpha, which would decide otherwise in 36000 of 36000 pixels");
  mask(all, none);
  note(200, 1, "alpha, which would decide otherwise in 36000 of 36000 pixels");
  mask(half, half);
  note(100, 0, "");
  mask(half, all);  // opaque: alpha says nothing
  note(100, 0, "");
  mask(none, half);
  EXPECT_NE(error_of(reference, test, {"--mask", left.string()}).find("its alpha has no say"), std::string::npos);
}

TEST_F(CompareRegions, BoundsDecideTheExitStatus) {
  const auto status = [&](std::vector<std::string> more, int expected) {
    more.insert(more.begin(), {reference.string(), test.string(), "--json"});
    return json::parse(output_of(std::move(more), expected));
  };
  const json kept = status({"--fail-above", "mae=25", "--fail-below", "ssim=0.5"}, 0);  // (40 + 10) / 2
  EXPECT_EQ(kept["bounds"][0]["score"], "mae");
  EXPECT_EQ(kept["bounds"][0]["fail_above"], 25);
  EXPECT_EQ(kept["bounds"][0]["value"], 25);
  EXPECT_EQ(kept["bounds"][0]["pass"], true);
  EXPECT_EQ(kept["bounds"][1]["fail_below"], 0.5);
  EXPECT_EQ(status({"--fail-above", "mae=24.9"}, 1)["bounds"][0]["pass"], false);
  EXPECT_EQ(status({"--fail-above", "mae=24.9", "--ignore", "0,0,100,180"}, 0)["bounds"][0]["value"], 10);
  EXPECT_EQ(status({"--fail-below", "psnr=60"}, 1)["bounds"][0]["pass"], false);
  // What does not exist has not passed.
  EXPECT_EQ(status({"--fail-above", "linear_mae=1"}, 1)["bounds"][0]["pass"], false);
  EXPECT_NE(error_of(reference, test, {"--fail-above", "ssim=0.9"}).find("write --fail-below ssim=0.9"),
            std::string::npos);
  EXPECT_NE(error_of(reference, test, {"--fail-above", "mea=2"}).find("did you mean 'mae'?"), std::string::npos);
  for (const char* wrong : {"mae", "mae=", "mae=x", "mae=2 ", "mae=nan"})
    EXPECT_NE(error_of(reference, test, {"--fail-above", wrong}).find("is not a bound"), std::string::npos) << wrong;
}

// A chunk of a PNG put before its first IDAT; its checksum is not looked at.
void insert_chunk(const fs::path& png, const std::string& type, const std::string& data) {
  const std::vector<uint8_t> bytes = read_file(png);
  std::string text(bytes.begin(), bytes.end());
  const auto length = static_cast<uint32_t>(data.size());
  std::string chunk;
  for (const int shift : {24, 16, 8, 0}) chunk += static_cast<char>(length >> shift & 0xff);
  chunk += type + data;
  uint32_t crc = 0xffffffffU;
  for (const char c : type + data) {
    crc ^= static_cast<uint8_t>(c);
    for (int k = 0; k < 8; ++k) crc = (crc & 1U) != 0 ? 0xedb88320U ^ crc >> 1U : crc >> 1U;
  }
  crc = ~crc;
  for (const int shift : {24, 16, 8, 0}) chunk += static_cast<char>(crc >> shift & 0xff);
  write_file(png, text.insert(text.find("IDAT") - 4, chunk));
}

TEST_F(CompareRegions, ColourTagsThatDifferAreSaid) {
  EXPECT_TRUE(scores({})["warnings"].empty());
  insert_chunk(test, "cICP", std::string("\x09\x10\x00\x01", 4));
  const json out = scores({});
  ASSERT_EQ(out["warnings"].size(), 1U);
  EXPECT_NE(out["warnings"][0].get<std::string>().find("cICP 9/16/0/1"), std::string::npos) << out["warnings"];
  insert_chunk(reference, "cICP", std::string("\x09\x10\x00\x01", 4));
  EXPECT_TRUE(scores({})["warnings"].empty());
}

// A frame of four agents, and what the frame after shows of the second.
struct Drawn {
  Image8 codes{64, 24, 3};
  ImageU32 ids{64, 24, 1};
  ImageF depth{64, 24, 1};
  Drawn() { std::fill(codes.data.begin(), codes.data.end(), uint8_t{128}); }
  void box(uint32_t id, int left, int top, int width, int height, int red, float metres) {
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x) {
        *ids.at(x, y) = id;
        *depth.at(x, y) = metres;
        const int colour[] = {red, 40 + 4 * (x - left), 200 - 5 * (y - top)};
        for (int c = 0; c < 3; ++c) codes.at(x, y)[c] = static_cast<uint8_t>(colour[c]);
      }
  }
  void save(const fs::path& folder, const std::string& name) const {
    write_png(folder / (name + ".png"), codes);
    write_exr(folder / (name + "_ids.exr"), ids);
    write_exr(folder / (name + "_depth.exr"), depth);
  }
};

// One agent displaced, one a frame late, one recoloured, one behind another that it stood before.
TEST(Compare, WhatHappenedToEachAgentIsNamed) {
  const fs::path folder = scratch();
  const auto drawn = [](int moved, int leg, int red, bool behind) {
    Drawn out;
    out.box(1, 4 + moved, 4, 8, 14, 60, 5);
    out.box(2, 20, 4, 6, 10, 90, 5);
    out.box(2, leg, 14, 3, 6, 90, 5);
    out.box(3, 32, 4, 8, 14, red, 5);
    for (const bool first : {true, false})
      if (first == behind)
        out.box(4, 46, 4, 8, 14, 20, 5);
      else
        out.box(5, 50, 6, 8, 14, 220, behind ? 4.0F : 6.0F);
    return out;
  };
  drawn(0, 20, 30, false).save(folder, "a");
  drawn(2, 23, 180, true).save(folder, "b");
  drawn(0, 23, 30, false).save(folder, "late");
  const std::vector<std::string> files = {
      "--ids-ref",   (folder / "a_ids.exr").string(),   "--ids-test",   (folder / "b_ids.exr").string(),
      "--depth-ref", (folder / "a_depth.exr").string(), "--depth-test", (folder / "b_depth.exr").string(),
      "--pose-ref",  (folder / "late.png").string(),    "--ids-pose",   (folder / "late_ids.exr").string()};
  const json document = compared(folder / "a.png", folder / "b.png", files);
  const json& causes = document["causes"];
  // Agent 5 is 6 m away in one and 4 m in the other, where both show it; all others stand as far as they stood.
  EXPECT_EQ(document["agents"][4]["depth_mae"], 2.0);
  EXPECT_EQ(document["agents"][2]["depth_mae"], 0.0);
  EXPECT_GT(document["scores"]["depth_mae"].get<double>(), 0);
  const char* expected[] = {"place", "pose", "texture", "order"};
  int64_t sum = causes["residue"];
  for (const auto& [cause, amount] : causes["squared"].items()) sum += amount.is_null() ? 0 : amount.get<int64_t>();
  EXPECT_EQ(sum, causes["total"]);
  EXPECT_EQ(causes["residue"], 0);
  for (size_t i = 0; i < 4; ++i) {
    const json& agent = causes["agents"][i];
    EXPECT_EQ(agent["largest"], expected[i]) << agent;
    EXPECT_EQ(agent["squared"][expected[i]], agent["total"]) << agent;
  }
  EXPECT_EQ(causes["agents"][0]["displaced_px"], json({2, 0}));
  EXPECT_EQ(causes["agents"][1]["late"], true);
  EXPECT_EQ(causes["agents"][3]["changed_places_with"], json({5}));
  EXPECT_EQ(causes["agents"][4]["total"], 0);
  EXPECT_TRUE(causes["squared"]["view"].is_null());
  EXPECT_TRUE(causes["reasons"].contains("level"));

  const json untold = compared(folder / "a.png", folder / "b.png")["causes"];
  EXPECT_EQ(untold["residue"], untold["total"]);
  EXPECT_EQ(untold["total"], causes["total"]);
  EXPECT_EQ(untold["reasons"].size(), untold["squared"].size());
  std::vector<std::string> wrong = files;
  wrong[5] = wrong[1];
  EXPECT_NE(error_of(folder / "a.png", folder / "b.png", wrong).find("is not a picture of depths"), std::string::npos);
  EXPECT_THROW(compared(folder / "a.png", folder / "b.png", {"--pose-ref", "x.png"}), CLI::ParseError);
}

// The plane of a flat card is behind the surface that it shows: no agent moved for that. What lies farther behind than
// the body is thick is said, as what it is.
TEST(Compare, ACardsPlaneIsNoDisplacement) {
  const fs::path folder = scratch();
  Drawn body;
  body.box(1, 8, 4, 16, 14, 60, 5);
  const auto round = [&](int x) { return 5 + 0.3F * std::pow(static_cast<float>(x - 16) / 8, 2.0F); };
  for (int y = 4; y < 18; ++y)
    for (int x = 8; x < 24; ++x) *body.depth.at(x, y) = round(x);
  body.save(folder, "body");
  for (const float plane : {5.2F, 5.6F}) {
    Drawn card = body;
    card.box(1, 8, 4, 16, 14, 90, plane);
    card.save(folder, "card");
    const std::vector<std::string> files = {
        "--ids-ref",   (folder / "body_ids.exr").string(),   "--ids-test",   (folder / "card_ids.exr").string(),
        "--depth-ref", (folder / "body_depth.exr").string(), "--depth-test", (folder / "card_depth.exr").string()};
    const json agent = compared(folder / "body.png", folder / "card.png", files)["causes"]["agents"][0];
    EXPECT_TRUE(agent["displaced_m"].is_null()) << agent;
    EXPECT_EQ(agent["displaced_px"], json({0, 0}));
    EXPECT_NEAR(agent["surface_m"].get<double>(), plane - 5.075, 0.03);  // the median is half way to the edge
    EXPECT_NEAR(agent["thickness_m"].get<double>(), 0.27, 0.04);
    std::vector<std::string> words = {(folder / "body.png").string(), (folder / "card.png").string()};
    words.insert(words.end(), files.begin(), files.end());
    const std::string text = output_of(words);
    EXPECT_EQ(text.find("farther") != std::string::npos, plane > 5.5F) << text;
    EXPECT_EQ(text.find("the surface that is drawn for it 0.5") != std::string::npos, plane > 5.5F) << text;
  }
}

TEST(Compare, RefusesPicturesOfTwoSizesAndMissingFiles) {
  EXPECT_NE(error_of(kImages / "p10_tiny_1x1_ref.png", kImages / "p05_flat_offset_ref.png").find("is 64 x 48 pixels"),
            std::string::npos);
  EXPECT_NE(error_of(kImages / "p10_tiny_1x1_ref.png", kImages / "absent.png").find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::bench
