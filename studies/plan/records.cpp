#include "studies/plan/records.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/files.h"
#include "studies/stimuli/clip.h"

namespace crowdbench::studies {
namespace {

namespace fs = std::filesystem;

nlohmann::ordered_json read_object(const fs::path& file) {
  std::error_code failed;
  if (!fs::is_regular_file(file, failed)) return {};
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(read_text(file, size_t{256} << 20), nullptr, false);
  return json.is_object() ? json : nlohmann::ordered_json();
}

std::string text_of(const nlohmann::ordered_json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

}  // namespace

void write_record(const fs::path& file, const std::string& key, const std::vector<FileHash>& files, const Json& facts) {
  Json list = Json::array();
  for (const FileHash& each : files) list.push_back({{"name", each.name}, {"sha256", each.sha256}});
  Json record;
  record["key"] = key;
  record["files"] = std::move(list);
  record["facts"] = facts;
  write_file(file, record.dump(2) + "\n");
}

std::optional<Json> read_record(const fs::path& file, const std::string& key, const fs::path& out) {
  const nlohmann::ordered_json record = read_object(file);
  if (text_of(record, "key") != key || !record.contains("files") || !record["files"].is_array() ||
      !record.contains("facts"))
    return std::nullopt;
  for (const auto& each : record["files"]) {
    const fs::path name = out / text_of(each, "name");
    std::error_code failed;
    if (!fs::is_regular_file(name, failed) || file_sha256(name) != text_of(each, "sha256")) return std::nullopt;
  }
  return Json::parse(record["facts"].dump());
}

std::string exported_hash(const fs::path& out) { return text_of(read_object(out / "study.json"), "hash"); }

}  // namespace crowdbench::studies
