// What an export has finished, written beside it so that the next run goes on there. Internal to studies/plan.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"

namespace crowdbench::studies {

struct FileHash {
  std::string name;  // relative to the export's folder
  std::string sha256;
};

// {"key", "files": [{"name", "sha256"}], "facts": ...}
void write_record(const std::filesystem::path& file, const std::string& key, const std::vector<FileHash>& files,
                  const Json& facts);

// The facts of a record of this key whose files are all there and unchanged; nothing otherwise. out: the export's
// folder.
std::optional<Json> read_record(const std::filesystem::path& file, const std::string& key,
                                const std::filesystem::path& out);

// The plan's hash in an export's study.json; empty where there is none.
std::string exported_hash(const std::filesystem::path& out);

}  // namespace crowdbench::studies
