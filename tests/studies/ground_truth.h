// Expected values by other programs: the files of the shared ground truth where they are, else the smaller ones of the
// same form in tests/data.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files.h"
#include "test_paths.h"

namespace crowdbench::studies::test {

// Parsed once.
inline const nlohmann::json& expected_json(const std::string& name) {
  static std::map<std::string, nlohmann::json> read;
  const std::filesystem::path shared = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "ground-truth" / name;
  const std::filesystem::path own = std::filesystem::path(CROWDBENCH_TEST_DATA) / "ground-truth/studies" / name;
  if (!read.contains(name))
    read[name] = nlohmann::json::parse(read_text(std::filesystem::exists(shared) ? shared : own));
  return read[name];
}
inline const nlohmann::json& studies_expected() { return expected_json("studies_expected.json"); }
inline const nlohmann::json& statistics_expected() { return expected_json("statistics.json"); }

}  // namespace crowdbench::studies::test
