#include "studies/plan/export.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "scene/cast/load_cast.h"
#include "studies/stimuli/bodies.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/proof.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// Two conditions, six frames, a few walkers; all of the tests below share one context.
constexpr char kTiny[] = R"(
training = 1
[scenario]
width = 128
height = 72
crowd.agents = 6
camera.eye = [0.0, 2.0, 14.0]
camera.target = [0.0, 0.9, 0.0]
[[scenario.character]]
source = "mannequin:triangles=500"
[conditions]
test = "mesh:triangles=200"
[factors]
mesh.triangles = [120, 200]
[stimulus]
seconds = 0.2
lead_in_seconds = 0.1
crowds = 1
largest_px = 40
[method]
repeats = 1
[catch]
identical = 1
broken = 1
)";

class ExportGl : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("crowdbench-export-" + std::to_string(::getpid()));
  fs::path file = folder / "tiny.toml";
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  static gl::Context& context() {
    static gl::Context shared;
    return shared;
  }
  Exported run(const std::string& toml, const std::string& out, bool webm = false) {
    write_file(file, toml);
    const StudyPlan plan = read_study_plan(file);
    ExportSettings settings;
    settings.webm = webm;
    settings.score_every_seconds = 0.1;
    return export_study(context(), plan, freeze(file, plan, {}, true), folder / out, settings);
  }
  std::string fault(const std::string& toml) {
    try {
      run(toml, "refused");
    } catch (const Error& error) {
      return error.what();
    }
    return "no fault";
  }
  // Of 5 x 5 pixels.
  static double mean_around(const Image8& image, int x, int y, size_t channel) {
    int sum = 0;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) sum += image.at(x + dx, y + dy)[channel];
    return sum / 25.0;
  }
  static std::string with(std::string toml, const std::string& from, const std::string& to) {
    const size_t at = toml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return toml.replace(at, from.size(), to);
  }
};

TEST_F(ExportGl, SaysWhichConditionsAreDrawnAlike) {
  std::string toml = kTiny;
  const auto change = [&](const std::string& from, const std::string& to) {
    toml.replace(toml.find(from), from.size(), to);
  };
  change("\"mesh:triangles=200\"", "\"hybrid(mesh,(mesh:triangles=150))\"");
  change("mesh.triangles = [120, 200]", "switch_m = [2, 5, 100]");
  const Exported exported = run(toml, "out");
  const std::vector<std::string> alike = {
      "switch_m=2 and switch_m=5 are drawn alike, frame by frame: nobody can tell them apart"};
  std::vector<std::string> said;
  for (const std::string& warning : exported.warnings)
    if (warning.find("alike") != std::string::npos) said.push_back(warning);
  EXPECT_EQ(said, alike) << "nobody is nearer than 5 m, everybody than 100 m";
}

TEST_F(ExportGl, FolderIsWhatThePageAndTheAnalysisNeed) {
  const Exported exported = run(kTiny, "out", true);
  EXPECT_EQ(exported.kept_halves + exported.kept_stimuli, 0U);
  EXPECT_GT(exported.worst_share, 0);
  EXPECT_LE(exported.worst_share, 0.25);
  const fs::path out = folder / "out";
  const json trials = json::parse(read_text(out / "page" / "trials.json"));
  const json sides = json::parse(read_text(out / "sides.json"));
  const json study = json::parse(read_text(out / "study.json"));
  EXPECT_NE(study.at("browsers").at("clips/*.mp4").get<std::string>().find("refused by Safari"), std::string::npos);
  EXPECT_EQ(trials.at("study"), study.at("hash"));
  EXPECT_EQ(trials.at("frames"), 6);
  EXPECT_EQ(trials.at("height"), 72 * 2 + 16);
  EXPECT_EQ(trials.at("answers").size(), 3U);
  EXPECT_EQ(trials.at("lists").size(), 4U);
  EXPECT_EQ(trials.at("lists")[0].at("trials").size(), 2U + 2 + 1);
  ASSERT_EQ(trials.at("stimuli").size(), sides.at("stimuli").size());
  EXPECT_EQ(exported.stacked, sides.at("stimuli").size());

  // What participants are given says nothing of representations, sides and order of making. Hashes may hold any digits.
  const std::string shown = read_text(out / "page" / "trials.json");
  for (const char* const secret : {"mesh", "triangles", "\"c01", "test_on_top", "upper\":", "broken", "identical"})
    EXPECT_EQ(shown.find(secret), std::string::npos) << secret;
  std::set<fs::file_time_type> dates;
  for (const auto& entry : fs::recursive_directory_iterator(out / "page"))
    if (entry.is_regular_file()) dates.insert(fs::last_write_time(entry.path()));
  EXPECT_EQ(dates.size(), 1U);

  std::set<std::string> kinds;
  for (const json& stimulus : study.at("stimuli")) {
    kinds.insert(stimulus.at("kind"));
    const std::string id = stimulus.at("id");
    EXPECT_EQ(stimulus.at("expected"), sides.at("stimuli").at(id).at("expected"));
    EXPECT_EQ(stimulus.at("equal").get<bool>(), stimulus.at("kind") == "identical");
    ASSERT_EQ(stimulus.at("files").size(), 2U);
    for (const json& entry : stimulus.at("files")) {
      const fs::path clip = out / "page" / entry.at("src").get<std::string>();
      EXPECT_EQ(file_sha256(clip), entry.at("sha256"));
      const bool webm = clip.extension() == ".webm";
      EXPECT_NE(entry.at("type").get<std::string>().find(webm ? "vp09.01." : "avc1.F4"), std::string::npos);
      ClipReader reader(clip);
      EXPECT_EQ(reader.tags().pixel_format, "yuv444p");
      EXPECT_EQ(reader.tags().matrix, "bt709");
      EXPECT_EQ(reader.tags().range, "tv");
      ClipReader::Frame frame;
      size_t count = 0;
      const json& check = stimulus.at("check_frame");
      for (; reader.next(frame); ++count) {
        EXPECT_NEAR(static_cast<double>(frame.pts) * frame.time_base_numerator / frame.time_base_denominator,
                    static_cast<double>(count) / 30, webm ? 0.0006 : 1e-9);
        if (count != check.at("index").get<size_t>()) continue;
        ASSERT_GE(check.at("colours").size(), 2U);
        for (const json& spot : check.at("colours"))
          for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(mean_around(frame.rgb, spot.at("x"), spot.at("y"), c), spot.at("rgb")[c].get<int>(), 6);
      }
      EXPECT_EQ(count, 6U);
      const json& proof = stimulus.at("proof").at(webm ? "vp9" : "h264");
      EXPECT_LE(proof.at("bar_deviation").get<int>(), kBarDeviation);
      if (stimulus.at("kind") == "test") {
        EXPECT_GT(proof.at("artefact_pixels").get<int>(), 0);
        EXPECT_LE(proof.at("share").get<double>(), 0.25);
      }
    }
    if (stimulus.at("kind") != "test") continue;
    ASSERT_FALSE(stimulus.at("scores").empty());
    EXPECT_EQ(stimulus.at("scores")[0].at("frames"), 2);
    // Two crowds: the halves show different ones.
    EXPECT_NE(stimulus.at("upper").at("seed"), stimulus.at("lower").at("seed"));
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"test", "identical", "broken"}));
  for (const json& half : study.at("halves")) {
    EXPECT_LE(half.at("tallest_px").get<int>(), 40);
    EXPECT_GT(half.at("most_figures").get<int>(), 0);
    EXPECT_GT(half.at("spacing_m").get<double>(), 1.0);
  }

  // Once more: all is kept. Elsewhere: the same bytes. Without a clip: that one is made again.
  EXPECT_EQ(run(kTiny, "out", true).stacked, 0U);
  const Exported again = run(kTiny, "other", true);
  EXPECT_EQ(again.stacked, exported.stacked);
  EXPECT_EQ(read_text(folder / "other" / "page" / "trials.json"), shown);
  const json second = json::parse(read_text(folder / "other" / "study.json"));
  for (size_t i = 0; i < study.at("stimuli").size(); ++i)
    EXPECT_EQ(study.at("stimuli")[i].at("video").at("frame_sha256"),
              second.at("stimuli")[i].at("video").at("frame_sha256"));
  fs::remove(out / "page" / "clips" / "s001.mp4");
  const Exported repaired = run(kTiny, "out", true);
  EXPECT_EQ(repaired.stacked, 1U);
  EXPECT_EQ(repaired.drawn, 0U);

  // Another plan does not land in the same folder.
  EXPECT_THROW(run(with(kTiny, "repeats = 1", "repeats = 2"), "out"), Error);
}

TEST_F(ExportGl, PromisesAreKeptOrTheClipIsRefused) {
  EXPECT_NE(fault(with(kTiny, "largest_px = 40", "largest_px = 4")).find("more than `largest_px` = 4"),
            std::string::npos);
  EXPECT_NE(fault(with(kTiny, "crowd.agents = 6", "crowd.agents = 40\ncrowd.spacing = 0.7\ncrowd.motion = \"free\""))
                .find("may stand in each other in frame 0"),
            std::string::npos);
  EXPECT_NE(
      fault(with(kTiny, "camera.target = [0.0, 0.9, 0.0]", "camera.target = [0.0, 0.9, 99.0]")).find("nobody is seen"),
      std::string::npos);
  EXPECT_NE(fault(with(kTiny, "largest_px = 40", "largest_px = 40\nleast_psnr = 80")).find("h264 even at rate factor"),
            std::string::npos);
  // Nothing that was refused is left behind.
  for (const auto& entry : fs::recursive_directory_iterator(folder / "refused" / "page"))
    EXPECT_FALSE(entry.is_regular_file()) << entry.path();
}

TEST(Bodies, TouchWhereTheirRectanglesDo) {
  scene::Scenario scenario;
  scenario.crowd.agents = 49;
  scenario.crowd.motion = scene::MotionKind::lanes;
  scenario.characters[0].source = "mannequin:triangles=500";
  const scene::Cast cast = scene::load_cast(scenario);
  const auto touching = [&](uint64_t tick) {
    const scene::Crowd crowd = scene::make_crowd(scenario, cast, scene::stage_view(scenario));
    return touching_bodies(make_frame(scenario, cast, crowd, scenario.camera.at(0), tick, false), cast).has_value();
  };
  scenario.crowd.spacing = spacing_of_bodies(scenario, cast);
  EXPECT_GT(scenario.crowd.spacing, 0.9);
  EXPECT_LT(scenario.crowd.spacing, 2.5);
  for (const uint64_t tick : {0U, 45U, 301U}) EXPECT_FALSE(touching(tick)) << tick;
  scenario.crowd.motion = scene::MotionKind::free;  // each its own way
  scenario.crowd.spacing = 0.7;
  EXPECT_TRUE(touching(0));
}

// Twelve pixels of artefact, by hand: test and reference differ by 30 in red at four pixels of each of three frames.
TEST(ClipProof, IsTheRatioOfTwoErrors) {
  constexpr int kWidth = 16, kHalf = 32;
  StackStyle style;
  style.bar_height = 8;
  ProofRecorder recorder(kWidth, kHalf, style, 0.25);
  Image8 reference(kWidth, kHalf, 3);
  std::fill(reference.data.begin(), reference.data.end(), uint8_t{100});
  Image8 test = reference;
  for (int x = 4; x < 8; ++x) test.at(x, 10)[0] = 130;
  test.at(12, 3)[1] = 108;  // as little as dithering: not an artefact
  std::vector<uint8_t> raw = stack_vertically(test, reference, style).data;
  for (int f = 0; f < 3; ++f) recorder.expect(test, reference, true, false);
  const ClipCheck check = recorder.check();
  const auto encode = [&](int error, int bar) {
    for (size_t f = 0; f < 3; ++f) {
      std::vector<uint8_t> decoded = raw;
      for (int x = 4; x < 8; ++x) decoded[static_cast<size_t>(10 * kWidth + x) * 3] += static_cast<uint8_t>(error);
      for (int x = 0; x < kWidth; ++x)
        decoded[static_cast<size_t>((kHalf + 4) * kWidth + x) * 3 + 2] = static_cast<uint8_t>(bar);
      check.frame(f, raw, decoded);
    }
    return check.missing_db();
  };
  EXPECT_EQ(encode(6, 0), 0);
  EXPECT_EQ(recorder.proof().artefact_pixels, 12U);
  EXPECT_DOUBLE_EQ(recorder.proof().artefact_rms, std::sqrt(30.0 * 30 / 3));
  EXPECT_DOUBLE_EQ(recorder.proof().decoded_rms, std::sqrt(6.0 * 6 / 3));
  EXPECT_EQ(recorder.refusal(), "");
  EXPECT_NEAR(encode(15, 0), 20 * std::log10(2.0), 1e-9);  // half of it, where a quarter is allowed
  EXPECT_NE(recorder.refusal().find("decoding changes the 12 pixels under test by 8.66 code values"), std::string::npos)
      << recorder.refusal();
  EXPECT_GT(encode(0, 13), 0);
  EXPECT_NE(recorder.refusal().find("one half bleeds into it"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::studies
