// The outside oracle's files: the small pairs that lie in tests/data, and the whole set where the shared folder is.
#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files.h"
#include "core/image_io.h"
#include "metrics/difference.h"
#include "test_paths.h"

namespace crowdbench::metrics {

inline const std::filesystem::path kOwn = std::filesystem::path(CROWDBENCH_TEST_DATA) / "ground-truth";
inline const std::filesystem::path kShared = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "ground-truth";

inline Image8 picture(const std::filesystem::path& path) {
  return decode_png(read_file(path), path.filename().string());
}
inline ImageF float_picture(const std::filesystem::path& path) { return std::get<ImageF>(read_image(path)); }

// expected.json, which has a bare Infinity, which is not JSON.
inline nlohmann::json expected_of(const std::filesystem::path& folder) {
  std::string text = read_text(folder / "expected.json");
  const std::string bare = " Infinity";
  for (size_t at = 0; (at = text.find(bare, at)) != std::string::npos;) text.replace(at, bare.size(), " null");
  return nlohmann::json::parse(text);
}

struct PicturePair {
  Image8 reference, test;
};
// The two of a pair of expected.json; "p09_alpha@over_white" are those of p09_alpha in front of white.
inline PicturePair pictures_of(const std::filesystem::path& folder, const nlohmann::json& expected,
                               const std::string& pair) {
  const std::map<std::string, std::array<uint8_t, 3>> colours = {
      {"black", {0, 0, 0}}, {"white", {255, 255, 255}}, {"gray50", {128, 128, 128}}};
  const size_t at = pair.find("@over_");
  const nlohmann::json& files = expected["pairs"][pair.substr(0, at)];
  PicturePair out{picture(folder / files["ref"].get<std::string>()),
                  picture(folder / files["test"].get<std::string>())};
  if (at == std::string::npos) return out;
  const auto& colour = colours.at(pair.substr(at + 6));
  return {over(out.reference, colour), over(out.test, colour)};
}

}  // namespace crowdbench::metrics
