#include "studies/server/study_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kAdvice = "name a folder that `crowdbench study export` made";

// Members of trials.json, with the place of what is wrong.
class Reader {
 public:
  explicit Reader(std::string where) : where_(std::move(where)) {}
  [[noreturn]] void fail(const std::string& place, const std::string& wrong) const {
    throw Error(where_, fmt::format("{}: {}", place, wrong), kAdvice);
  }
  const json& member(const json& of, const std::string& place, const char* name, json::value_t type) const {
    const auto found = of.is_object() ? of.find(name) : of.end();
    if (!of.is_object() || found == of.end()) fail(place, fmt::format("`{}` is missing", name));
    if (found->type() != type && !(type == json::value_t::number_unsigned && found->is_number_unsigned()))
      fail(place, fmt::format("`{}` is of another type", name));
    return *found;
  }
  std::string text(const json& of, const std::string& place, const char* name) const {
    return member(of, place, name, json::value_t::string).get<std::string>();
  }
  std::string id(const json& of, const std::string& place, const char* name) const {
    std::string value = text(of, place, name);
    if (!is_study_id(value)) fail(place, fmt::format("`{}` '{}' is not an id", name, printable(value, 80)));
    return value;
  }

 private:
  std::string where_;
};

json parse(const fs::path& file) {
  json all = json::parse(read_text(file, size_t{64} << 20), nullptr, false);
  if (all.is_discarded()) throw Error(file.string(), "is not JSON", kAdvice);
  return all;
}

StudyTrial trial_of(const Reader& read, const json& each, const std::string& place, const std::set<std::string>& known,
                    bool adapts) {
  StudyTrial out;
  out.trial = read.id(each, place, "trial");
  const auto stimulus = each.is_object() ? each.find("stimulus") : each.end();
  const bool is_chosen = adapts && each.is_object() && stimulus != each.end() && stimulus->is_null();
  if (!is_chosen) out.stimulus = read.id(each, place, "stimulus");
  out.kind = read.text(each, place, "kind");
  out.block = read.member(each, place, "block", json::value_t::number_unsigned).get<uint32_t>();
  if (!is_chosen && !known.contains(out.stimulus))
    read.fail(place, fmt::format("there is no stimulus '{}'", out.stimulus));
  if (out.kind != "training" && out.kind != "main" && out.kind != "catch")
    read.fail(place, fmt::format("`kind` '{}' is not training, main or catch", printable(out.kind, 40)));
  if (is_chosen && out.kind != "main") read.fail(place, "only main trials are chosen by the answers so far");
  return out;
}

void add_list(StudyFolder& to, const Reader& read, const json& list, const std::string& place,
              const std::set<std::string>& known) {
  const std::string id = read.id(list, place, "id");
  if (to.trials.contains(id)) read.fail(place, fmt::format("there are two lists '{}'", id));
  to.lists.push_back(id);
  std::map<std::string, StudyTrial>& trials = to.trials[id];
  for (const json& each : read.member(list, place, "trials", json::value_t::array)) {
    StudyTrial trial =
        trial_of(read, each, fmt::format("{}.trials[{}]", place, trials.size()), known, !to.choices.empty());
    trial.turn = trials.size();
    const std::string name = trial.trial;
    if (!trials.emplace(name, std::move(trial)).second)
      read.fail(place, fmt::format("there are two trials '{}'", name));
  }
  if (trials.empty()) read.fail(place, "has no trials");
}

// What an adaptive method may show; each has an answer that counts as yes.
void add_choices(StudyFolder& to, const Reader& read, const json& adaptive, const std::set<std::string>& known) {
  const json& yes = read.member(adaptive, "`adaptive`", "yes", json::value_t::object);
  for (const json& choice : read.member(adaptive, "`adaptive`", "choices", json::value_t::array))
    for (const json& stimulus : read.member(choice, "`adaptive`.choices", "stimuli", json::value_t::array)) {
      const std::string id = stimulus.is_string() ? stimulus.get<std::string>() : std::string();
      if (!known.contains(id) || !yes.contains(id))
        read.fail("`adaptive`.choices", fmt::format("'{}' is not a stimulus with a `yes`", printable(id, 80)));
      to.choices.insert(id);
    }
  if (to.choices.empty()) read.fail("`adaptive`.choices", "there is none");
}

std::string type_of(const fs::path& file) {
  static const std::map<std::string, std::string> types = {{".html", "text/html; charset=utf-8"},
                                                           {".css", "text/css; charset=utf-8"},
                                                           {".js", "text/javascript; charset=utf-8"},
                                                           {".json", "application/json"},
                                                           {".txt", "text/plain; charset=utf-8"},
                                                           {".md", "text/plain; charset=utf-8"},
                                                           {".mp4", "video/mp4"},
                                                           {".webm", "video/webm"},
                                                           {".png", "image/png"},
                                                           {".svg", "image/svg+xml"}};
  const auto found = types.find(file.extension().string());
  return found != types.end() ? found->second : "application/octet-stream";
}

std::map<std::string, StudyFile> files_below(const fs::path& page) {
  std::map<std::string, StudyFile> out;
  for (auto at = fs::recursive_directory_iterator(page); at != fs::recursive_directory_iterator(); ++at) {
    if (at->is_symlink() || !at->is_regular_file()) continue;
    const std::string name = "/" + at->path().lexically_relative(page).generic_string();
    out[name] = {at->path(), type_of(at->path())};
  }
  return out;
}

}  // namespace

bool is_study_id(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
  });
}

StudyFolder read_study_folder(const fs::path& out) {
  const fs::path page = out / "page";
  std::error_code failed;
  for (const char* needed : {"trials.json", "index.html"})
    if (!fs::is_regular_file(page / needed, failed))
      throw Error(out.string(), fmt::format("has no page/{}", needed), kAdvice);
  const fs::path file = page / "trials.json";
  const Reader read(file.string());
  const json all = parse(file);
  const json& format = read.member(all, "trials.json", "format", json::value_t::number_unsigned);
  if (format != 1) read.fail("`format`", fmt::format("{} is not 1", format.dump()));
  StudyFolder folder;
  folder.study = read.id(all, "trials.json", "study");
  folder.task = read.text(all, "trials.json", "task");
  for (const json& each : read.member(all, "trials.json", "answers", json::value_t::array))
    folder.answers.push_back(read.id(each, "answers", "value"));
  if (folder.answers.size() < 2) read.fail("`answers`", "fewer than two");
  std::set<std::string> known;
  for (const auto& each : read.member(all, "trials.json", "stimuli", json::value_t::object).items())
    known.insert(each.key());
  if (all.contains("adaptive")) {
    add_choices(folder, read, all.at("adaptive"), known);
    folder.adaptive = all.at("adaptive").dump();
  }
  if (const auto asked = all.find("question"); asked != all.end() && asked->is_string())
    folder.question = asked->get<std::string>();
  if (const auto frames = all.find("frames"); frames != all.end() && frames->is_number_unsigned())
    folder.frames = frames->get<uint64_t>();
  for (const json& list : read.member(all, "trials.json", "lists", json::value_t::array))
    add_list(folder, read, list, fmt::format("lists[{}]", folder.lists.size()), known);
  if (folder.lists.empty()) read.fail("`lists`", "there is none");
  folder.files = files_below(page);
  return folder;
}

}  // namespace crowdbench::studies
