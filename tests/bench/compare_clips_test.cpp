// `compare` of clips, folders of frames and stacked clips, run in this process as the driver runs it.
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
#include "bench/experiments/clip_scores.h"
#include "bench/experiments/frame_pairs.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "metrics/flip.h"
#include "reports/page/libraries.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/stack.h"
#include "test_paths.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kShared = fs::path(CROWDBENCH_SHARED_DIR) / "ground-truth";

json compared(std::vector<std::string> arguments, int expected_status = 0) {
  CLI::App app;
  Run run;
  Command program(app);
  add_compare(program, run);
  arguments.insert(arguments.begin(), "compare");
  arguments.emplace_back("--json");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  int status = -1;
  std::string fault;
  try {
    status = run();
  } catch (const Error& error) {
    fault = error.what();
  }
  std::fflush(stdout);
  ::testing::internal::GetCapturedStderr();
  const std::string text = ::testing::internal::GetCapturedStdout();
  if (!fault.empty()) return {{"error", fault}};
  EXPECT_EQ(status, expected_status);
  return json::parse(text);
}

std::string error_of(std::vector<std::string> arguments) { return compared(std::move(arguments)).value("error", ""); }

// A bright square on grey that moves by two pixels a frame.
Image8 frame_of(int t, int brighter = 0) {
  Image8 out(64, 48, 3);
  std::fill(out.data.begin(), out.data.end(), static_cast<uint8_t>(100 + brighter));
  for (int y = 10; y < 30; ++y)
    for (int x = 4 + 2 * t; x < 20 + 2 * t; ++x) out.at(x, y)[0] = 220;
  return out;
}

// Frames whose names sort otherwise by letters, in folders a and b; b's frame 2 is 12 code values brighter.
class CompareFolders : public ::testing::Test {
 protected:
  CompareFolders() {
    fs::create_directories(a);
    fs::create_directories(b);
    for (int t = 0; t < 4; ++t) {
      const std::string name = fmt::format("frame{}.png", 9 + t);
      write_png(a / name, frame_of(t));
      write_png(b / name, frame_of(t, t == 2 ? 12 : 0));
    }
    write_file(a / "notes.txt", std::string_view("not a picture"));
  }
  support::ScratchFolder folder;
  fs::path a = folder / "a", b = folder / "b";
};

TEST(FramePairs, NamesAreOrderedAsPeopleCount) {
  std::vector<std::string> names = {"f10.png", "f9.png", "f1.png", "e100.png", "f010.png", "f1a.png", "f.png"};
  std::sort(names.begin(), names.end(), in_natural_order);
  EXPECT_EQ(names,
            (std::vector<std::string>{"e100.png", "f.png", "f1.png", "f1a.png", "f9.png", "f010.png", "f10.png"}));
  EXPECT_FALSE(in_natural_order("f1.png", "f1.png"));
  EXPECT_TRUE(in_natural_order("f99999999999999999999998.png", "f99999999999999999999999.png"));
}

TEST_F(CompareFolders, EveryFrameTheWholeAndTheWorst) {
  const json out = compared({a.string(), b.string(), "--maps", (folder / "maps").string()});
  EXPECT_EQ(out["frames"], 4);
  EXPECT_EQ(out["width"], 64);
  EXPECT_TRUE(out["fps"].is_null());
  // 12 in all samples but the red of the square's 16 x 20 pixels.
  const double mae = 12.0 * (3 * 64 * 48 - 16 * 20) / (3 * 64 * 48);
  for (size_t t = 0; t < 4; ++t) EXPECT_NEAR(out["by_frame"]["mae"][t].get<double>(), t == 2 ? mae : 0, 1e-12);
  EXPECT_NEAR(out["scores"]["mae"].get<double>(), mae / 4, 1e-12);
  EXPECT_EQ(out["worst_frames"]["mae"]["frame"], 2);
  EXPECT_NEAR(out["worst_frames"]["mae"]["value"].get<double>(), mae, 1e-12);
  EXPECT_EQ(out["pooling"]["mae"], "mean over frames");
  // Three frames are equal, whose PSNR is infinite: the mean is that of the fourth.
  EXPECT_EQ(out["by_frame"]["psnr"][0], "inf");
  EXPECT_EQ(out["scores"]["psnr"], out["by_frame"]["psnr"][2]);
  EXPECT_EQ(out["pooling"]["psnr"], "mean over frames that are finite");
  EXPECT_EQ(out["worst_frames"]["flip"]["frame"], 2);
  const double flip = metrics::flip_pooled(metrics::flip_map(frame_of(2), frame_of(2, 12))).mean;
  EXPECT_NEAR(out["scores"]["flip"]["mean"].get<double>(), flip / 4, 1e-12);
  EXPECT_FALSE(out["by_frame"].contains("cvvdp")) << "without a frame rate";
  EXPECT_TRUE(fs::exists(folder / "maps" / "flip_map_frame0002.png"));
  EXPECT_TRUE(fs::exists(folder / "maps" / "error_pseudocolour_frame0002.png"));
}

// Errors of 0, 0, e and 0 by pixel: their second differences are e in frame 2, 2 e in frame 3.
TEST_F(CompareFolders, AScoreOverTimeHasItsFramesItsWorstAndItsMap) {
  const json out = compared({a.string(), b.string(), "--scores", "flicker,mae", "--maps", (folder / "maps").string()});
  // 12 brighter, but the red of the square's 16 x 20 pixels, which is 0.299 of luma.
  const double mean = (12.0 * (64 * 48 - 16 * 20) + 12.0 * 0.701 * 16 * 20) / (64 * 48);
  const json& frames = out["by_frame"]["flicker"];
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_TRUE(frames[0].is_null()) << "no value is no 0";
  EXPECT_TRUE(frames[1].is_null());
  EXPECT_NEAR(frames[2].get<double>(), mean, 1e-9);
  EXPECT_NEAR(frames[3].get<double>(), 2 * mean, 1e-9);
  EXPECT_NEAR(out["scores"]["flicker"].get<double>(), 1.5 * mean, 1e-9);
  EXPECT_EQ(out["worst_frames"]["flicker"]["frame"], 3);
  EXPECT_EQ(out["worst_frames"]["flicker"]["value"], frames[3]);
  EXPECT_EQ(out["pooling"]["flicker"], "over time, as the score itself pools");
  EXPECT_TRUE(fs::exists(folder / "maps" / "flicker_map_frame0003.png"));
  const json equal = compared({a.string(), a.string(), "--scores", "flicker"});
  EXPECT_EQ(equal["by_frame"]["flicker"], json::parse("[null, null, 0.0, 0.0]"));
  EXPECT_FALSE(equal["worst_frames"].contains("flicker")) << "none is worse than equal frames are";
  for (const char* name : {"frame11.png", "frame12.png"}) fs::remove(a / name);
  const json two = compared({a.string(), a.string(), "--scores", "flicker"});
  EXPECT_EQ(two["by_frame"]["flicker"], json::parse("[null, null]"));
  EXPECT_TRUE(two["scores"]["flicker"].is_null());
  EXPECT_FALSE(two["worst_frames"].contains("flicker"));
}

// Of every frame the least and the greatest pixel: the clip's are those of all frames, and the rest are means.
TEST_F(CompareFolders, ExtremesArePooledAsExtremes) {
  write_png(b / "frame9.png", frame_of(0, 30));
  const json out = compared({a.string(), b.string(), "--scores", "flip"});
  std::vector<metrics::FlipPooled> of;  // frames 0 and 2 differ everywhere, 1 and 3 nowhere
  for (int t = 0; t < 4; ++t)
    of.push_back(metrics::flip_pooled(metrics::flip_map(frame_of(t), frame_of(t, t == 0 ? 30 : t == 2 ? 12 : 0))));
  ASSERT_GT(of[2].min, 0);
  ASSERT_GT(of[0].max, of[2].max);
  EXPECT_EQ(out["scores"]["flip"]["min"], 0) << "not the mean of the minima";
  EXPECT_EQ(out["scores"]["flip"]["max"].get<double>(), of[0].max);
  EXPECT_NEAR(out["scores"]["flip"]["q3"].get<double>(), (of[0].q3 + of[2].q3) / 4, 1e-12);
  EXPECT_EQ(out["pooling"]["flip"], "mean over frames; min the least and max the greatest of all frames");
}

// By hand: a figure of each kind over three frames, one of them infinite.
TEST(FigureOverFrames, MeanLeastAndGreatestOfTheFiniteOnes) {
  using metrics::OverFrames;
  FigureOverFrames figure;
  EXPECT_EQ(figure.pooled(OverFrames::least, 7), 7) << "no frame yet";
  for (const double value : {-1.0, std::numeric_limits<double>::infinity(), -4.0}) figure.add(value);
  EXPECT_EQ(figure.pooled(OverFrames::mean, 7), -2.5);
  EXPECT_EQ(figure.pooled(OverFrames::least, 7), -4);
  EXPECT_EQ(figure.pooled(OverFrames::greatest, 7), -1);
}

TEST_F(CompareFolders, ScoresAreChosenAndBounded) {
  const json out =
      compared({a.string(), b.string(), "--scores", "flip,mae", "--fail-above", "mae=2", "--fps", "25"}, 1);
  EXPECT_EQ(out["scores"].size(), 2U);
  EXPECT_EQ(out["fps"], 25);
  EXPECT_EQ(out["bounds"][0]["pass"], false);
  EXPECT_EQ(error_of({a.string(), b.string(), "--scores", "flop"}),
            "--scores: there is no score 'flop'; did you mean 'flip'?");
  EXPECT_NE(error_of({a.string(), b.string(), "--colours", "jet"}).find("choose own, plain, error, magma or viridis"),
            std::string::npos);
}

TEST_F(CompareFolders, AreCharted) {
  try {
    reports::chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  compared(
      {a.string(), b.string(), "--scores", "flip,flicker", "--fps", "25", "--chart", (folder / "chart.html").string()});
  const std::string page = read_text(folder / "chart.html", size_t{64} << 20);
  EXPECT_NE(page.find("Two clips compared"), std::string::npos);
  EXPECT_NE(page.find("\"seconds\":0.08"), std::string::npos) << "frame 2 at 25 a second";
  EXPECT_NE(page.find("frame 2 (0.08 s)"), std::string::npos);
  EXPECT_NE(page.find("FLIP"), std::string::npos);
  EXPECT_NE(page.find("Flicker, code values, frame 3 (0.12 s)"), std::string::npos) << "the map of its worst frame";
}

TEST(FrameNumbers, WhatIsMissingIsSaid) {
  const auto missing = [](const std::vector<const char*>& names) {
    return missing_numbers(std::vector<fs::path>(names.begin(), names.end()));
  };
  EXPECT_EQ(missing({"f/a_000.png", "f/a_001.png", "f/a_004.png", "f/a_009.png"}),
            "frames 2 to 3 are missing (files are numbered 0 to 9); the others are taken one after the other");
  EXPECT_EQ(missing({"8.exr", "9.exr", "11.exr"}),
            "frame 10 is missing (files are numbered 8 to 11); the others are taken one after the other");
  EXPECT_EQ(missing({"a10.png", "a20.png", "a30.png"}), "") << "every tenth";
  EXPECT_EQ(missing({"a1.png", "a7.png"}), "");
  EXPECT_EQ(missing({"a1.png", "b2.png", "c9.png"}), "") << "names of their own";
  EXPECT_EQ(missing({"a1.png", "a2.exr", "a9.png"}), "");
  EXPECT_EQ(missing({"a1.png", "b.png", "a9.png"}), "");
  EXPECT_EQ(missing({"99999999999999999999999.png", "a1.png"}), "");
}

TEST_F(CompareFolders, AGapInTheNumbersIsSaid) {
  EXPECT_EQ(compared({a.string(), b.string(), "--scores", "mae"})["warnings"].size(), 0U);
  for (const fs::path& side : {a, b}) fs::remove(side / "frame10.png");
  const json out = compared({a.string(), b.string(), "--scores", "mae"});
  ASSERT_EQ(out["warnings"].size(), 2U);
  EXPECT_EQ(out["warnings"][1], b.string() +
                                    ": frame 10 is missing (files are numbered 9 to 12); the others are taken "
                                    "one after the other");
}

TEST_F(CompareFolders, WhatDoesNotGoTogetherIsRefused) {
  EXPECT_NE(error_of({a.string(), (b / "frame9.png").string()}).find("is one picture"), std::string::npos);
  fs::remove(b / "frame12.png");
  EXPECT_NE(error_of({a.string(), b.string()}).find("ends after 3 frames"), std::string::npos);
  write_png(b / "frame12.png", Image8(10, 10, 3));
  EXPECT_NE(error_of({a.string(), b.string()}).find("frame 3 is 10 x 10 pixels, not 64 x 48"), std::string::npos);
  fs::create_directories(folder / "none");
  EXPECT_NE(error_of({a.string(), (folder / "none").string()}).find("has no pictures"), std::string::npos);
  EXPECT_NE(error_of({a.string()}).find("has nothing to be compared with"), std::string::npos);
  EXPECT_NE(error_of({a.string(), (folder / "absent").string()}).find("absent: no such file or folder"),
            std::string::npos);
  EXPECT_NE(error_of({a.string(), b.string(), "--ids-ref", "x.exr", "--ids-test", "x.exr"}).find("ids are of pictures"),
            std::string::npos);
}

// Frames in float: what is not finite is counted over all and placed by its first.
TEST(CompareFloatFrames, NotFiniteIsCountedAndPlaced) {
  const support::ScratchFolder folder;
  fs::create_directories(folder / "a");
  fs::create_directories(folder / "b");
  for (int t = 0; t < 3; ++t) {
    ImageF image(12, 12, 3);
    std::fill(image.data.begin(), image.data.end(), 0.5F);
    write_exr(folder / "a" / fmt::format("{}.exr", t), image);
    if (t == 1) image.at(7, 3)[1] = std::numeric_limits<float>::quiet_NaN();
    if (t == 2) image.at(2, 2)[0] = std::numeric_limits<float>::infinity();
    write_exr(folder / "b" / fmt::format("{}.exr", t), image);
  }
  const json out = compared({(folder / "a").string(), (folder / "b").string()});
  EXPECT_EQ(out["not_finite"]["test"], json::parse(R"({"nan": 1, "infinite": 1, "frame": 1, "first": [7, 3]})"));
  EXPECT_EQ(out["not_finite"]["reference"], json::parse(R"({"nan": 0, "infinite": 0})"));
  EXPECT_EQ(out["warnings"].size(), 1U);
  EXPECT_EQ(out["warnings"][0],
            "the test has 1 pixel that is not a number and 1 infinite, the first at (7, 3), in frame 1");
  for (const char* name : {"linear_mae", "linear_rms", "hdr_flip"}) {
    EXPECT_TRUE(out["by_frame"][name][1].is_null()) << name;
    EXPECT_TRUE(out["by_frame"][name][2].is_null()) << name;
    EXPECT_EQ(out["by_frame"][name][0], 0) << name;
    // What is equal in the other frames makes no score of the clip.
    EXPECT_TRUE(out["scores"][name].is_null()) << name << out["scores"][name];
    EXPECT_EQ(out["reasons"][name],
              "frame 1: the test has 1 pixel that is not a number, the first at (7, 3); so it is in 2 of 3 frames");
    EXPECT_FALSE(out["worst_frames"].contains(name)) << name;
    EXPECT_FALSE(out["pooling"].contains(name)) << name;
  }
  EXPECT_EQ(out["equal_frames"], 1);
  // A display of light: no frame of it is a score either.
  const json seen = compared({(folder / "a").string(), (folder / "b").string(), "--fps", "30", "--scores", "cvvdp",
                              "--display", "standard_hdr_linear"});
  EXPECT_TRUE(seen["scores"]["cvvdp"].is_null());
  EXPECT_EQ(seen["reasons"]["cvvdp"], "frame 1: the test has 1 pixel that is not a number, the first at (7, 3)");
  // Nor does it keep a bound.
  for (const char* name : {"linear_mae", "hdr_flip"}) {
    const json bound =
        compared({(folder / "a").string(), (folder / "b").string(), "--fail-above", std::string(name) + "=0.5"}, 1);
    EXPECT_EQ(bound["bounds"][0]["pass"], false) << name;
    EXPECT_TRUE(bound["bounds"][0]["value"].is_null()) << name;
  }
}

// Where nothing differs no frame is the worst, whatever its PSNR is.
TEST_F(CompareFolders, OfEqualClipsNoFrameIsTheWorst) {
  const json out = compared({a.string(), a.string(), "--fps", "25"});
  EXPECT_EQ(out["equal_frames"], out["frames"]);
  EXPECT_TRUE(out["worst_frames"].empty()) << out["worst_frames"];
  EXPECT_EQ(out["scores"]["psnr"], "inf");
  EXPECT_EQ(out["by_frame"]["psnr"][0], "inf");
  const json other = compared({a.string(), b.string(), "--fps", "25"});
  EXPECT_LT(other["equal_frames"], other["frames"]);
  EXPECT_TRUE(other["worst_frames"].contains("psnr"));
}

TEST(CompareClips, AClipAndItsStackedHalves) {
  const support::ScratchFolder folder;
  studies::ClipSettings settings;
  settings.fps = 30;
  settings.master = true;
  const auto write_clip = [&](const fs::path& path, const auto& frame) {
    const Image8 first = frame(0);
    studies::ClipWriter writer(path, first.width, first.height, settings);
    for (int t = 0; t < 5; ++t) writer.add(frame(t));
    ASSERT_TRUE(writer.finish().accurate);
  };
  const auto reference = [](int t) { return frame_of(t); };
  const auto test = [](int t) { return frame_of(t, t == 3 ? 20 : 0); };
  write_clip(folder / "a.mp4", reference);
  write_clip(folder / "b.mp4", test);
  // The lossless copies hold the frames themselves.
  const json out = compared({(folder / "a.master.mp4").string(), (folder / "b.master.mp4").string()});
  EXPECT_EQ(out["frames"], 5);
  EXPECT_EQ(out["fps"], 30);
  EXPECT_EQ(out["worst_frames"]["mae"]["frame"], 3);
  EXPECT_EQ(out["by_frame"]["mae"][0], 0);
  const double mae = out["by_frame"]["mae"][3].get<double>();
  settings.fps = 25;
  write_clip(folder / "slow.mp4", test);
  const std::vector<std::string> rates = {(folder / "a.mp4").string(), (folder / "slow.mp4").string()};
  EXPECT_NE(error_of(rates).find("has 25 frames a second"), std::string::npos);
  EXPECT_EQ(compared({rates[0], rates[1], "--fps", "25", "--scores", "mae"})["fps"], 25);
  settings.fps = 30;

  // a below: the manifest says which half is which.
  write_clip(folder / "stacked.mp4", [&](int t) { return studies::stack_vertically(test(t), reference(t)); });
  const json manifest = {{"format", "crowdbench-pair-1"},
                         {"top", {{"configuration", "b"}, {"representation", "flat"}}},
                         {"bottom", {{"configuration", "a"}, {"representation", "mesh"}}},
                         {"half", {{"width", 64}, {"height", 48}}},
                         {"bar", {{"height", 8}}}};
  fs::rename(folder / "stacked.master.mp4", folder / "stacked.mp4");
  write_file(folder / "stacked.json", std::string_view(manifest.dump()));
  const json halves = compared({(folder / "stacked.mp4").string()});
  EXPECT_EQ(halves["reference"], "mesh");
  EXPECT_EQ(halves["test"], "flat");
  EXPECT_EQ(halves["width"], 64);
  EXPECT_EQ(halves["height"], 48);
  EXPECT_EQ(halves["worst_frames"]["mae"]["frame"], 3);
  EXPECT_EQ(halves["by_frame"]["mae"][3], mae);
  EXPECT_EQ(halves["by_frame"]["mae"][1], 0);
  EXPECT_EQ(halves["display"]["name"], "standard_4k");
  EXPECT_EQ(halves["display"]["given"], false);

  // The display is that of the scenario which drew the clip, as a model, as keys or as a file beside it.
  const auto on_the_display_of = [&](const std::string& toml, std::vector<std::string> more = {}) {
    json said = manifest;
    said["scenario"] = {{"toml", toml}};
    write_file(folder / "stacked.json", std::string_view(said.dump()));
    more.insert(more.begin(), (folder / "stacked.mp4").string());
    return compared(std::move(more));
  };
  scene::Scenario scenario;
  scenario.display.model = "standard_fhd";
  const json modelled = on_the_display_of(scene::to_toml(scenario), {"--scores", "flip,cvvdp"});
  EXPECT_EQ(modelled["display"]["name"], "standard_fhd");
  EXPECT_EQ(modelled["display"]["given"], true);
  EXPECT_EQ(modelled["display"]["from"], (folder / "stacked.json").string());
  const json asked =
      compared({(folder / "stacked.mp4").string(), "--scores", "flip,cvvdp", "--display", "standard_fhd"});
  EXPECT_EQ(modelled["scores"], asked["scores"]);
  EXPECT_EQ(modelled["conditions"], asked["conditions"]);
  EXPECT_FALSE(asked["display"].contains("from"));
  EXPECT_NE(modelled["scores"], on_the_display_of("", {"--scores", "flip,cvvdp"})["scores"]);
  const json other = on_the_display_of(scene::to_toml(scenario), {"--scores", "mae", "--display", "standard_phone"});
  EXPECT_EQ(other["display"]["name"], "standard_phone") << "--display goes first";
  scenario.display = {};
  scenario.display.pixels_per_degree = 31;
  scenario.display.max_luminance = 120;
  EXPECT_EQ(on_the_display_of(scene::to_toml(scenario), {"--scores", "mae"})["display"]["pixels_per_degree"], 31);
  scenario.display = {};
  scenario.display.model = "mine.json";
  const std::string gone = on_the_display_of(scene::to_toml(scenario)).value("error", "");
  EXPECT_NE(gone.find("mine.json"), std::string::npos) << gone;
  EXPECT_NE(gone.find("--display"), std::string::npos) << gone;
  write_file(folder / "mine.json", std::string_view(R"({"pixels_per_degree": 42, "max_luminance": 100})"));
  EXPECT_EQ(on_the_display_of(scene::to_toml(scenario), {"--scores", "mae"})["display"]["pixels_per_degree"], 42);
  EXPECT_NE(on_the_display_of("display = [").value("error", "").find("stacked.json"), std::string::npos);
  write_file(folder / "stacked.json", std::string_view("{}"));
  EXPECT_NE(error_of({(folder / "stacked.mp4").string()}).find("is not a manifest"), std::string::npos);
  write_file(folder / "stacked.json",
             std::string_view(R"({"format": "crowdbench-pair-1", "half": {"width": 64, "height": 900},
               "bar": {"height": 8}, "top": {"configuration": "a", "representation": "x"},
               "bottom": {"configuration": "b", "representation": "y"}})"));
  EXPECT_NE(error_of({(folder / "stacked.mp4").string()}).find("too few for the halves"), std::string::npos);
}

// The ground-truth sequence: FLIP of every frame as NVIDIA's tool has it, and the pop at its frame.
TEST(CompareClips, TheSequenceWithAPop) {
  if (!fs::exists(kShared)) GTEST_SKIP() << "needs the shared ground-truth folder";
  const support::ScratchFolder folder;
  for (const char* side : {"ref", "test"}) {
    fs::create_directories(folder / side);
    for (int t = 0; t < 16; ++t)
      fs::copy_file(kShared / fmt::format("sequence/{}_{:02}.png", side, t), folder / side / fmt::format("{}.png", t));
  }
  std::string text = read_text(kShared / "expected.json");
  const std::string bare = " Infinity";
  for (size_t at = 0; (at = text.find(bare, at)) != std::string::npos;) text.replace(at, bare.size(), " null");
  const json expected = json::parse(text)["sequence"]["per_frame"];
  const json out = compared(
      {(folder / "ref").string(), (folder / "test").string(), "--fps", "30", "--scores", "flip,ssim,mse,cvvdp"});
  // On the display that compare takes by default.
  const json cvvdp = json::parse(read_text(kShared / "cvvdp" / "expected.json", size_t{64} << 20))["cases"];
  EXPECT_NEAR(out["scores"]["cvvdp"].get<double>(), cvvdp["sequence@standard_4k@30fps"]["jod"].get<double>(), 1e-4);
  EXPECT_EQ(out["display"]["name"], "standard_4k");
  // What each frame adds to it: nothing before the pop at frame 8, and ever more while the filter fills.
  ASSERT_EQ(out["by_frame"]["cvvdp"].size(), 16U);
  for (size_t t = 0; t < 16; ++t) EXPECT_EQ(out["by_frame"]["cvvdp"][t] == 10, t < 8) << t;
  EXPECT_EQ(out["worst_frames"]["cvvdp"]["frame"], 15);
  EXPECT_EQ(out["worst_frames"]["cvvdp"]["value"],
            *std::min_element(out["by_frame"]["cvvdp"].begin(), out["by_frame"]["cvvdp"].end()));
  const json backwards = compared({(folder / "ref").string(), (folder / "test").string(), "--fps", "30", "--scores",
                                   "cvvdp", "--padding", "symmetric"});
  EXPECT_NEAR(backwards["scores"]["cvvdp"].get<double>(),
              cvvdp["sequence@standard_4k@30fps@symmetric"]["jod"].get<double>(), 1e-4);
  double sum = 0;
  for (size_t t = 0; t < 16; ++t) {
    EXPECT_NEAR(out["by_frame"]["flip"][t].get<double>(), expected[t]["flip_mean"].get<double>(), 2e-4) << t;
    EXPECT_NEAR(out["by_frame"]["ssim"][t].get<double>(), expected[t]["ssim_luma601"].get<double>(), 1e-6) << t;
    EXPECT_NEAR(out["by_frame"]["mse"][t].get<double>(), expected[t]["mse_rgb"].get<double>(), 1e-6) << t;
    EXPECT_EQ(out["by_frame"]["flip"][t].get<double>() == 0, t < 8) << "the pop is at frame 8";
    sum += out["by_frame"]["flip"][t].get<double>();
  }
  EXPECT_NEAR(out["scores"]["flip"]["mean"].get<double>(), sum / 16, 1e-12);
}

// Where no frame has a value there is a reason, and where all are infinite the whole is too.
TEST(ClipComparison, AbsentAndInfinite) {
  const Image8 tiny(5, 5, 3);
  metrics::ScoreInput input;
  input.reference.codes = input.test.codes = &tiny;
  ClipComparison comparison(metrics::scores(), metrics::kNeedsCodes);
  comparison.take(input);
  comparison.take(input);
  for (const ClipScore& of : comparison.finish()) {
    if (of.score->name == "ssim") {
      EXPECT_FALSE(of.result.value);
      EXPECT_NE(of.result.reason.find("11 pixels"), std::string::npos);
      EXPECT_EQ(of.absent, 2U);
    } else if (of.score->name == "psnr") {
      EXPECT_EQ(of.result.value, std::numeric_limits<double>::infinity());
      EXPECT_EQ(pooling_text(of), "mean over frames");
    } else if (of.score->name == "flicker") {
      EXPECT_TRUE(of.over_time);
      EXPECT_NE(of.result.reason.find("three frames"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace crowdbench::bench
