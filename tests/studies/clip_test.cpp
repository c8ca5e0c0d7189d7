#include "studies/stimuli/clip.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/hash.h"
#include "core/random.h"
#include "studies/stimuli/crowd_clip.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

class ClipTest : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("crowdbench-clip-" + std::to_string(::getpid()) + "-" +
                                                 testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
};

// Small saturated figures that move over a grey gradient: what a crowd clip is made of. noise: 0..255, grain of each
// channel, new in every frame.
Image8 picture(int width, int height, int frame, int noise = 0) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      uint8_t* pixel = image.at(x, y);
      const int cell = ((x + frame) / 6 + 3 * (y / 9)) % 7;
      const bool figure = (x + frame) % 6 < 3 && y % 9 < 7 && cell < 4;
      for (int c = 0; c < 3; ++c) {
        int value = figure ? (cell == c ? 230 : 20) : 100 + y / 2;
        if (noise > 0) {
          const auto index = static_cast<uint64_t>((frame * height + y) * width + x) * 3 + static_cast<uint64_t>(c);
          value += static_cast<int>(random_below(5, index, 1, static_cast<uint64_t>(noise))) - noise / 2;
        }
        pixel[c] = static_cast<uint8_t>(std::clamp(value, 0, 255));
      }
    }
  }
  return image;
}

Clip write_clip(const fs::path& path, int frames, const ClipSettings& settings = {}, int noise = 0) {
  ClipWriter writer(path, 96, 80, settings);
  for (int f = 0; f < frames; ++f) writer.add(picture(96, 80, f, noise));
  return writer.finish();
}

TEST_F(ClipTest, HoldsEveryFrameAtItsTimeWithItsColours) {
  const Clip clip = write_clip(folder / "a.mp4", 35, {.title = "two crowds"});
  ASSERT_TRUE(clip.accurate);
  ASSERT_EQ(clip.files.size(), 1U);
  EXPECT_EQ(files(), std::vector<std::string>{"a.mp4"});

  ClipReader reader(folder / "a.mp4");
  EXPECT_EQ(reader.width(), 96);
  EXPECT_EQ(reader.height(), 80);
  const ClipReader::Tags& tags = reader.tags();
  EXPECT_EQ(tags.codec, "h264");
  EXPECT_EQ(tags.pixel_format, "yuv444p");
  EXPECT_EQ(tags.primaries, "bt709");
  EXPECT_EQ(tags.transfer, "bt709");
  EXPECT_EQ(tags.matrix, "bt709");
  EXPECT_EQ(tags.range, "tv");
  EXPECT_EQ(tags.title, "two crowds");
  EXPECT_EQ(tags.fps_numerator, 30 * tags.fps_denominator);

  ClipReader::Frame frame;
  int count = 0;
  double squared = 0;
  double worst = 0;
  while (reader.next(frame)) {
    EXPECT_EQ(frame.pts * frame.time_base_numerator * 30, int64_t{count} * frame.time_base_denominator) << count;
    EXPECT_EQ(frame.key, count % 30 == 0) << count;
    const Image8 raw = picture(96, 80, count);
    double of_frame = 0;
    for (size_t i = 0; i < raw.data.size(); ++i) of_frame += std::pow(raw.data[i] - frame.rgb.data[i], 2);
    squared += of_frame;
    worst = std::max(worst, of_frame);
    ++count;
  }
  EXPECT_EQ(count, 35);
  const double values = 96.0 * 80.0 * 3.0;
  EXPECT_NEAR(clip.files[0].error.psnr_mean, 10 * std::log10(65025 * values * 35 / squared), 1e-9);
  EXPECT_NEAR(clip.files[0].error.psnr_worst_frame, 10 * std::log10(65025 * values / worst), 1e-9);
  EXPECT_GE(clip.files[0].error.psnr_worst_frame, 40);
}

TEST_F(ClipTest, ListsTheRawFramesAndKeepsThemInTheMaster) {
  const Clip clip = write_clip(folder / "a.mp4", 5, {.master = true}, 40);
  ASSERT_EQ(clip.frame_sha256.size(), 5U);
  ASSERT_EQ(clip.files.size(), 2U);
  EXPECT_EQ(clip.files[1].role, "master");
  EXPECT_TRUE(std::isinf(clip.files[1].error.psnr_worst_frame));
  EXPECT_EQ(clip.files[1].error.max_difference, 0);
  ClipReader reader(folder / "a.master.mp4");
  ClipReader::Frame frame;
  for (int f = 0; f < 5; ++f) {
    const Image8 raw = picture(96, 80, f, 40);
    EXPECT_EQ(clip.frame_sha256[static_cast<size_t>(f)],
              sha256_hex({reinterpret_cast<const char*>(raw.data.data()), raw.data.size()}));
    ASSERT_TRUE(reader.next(frame));
    EXPECT_EQ(frame.rgb, raw) << f;
  }
  EXPECT_FALSE(reader.next(frame));
}

TEST_F(ClipTest, AlphaIsLeftOut) {
  ClipWriter writer(folder / "a.mp4", 96, 80);
  const Image8 raw = picture(96, 80, 0);
  Image8 rgba(96, 80, 4);
  for (size_t i = 0; i < raw.pixels(); ++i) {
    std::copy_n(&raw.data[i * 3], 3, &rgba.data[i * 4]);
    rgba.data[i * 4 + 3] = static_cast<uint8_t>(i);
  }
  writer.add(rgba);
  EXPECT_EQ(writer.finish().frame_sha256[0],
            sha256_hex({reinterpret_cast<const char*>(raw.data.data()), raw.data.size()}));
}

TEST_F(ClipTest, SameFramesSameBytes) {
  const Clip a = write_clip(folder / "a.mp4", 40, {.compat = true, .master = true}, 30);
  const Clip b = write_clip(folder / "b.mp4", 40, {.compat = true, .master = true}, 30);
  ASSERT_EQ(a.files.size(), 3U);
  ASSERT_EQ(b.files.size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a.files[i].sha256, b.files[i].sha256) << a.files[i].role;
    const std::string bytes = read_text(a.files[i].path, size_t{1} << 30);
    EXPECT_EQ(a.files[i].sha256, sha256_hex(bytes));
    EXPECT_EQ(a.files[i].bytes, bytes.size());
  }
  EXPECT_NE(a.files[0].sha256, a.files[1].sha256);
}

TEST_F(ClipTest, CompatibilityCopySaysWhatItIs) {
  const Clip clip = write_clip(folder / "a.mp4", 4, {.compat = true});
  EXPECT_EQ(files(), (std::vector<std::string>{"a.mp4", "a.not-for-studies.mp4"}));
  ClipReader reader(folder / "a.not-for-studies.mp4");
  EXPECT_EQ(reader.tags().pixel_format, "yuv420p");
  EXPECT_EQ(reader.tags().matrix, "bt709");
  EXPECT_EQ(reader.tags().title, "NOT FOR STUDIES: 4:2:0 compatibility copy");
  const auto json = nlohmann::json::parse(clip_json(clip).dump());
  EXPECT_EQ(json["files"][0]["for_studies"], true);
  EXPECT_EQ(json["files"][1]["for_studies"], false);
  // Half the chroma costs far more at the outlines of small saturated figures than the codec does.
  EXPECT_LT(clip.files[1].error.psnr_mean, clip.files[0].error.psnr_mean - 6);
}

TEST_F(ClipTest, RateFactorFallsUntilTheWorstFrameIsGoodEnough) {
  const Clip clip = write_clip(folder / "a.mp4", 6, {.crf = 30}, 60);
  ASSERT_TRUE(clip.accurate);
  ASSERT_GE(clip.attempts.size(), 2U);
  EXPECT_EQ(clip.attempts.front().crf, 30);
  EXPECT_LT(clip.attempts.front().psnr_worst_frame, 40);
  for (size_t i = 1; i < clip.attempts.size(); ++i) EXPECT_LT(clip.attempts[i].crf, clip.attempts[i - 1].crf);
  EXPECT_EQ(clip.files[0].crf, clip.attempts.back().crf);
  EXPECT_GE(clip.files[0].error.psnr_worst_frame, 40);
}

TEST_F(ClipTest, WhatCannotBeReachedIsSaidAndLeavesNothing) {
  const Clip clip = write_clip(folder / "a.mp4", 3, {.least_psnr = 90, .compat = true, .master = true});
  EXPECT_FALSE(clip.accurate);
  EXPECT_EQ(clip.attempts.back().crf, 0);
  ASSERT_EQ(clip.files.size(), 1U);
  EXPECT_GT(clip.files[0].error.psnr_worst_frame, 40);
  EXPECT_LT(clip.files[0].error.psnr_worst_frame, 90);
  EXPECT_TRUE(files().empty());
}

TEST_F(ClipTest, AbandonedWriterLeavesNothing) {
  {
    ClipWriter writer(folder / "a.mp4", 96, 80);
    writer.add(picture(96, 80, 0));
    EXPECT_EQ(files().size(), 1U);  // the waiting frames, under a name of their own
  }
  EXPECT_TRUE(files().empty());
}

TEST_F(ClipTest, ManifestTextIsComplete) {
  const Clip clip = write_clip(folder / "a.mp4", 3, {.master = true});
  const auto json = nlohmann::json::parse(clip_json(clip).dump());
  EXPECT_EQ(json["frames"], 3);
  EXPECT_EQ(json["fps"], 30);
  EXPECT_DOUBLE_EQ(json["seconds"].get<double>(), 0.1);
  EXPECT_EQ(json["files"][0]["file"], "a.mp4");
  EXPECT_EQ(json["files"][0]["sha256"], clip.files[0].sha256);
  EXPECT_EQ(json["files"][0]["encoder"]["crf"], clip.attempts.back().crf);
  EXPECT_EQ(json["files"][0]["encoder"]["threads"], 2);
  EXPECT_EQ(json["files"][1]["encoder"]["qp"], 0);
  EXPECT_EQ(json["files"][1]["decoded"]["psnr_mean_db"], "inf");
  EXPECT_EQ(json["frame_sha256"].size(), 3U);
}

TEST_F(ClipTest, RefusesWhatCannotBeAClip) {
  EXPECT_THROW(ClipWriter(folder / "a.webm", 96, 80), Error);
  EXPECT_THROW(ClipWriter(folder / "a.mp4", 95, 80), Error);
  EXPECT_THROW(ClipWriter(folder / "a.mp4", 96, 81), Error);
  EXPECT_THROW(ClipWriter(folder / "a.mp4", 8, 80), Error);
  EXPECT_THROW(ClipWriter(folder / "a.mp4", 96, 80, {.crf = 52}), Error);
  EXPECT_THROW(ClipReader(folder / "none.mp4"), Error);
  write_file(folder / "text.mp4", "no video");
  EXPECT_THROW(ClipReader(folder / "text.mp4"), Error);
}

TEST(CrowdClip, FramesAreWholeTicksApart) {
  scene::Scenario scenario;
  scenario.tick_rate = 60;
  EXPECT_EQ(ticks_per_frame(scenario, 30, "c"), 2U);
  EXPECT_EQ(ticks_per_frame(scenario, 60, "c"), 1U);
  EXPECT_THROW(ticks_per_frame(scenario, 25, "c"), Error);
  EXPECT_THROW(ticks_per_frame(scenario, 120, "c"), Error);
}

}  // namespace
}  // namespace crowdbench::studies
