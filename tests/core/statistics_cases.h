// The shared ground truth of statistics (statistics.json), for tests; nothing where the shared folder is not there.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/files.h"
#include "test_paths.h"

namespace crowdbench::test {

// Parsed once. nullptr: not there.
inline const nlohmann::json* statistics_cases() {
  static const std::optional<nlohmann::json> all = [] {
    const std::filesystem::path file =
        std::filesystem::path(CROWDBENCH_SHARED_DIR) / "ground-truth" / "statistics.json";
    return std::filesystem::exists(file) ? std::optional(nlohmann::json::parse(read_text(file))) : std::nullopt;
  }();
  return all ? &*all : nullptr;
}

}  // namespace crowdbench::test
