#include "studies/plan/frozen.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/version.h"

namespace crowdbench::studies {
namespace {

namespace fs = std::filesystem;
using Ordered = nlohmann::ordered_json;

constexpr char kFormat[] = "crowdbench-study-frozen-1";
constexpr size_t kMostBytes = size_t{16} << 20;

bool is_hash(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

[[noreturn]] void refuse(const fs::path& file, const std::string& wrong) {
  throw Error(file.string(), wrong, "it is written by `study freeze` alone; get the original back from your records");
}

std::string text_member(const Ordered& json, const char* key, const fs::path& file) {
  if (!json.contains(key) || !json[key].is_string()) refuse(file, fmt::format("has no text `{}`", key));
  return json[key].get<std::string>();
}

FrozenPlan parse(const fs::path& file) {
  const Ordered json = Ordered::parse(read_text(file, kMostBytes), nullptr, false);
  if (!json.is_object()) refuse(file, "is not a JSON object");
  if (text_member(json, "format", file) != kFormat) refuse(file, "is of another format");
  FrozenPlan out;
  out.file = file;
  out.hash = text_member(json, "hash", file);
  for (const char* const key : {"analysis", "meaning"})
    if (!json.contains(key) || !json[key].is_object()) refuse(file, fmt::format("has no object `{}`", key));
  out.analysis = json["analysis"].dump();
  out.meaning = json["meaning"].dump();
  if (!is_hash(out.hash) || sha256_hex(out.meaning) != out.hash) refuse(file, "its hash is not that of its meaning");
  if (!json["meaning"].contains("analysis") || json["meaning"]["analysis"].dump() != out.analysis)
    refuse(file, "its analysis is not the one that was frozen");
  if (!json.contains("deviations") || !json["deviations"].is_array()) refuse(file, "has no list `deviations`");
  for (const Ordered& entry : json["deviations"]) {
    if (!entry.is_object()) refuse(file, "a deviation is not an object");
    out.deviations.push_back({text_member(entry, "hash", file), text_member(entry, "reason", file)});
    if (!is_hash(out.deviations.back().hash)) refuse(file, "a deviation has no hash");
  }
  return out;
}

void write(const FrozenPlan& frozen, const fs::path& plan_file) {
  Json deviations = Json::array();
  for (const Deviation& deviation : frozen.deviations)
    deviations.push_back({{"hash", deviation.hash}, {"reason", deviation.reason}});
  Json json;
  json["format"] = kFormat;
  json["plan"] = plan_file.filename().string();
  json["hash"] = frozen.hash;
  json["crowdbench"] = fmt::format("{} ({})", version(), git_revision());
  json["deviations"] = std::move(deviations);
  json["analysis"] = Json::parse(frozen.analysis);
  json["meaning"] = Json::parse(frozen.meaning);
  write_file(frozen.file, json.dump(2) + "\n");
}

}  // namespace

fs::path frozen_file(const fs::path& plan_file) { return fs::path(plan_file).replace_extension(".frozen.json"); }

std::optional<FrozenPlan> read_frozen(const fs::path& plan_file) {
  const fs::path file = frozen_file(plan_file);
  std::error_code failed;
  if (!fs::exists(file, failed)) return std::nullopt;
  return parse(file);
}

FrozenPlan freeze(const fs::path& plan_file, const StudyPlan& plan, const std::string& deviation, bool anew) {
  const std::string hash = plan.hash();
  std::optional<FrozenPlan> frozen = anew ? std::nullopt : read_frozen(plan_file);
  if (frozen && frozen->current_hash() == hash) return *frozen;
  if (frozen && deviation.empty())
    throw Error(plan_file.string(), "was changed since it was frozen",
                "record why with --deviation 'WHY', or, where no answer was collected yet, freeze it anew with --anew");
  if (frozen) {
    frozen->deviations.push_back({hash, deviation});
  } else {
    if (!deviation.empty())
      throw Error("--deviation", "there is nothing yet that the plan deviates from", "freeze it without");
    frozen =
        FrozenPlan{frozen_file(plan_file), hash, analysis_plan_json(plan.analysis).dump(), plan.meaning().dump(), {}};
  }
  write(*frozen, plan_file);
  return *frozen;
}

FrozenPlan require_frozen(const fs::path& plan_file, const StudyPlan& plan) {
  const std::optional<FrozenPlan> frozen = read_frozen(plan_file);
  if (!frozen)
    throw Error(plan_file.string(), "is not frozen",
                fmt::format("fix it before the first answer: crowdbench study freeze {}", plan_file.string()));
  if (frozen->current_hash() != plan.hash())
    throw Error(plan_file.string(), "was changed since it was frozen",
                "undo the change, record why with `study freeze --deviation 'WHY'`, or, where no answer was collected "
                "yet, `study freeze --anew`");
  return *frozen;
}

}  // namespace crowdbench::studies
