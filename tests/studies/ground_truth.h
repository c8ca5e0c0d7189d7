// Expected values by other programs, for tests: the two files of the shared ground truth. Tests skip by name without
// them.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/files.h"
#include "test_paths.h"

namespace crowdbench::studies::test {

// Parsed once; nullptr: not there.
inline const nlohmann::json* shared_json(const std::string& name) {
  static std::map<std::string, nlohmann::json> read;
  const std::filesystem::path file = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "ground-truth" / name;
  if (!read.contains(name) && std::filesystem::exists(file)) read[name] = nlohmann::json::parse(read_text(file));
  return read.contains(name) ? &read[name] : nullptr;
}
inline const nlohmann::json* studies_expected() { return shared_json("studies_expected.json"); }
inline const nlohmann::json* statistics_expected() { return shared_json("statistics.json"); }

}  // namespace crowdbench::studies::test
