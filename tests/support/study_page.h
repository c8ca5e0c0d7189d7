// A tiny exported study for the tests of the page and its server: drawn stripes in place of crowds, in the folder's
// real form (studies/plan/README.md).
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files.h"
#include "core/hash.h"
#include "studies/page/page.h"
#include "studies/stimuli/clip.h"

namespace crowdbench::support {

inline const std::string kStudyHash(64, 'a');

// Two clips of half a second: grey with a square that moves, and a black bar; what stands below it differs.
inline nlohmann::json write_study_clip(const std::filesystem::path& file, uint8_t shade) {
  constexpr int kWidth = 96;
  constexpr int kHeight = 136;
  constexpr int kFrames = 15;
  studies::ClipWriter writer(file, kWidth, kHeight);
  for (int frame = 0; frame < kFrames; ++frame) {
    Image8 image(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const bool bar = y >= 64 && y < 72;
        const bool square = (y % 72) >= 24 && (y % 72) < 40 && x >= 4 * frame && x < 4 * frame + 16;
        for (int c = 0; c < 3; ++c)
          image.data[static_cast<size_t>((y * kWidth + x) * 3 + c)] = bar      ? 0
                                                                      : square ? (y < 64 ? uint8_t{200} : shade)
                                                                               : uint8_t{128};
      }
    writer.add(image);
  }
  writer.finish();
  const auto bytes = read_file(file);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return {{"files", nlohmann::json::array({{{"src", "clips/" + file.filename().string()},
                                            {"type", "video/mp4; codecs=\"avc1.F4000A\""},
                                            {"sha256", sha256_hex(text)}}})},
          {"check_frame",
           {{"index", 7},
            {"tolerance", 16},
            {"colours",
             {{{"x", 8}, {"y", 8}, {"rgb", {128, 128, 128}}},
              {{"x", 48}, {"y", 68}, {"rgb", {0, 0, 0}}},
              {{"x", 36}, {"y", 32}, {"rgb", {200, 200, 200}}}}}}}};
}

inline nlohmann::json study_list(const std::string& id) {
  const auto trial = [](const char* name, const char* stimulus, int block, const char* kind) {
    return nlohmann::json{{"trial", name}, {"stimulus", stimulus}, {"block", block}, {"kind", kind}};
  };
  return {{"id", id},
          {"trials",
           {trial("t001", "s001", 0, "training"), trial("t002", "s002", 1, "main"), trial("t003", "s001", 1, "main"),
            trial("t004", "s002", 2, "catch"), trial("t005", "s001", 2, "main")}}};
}

// trials.json and sides.json alone, for what looks at no page: `out` must exist.
inline void write_study_folder(const std::filesystem::path& out, const nlohmann::json& stimuli) {
  std::filesystem::create_directories(out / "page");
  const nlohmann::json trials = {{"format", 1},
                                 {"study", kStudyHash},
                                 {"title", "Two crowds"},
                                 {"question", "Which one looks better?"},
                                 {"task", "preference"},
                                 {"answers",
                                  {{{"value", "upper"}, {"label", "Upper"}, {"key", "u"}},
                                   {{"value", "lower"}, {"label", "Lower"}, {"key", "l"}},
                                   {{"value", "cannot-tell"}, {"label", "Cannot tell"}, {"key", "c"}}}},
                                 {"replays", 1},
                                 {"fps", 30},
                                 {"frames", 15},
                                 {"width", 96},
                                 {"height", 136},
                                 {"display", {{"bar_top", 64}, {"bar_height", 8}}},
                                 {"calibration", true},
                                 {"consent", "# Two crowds\n\nYou may **withdraw**."},
                                 {"instructions", "# What to do\n\nWatch both."},
                                 {"debrief", "# Thank you\n\nOne was drawn more cheaply."},
                                 {"demographics", nlohmann::json::array({"Your age"})},
                                 {"stimuli", stimuli},
                                 {"lists", {study_list("1"), study_list("2"), study_list("3")}},
                                 {"breaks", nlohmann::json::array({3})}};
  write_file(out / "page" / "trials.json", std::string_view(trials.dump(1)));
  const nlohmann::json sides = {{"format", 1},
                                {"study", kStudyHash},
                                {"stimuli",
                                 {{"s001",
                                   {{"condition", "c01"},
                                    {"condition_name", "switch_m=10"},
                                    {"level", 10},
                                    {"crowd", 0},
                                    {"kind", "test"},
                                    {"upper", "mesh"},
                                    {"lower", "flat, near"},
                                    {"expected", "upper"}}},
                                  {"s002",
                                   {{"condition", "c02"},
                                    {"condition_name", "switch_m=20"},
                                    {"level", 20},
                                    {"crowd", 1},
                                    {"kind", "broken"},
                                    {"upper", "flat, near"},
                                    {"lower", "mesh"},
                                    {"expected", "lower"}}}}}};
  write_file(out / "sides.json", std::string_view(sides.dump(1)));
}

// Main trials of what was written are chosen by the answers so far. rule: `adaptive` of trials.json; by default two
// levels, one a stimulus.
inline nlohmann::json two_level_rule() {
  return {{"method", "quest-plus"},
          {"curve", "logistic"},
          {"falling", false},
          {"threshold", {8, 11, 14, 17, 20, 23}},
          {"slope", {0.5, 2}},
          {"guess", {0.5}},
          {"lapse", {0.02}},
          {"choices", {{{"level", 10}, {"stimuli", {"s001"}}}, {{"level", 20}, {"stimuli", {"s002"}}}}},
          {"alike", nlohmann::json::array()},
          {"yes", {{"s001", "upper"}, {"s002", "lower"}}}};
}
inline void let_the_page_choose(const std::filesystem::path& out, const nlohmann::json& rule = two_level_rule()) {
  nlohmann::json trials = nlohmann::json::parse(read_text(out / "page" / "trials.json"));
  trials["adaptive"] = rule;
  for (nlohmann::json& list : trials["lists"])
    for (nlohmann::json& trial : list["trials"])
      if (trial["kind"] == "main") trial["stimulus"] = nullptr;
  write_file(out / "page" / "trials.json", std::string_view(trials.dump(1)));
}

// With clips and the page.
inline void write_study(const std::filesystem::path& out) {
  std::filesystem::create_directories(out / "page" / "clips");
  write_study_folder(out, {{"s001", write_study_clip(out / "page" / "clips" / "s001.mp4", 90)},
                           {"s002", write_study_clip(out / "page" / "clips" / "s002.mp4", 170)}});
  studies::write_page(out / "page");
}

}  // namespace crowdbench::support
