#include "studies/stimuli/clip.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <tuple>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/random.h"
#include "studies/stimuli/crowd_clip.h"
#include "studies/stimuli/proof.h"
#include "studies/stimuli/stack.h"

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

// The payload of the first box of that name, among boxes that follow each other (ISO/IEC 14496-12, 4.2).
std::string box(const std::string& boxes, const std::string& name) {
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<uint8_t>(boxes[at + i]);
    return value;
  };
  for (size_t at = 0; at + 8 <= boxes.size(); at += number(at)) {
    if (number(at) < 8) break;
    if (boxes.compare(at + 4, 4, name) == 0) return boxes.substr(at + 8, number(at) - 8);
  }
  ADD_FAILURE() << "there is no box " << name;
  return {};
}

// Its 32-bit numbers, from the most significant byte on.
std::vector<uint32_t> numbers(const std::string& bytes) {
  std::vector<uint32_t> out(bytes.size() / 4, 0);
  for (size_t i = 0; i < 4 * out.size(); ++i) out[i / 4] = out[i / 4] << 8U | static_cast<uint8_t>(bytes[i]);
  return out;
}

// By the file's own tables, which no decoder of ours reads for us.
TEST_F(ClipTest, TablesSayHowManyFramesAndHowLong) {
  write_clip(folder / "a.mp4", 35);
  const std::string media = box(box(box(read_text(folder / "a.mp4"), "moov"), "trak"), "mdia");
  const std::vector<uint32_t> header = numbers(box(media, "mdhd"));  // version, made, changed, ticks a second, ticks
  ASSERT_GE(header.size(), 5U);
  EXPECT_EQ(uint64_t{header[4]} * 30, uint64_t{header[3]} * 35) << "35 frames at 30 a second";
  const std::string table = box(box(media, "minf"), "stbl");
  const std::vector<uint32_t> sizes = numbers(box(table, "stsz"));  // version, size of all, how many
  ASSERT_GE(sizes.size(), 3U);
  EXPECT_EQ(sizes[2], 35U);
  const std::vector<uint32_t> times = numbers(box(table, "stts"));  // version, runs, frames and ticks of each
  ASSERT_EQ(times.size(), 4U) << "all frames last equally long";
  EXPECT_EQ(times[2], 35U);
  EXPECT_EQ(times[3] * 30, header[3]);
}

// The raw frames of picture(), in this order, against a file: what is said of it, or the error of its worst frame.
std::string said_of(const fs::path& file, const std::vector<int>& frames, int fps = 30, ClipError* error = nullptr) {
  try {
    ClipComparison comparison(file, "clip", fps);
    for (const int frame : frames) comparison.next(picture(96, 80, frame).data);
    const ClipError got = comparison.finish();
    if (error != nullptr) *error = got;
  } catch (const Error& fault) {
    return fault.what();
  }
  return "";
}
void write_frames(const fs::path& path, const std::vector<int>& frames, const ClipSettings& settings) {
  ClipWriter writer(path, 96, 80, settings);
  for (const int frame : frames) writer.add(picture(96, 80, frame));
  writer.finish();
}

TEST_F(ClipTest, AFrameTooManyTooFewOrAtAnotherTimeIsRefused) {
  const std::vector<int> all = {0, 1, 2, 3, 4, 5, 6, 7};
  write_frames(folder / "all.mp4", all, {.webm = true});
  write_frames(folder / "dropped.mp4", {0, 1, 2, 4, 5, 6, 7}, {.webm = true});
  write_frames(folder / "doubled.mp4", {0, 1, 2, 3, 3, 4, 5, 6, 7}, {.webm = true});
  write_frames(folder / "both.mp4", {0, 1, 2, 2, 4, 5, 6, 7}, {.webm = true});
  write_frames(folder / "slow.mp4", all, {.fps = 25, .webm = true});
  for (const char* const end : {".mp4", ".webm"}) {
    const auto file = [&](const char* name) { return folder / (std::string(name) + end); };
    ClipError right;
    EXPECT_EQ(said_of(file("all"), all, 30, &right), "") << end;
    EXPECT_GT(right.psnr_worst_frame, 40) << end;
    EXPECT_NE(said_of(file("dropped"), all).find("ends after 7 frames"), std::string::npos) << end;
    EXPECT_NE(said_of(file("doubled"), all).find("has more frames than were written"), std::string::npos) << end;
    EXPECT_NE(said_of(file("slow"), all).find("frame 1 has a wrong time stamp"), std::string::npos) << end;
    // As many frames, each at its time: the picture tells, and no rate factor would mend it.
    ClipError wrong;
    EXPECT_EQ(said_of(file("both"), all, 30, &wrong), "") << end;
    EXPECT_EQ(wrong.worst_frame, 3U) << end;
    EXPECT_LT(wrong.psnr_worst_frame, 25) << end;
  }
}

TEST_F(ClipTest, ADurationThatIsNotThatOfTheFramesIsRefused) {
  const std::vector<int> all = {0, 1, 2, 3, 4, 5, 6, 7};
  write_frames(folder / "a.mp4", all, {});
  std::string bytes = read_text(folder / "a.mp4");
  const size_t header = bytes.find("mdhd");
  ASSERT_NE(header, std::string::npos);
  const std::vector<uint32_t> fields = numbers(bytes.substr(header + 4, 20));
  // FFmpeg believes the shorter of this and of the sum of its frames, so that a longer one would not be seen here.
  for (const uint64_t frames : {1, 7, 8}) {
    const auto ticks = static_cast<uint32_t>(fields[4] * frames / 8);
    for (size_t i = 0; i < 4; ++i) bytes[header + 20 + i] = static_cast<char>(ticks >> (24 - 8 * i));
    write_file(folder / "b.mp4", std::string_view(bytes));
    const std::string said = said_of(folder / "b.mp4", all);
    if (frames == 8)
      EXPECT_EQ(said, "");
    else
      EXPECT_NE(said.find("8 frames last 0.267 s"), std::string::npos) << frames << ": " << said;
  }
}

// An encoding that is too coarse at the pixels under test alone is refused, however few they are.
TEST_F(ClipTest, ACoarseEncodingOfWhatIsTestedIsMadeAnew) {
  constexpr int kHalf = 36;
  const StackStyle style;
  const auto half = [](int frame, bool test) {
    Image8 image(96, kHalf, 3);
    const Image8 whole = picture(96, kHalf, frame);
    image.data = whole.data;
    for (int x = 40; test && x < 44; ++x) image.at(x, 20)[1] ^= 128U;
    return image;
  };
  const auto write = [&](double share, double least_psnr) {
    ProofRecorder recorder(96, kHalf, style, share);
    ClipSettings settings{.crf = 44, .least_psnr = least_psnr};
    if (share < 1e9) settings.check = recorder.check();
    ClipWriter writer(folder / "a.mp4", 96, stack_size(96, kHalf, style).height, settings);
    for (int f = 0; f < 6; ++f) {
      recorder.expect(half(f, true), half(f, false), true, true);
      writer.add(stack_vertically(half(f, true), half(f, false), style));
    }
    const Clip clip = writer.finish();
    return std::make_tuple(clip, share < 1e9 ? recorder.proof() : ClipProof(), recorder.refusal());
  };
  const auto [coarse, unseen, nothing] = write(1e9, 0);
  EXPECT_EQ(coarse.attempts.size(), 1U) << "nobody asked for more";
  EXPECT_TRUE(coarse.accurate);
  const auto [fine, proof, why] = write(0.25, 0);
  ASSERT_TRUE(fine.accurate) << why;
  EXPECT_GT(fine.attempts.size(), 1U);
  EXPECT_LT(fine.attempts.back().crf, 44);
  EXPECT_EQ(proof.artefact_pixels, 6U * 2 * 4) << "of both halves, since the other one is the reference";
  EXPECT_LE(proof.decoded_rms, 0.25 * proof.artefact_rms);
  const auto [never, last, refusal] = write(1e-4, 0);
  EXPECT_FALSE(never.accurate);
  EXPECT_EQ(never.attempts.back().crf, 0);
  EXPECT_NE(refusal.find("pixels under test"), std::string::npos) << refusal;
}

// libvpx's own decoder, where FFmpeg's reads the clips elsewhere.
TEST_F(ClipTest, AnotherDecoderSeesTheSameFrames) {
  if (std::system("vpxdec --help >/dev/null 2>&1") != 0) GTEST_SKIP() << "vpxdec (vpx-tools) is not installed";
  write_clip(folder / "a.mp4", 7, {.webm = true});
  const std::string decode = "cd '" + folder.string() + "' && vpxdec --rawvideo -o a.yuv a.webm 2>/dev/null";
  ASSERT_EQ(std::system(decode.c_str()), 0);
  const std::string planes = read_text(folder / "a.yuv");
  constexpr size_t kPlane = 96 * 80;
  ASSERT_EQ(planes.size(), 7 * 3 * kPlane) << "seven frames, no colour sample left out";
  ClipReader reader(folder / "a.webm");
  ClipReader::Frame frame;
  int worst = 0;
  for (size_t f = 0; f < 7; ++f) {
    ASSERT_TRUE(reader.next(frame));
    for (size_t i = 0; i < kPlane; ++i) {
      const auto sample = [&](size_t plane) { return static_cast<uint8_t>(planes[(3 * f + plane) * kPlane + i]); };
      // BT.709's luma weights, limited range.
      const double y = (sample(0) - 16) / 219.0;
      const double b = (sample(1) - 128) / 224.0 * 1.8556;
      const double r = (sample(2) - 128) / 224.0 * 1.5748;
      const double rgb[] = {y + r, y - (0.2126 * r + 0.0722 * b) / 0.7152, y + b};
      for (size_t c = 0; c < 3; ++c) {
        const int expected = static_cast<int>(std::lround(255 * std::clamp(rgb[c], 0.0, 1.0)));
        worst = std::max(worst, std::abs(expected - frame.rgb.data[3 * i + c]));
      }
    }
  }
  EXPECT_FALSE(reader.next(frame));
  EXPECT_LE(worst, 1) << "code values: the two conversions round apart";
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

// Leaves bytes in the memory that is handed out next, as a program that has run for a while does.
void soil_memory(int value) {
  std::vector<std::string> blocks;
  for (size_t size = 4096; size <= (size_t{64} << 10); size *= 2)
    for (int i = 0; i < 64; ++i) blocks.emplace_back(size, static_cast<char>(value));
}

TEST_F(ClipTest, SameFramesSameBytes) {
  soil_memory(0x55);
  const Clip a = write_clip(folder / "a.mp4", 40, {.compat = true, .master = true}, 30);
  soil_memory(0xaa);
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
  EXPECT_NE(json["files"][0]["browsers"].get<std::string>().find("refused by Safari"), std::string::npos);
  EXPECT_TRUE(json["files"][1]["browsers"].is_null());
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
