// The outside oracle's files: the small pairs that lie in tests/data, and the whole set where the shared folder is.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files.h"
#include "core/image_io.h"
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

}  // namespace crowdbench::metrics
