#include "studies/server/answers_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "store/store.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// ---- reading

template <typename T>
std::optional<T> member(const json& of, const char* name) {
  const auto found = of.find(name);
  if (found == of.end() || found->is_null()) return std::nullopt;
  try {
    return found->get<T>();
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

void add_result_file(StudyAnswers& to, const fs::path& file) {
  const StoreContents all = read_store(file, false, false);
  std::set<int64_t> known;
  const auto offset = static_cast<int64_t>(to.participants.size()) << 32;  // ids of several files stay apart
  for (StudyParticipantRow row : all.participants) {
    if (row.study != to.study) continue;
    known.insert(row.id);
    row.id += offset;
    to.participants.push_back(std::move(row));
  }
  for (StudyAnswerRow row : all.answers) {
    if (!known.contains(row.participant)) continue;
    row.participant += offset;
    to.answers.push_back(std::move(row));
  }
}

StudyAnswerRow answer_row(const json& record, const std::string& where) {
  StudyAnswerRow row;
  row.item = member<std::string>(record, "item").value_or("");
  row.kind = member<std::string>(record, "kind").value_or("");
  if (row.item.empty() || row.kind.empty())
    throw Error(where, "a record has no `item` or no `kind`", "name a file that the study's page saved");
  row.stimulus = member<std::string>(record, "stimulus");
  row.block = member<uint32_t>(record, "block");
  row.answer = member<std::string>(record, "answer");
  row.rt = member<double>(record, "rt_ms");
  row.replays = member<uint32_t>(record, "replays");
  row.frames_dropped = member<uint32_t>(record, "frames_dropped");
  row.hidden = member<uint32_t>(record, "hidden");
  row.restarts = member<uint32_t>(record, "restarts");
  row.data = record.dump();
  return row;
}

void add_saved_file(StudyAnswers& to, const fs::path& file) {
  const std::string where = file.string();
  const json all = json::parse(read_text(file, size_t{256} << 20), nullptr, false);
  if (!all.is_array() || all.empty())
    throw Error(where, "neither a result file nor what the study's page saved",
                "name a .sqlite or a .json file of a study");
  StudyParticipantRow who;
  who.id = (static_cast<int64_t>(to.participants.size()) << 32) + 1;
  who.state = "finished";
  for (const json& record : all) {
    if (!record.is_object())
      throw Error(where, "holds what is not a record", "name a file that the study's page saved");
    if (member<std::string>(record, "study") != to.study)
      throw Error(where, "is of another study than the folder", "name the folder that it was answered with");
    const std::string participant = member<std::string>(record, "participant").value_or("");
    if (participant.empty() || (!who.participant.empty() && who.participant != participant))
      throw Error(where, "is of nobody, or of several participants", "name a file that the study's page saved");
    who.participant = participant;
    who.list = member<std::string>(record, "list").value_or(who.list);
    StudyAnswerRow row = answer_row(record, where);
    row.participant = who.id;
    if (row.item == "calibration") {
      who.pixels_per_degree = member<double>(record, "pixels_per_degree");
      who.pixels_per_degree_se = member<double>(record, "pixels_per_degree_se");
    }
    to.answers.push_back(std::move(row));
  }
  who.study = to.study;
  for (const StudyParticipantRow& other : to.participants)
    if (other.participant == who.participant)
      throw Error(where, "is of a participant who is in another file too", "leave one of the two out");
  to.participants.push_back(std::move(who));
}

// ---- what was shown

// A stimulus as sides.json says it; empty texts: does not apply.
struct Shown {
  std::string condition, clip, level, kind, item_upper, item_lower, expected;
};

// A text or a number as a field; nothing else.
std::string field(const json& of, const char* name) {
  const auto found = of.find(name);
  if (found == of.end() || found->is_null()) return {};
  if (found->is_string()) return found->get<std::string>();
  return found->is_number() ? found->dump() : std::string();
}

std::map<std::string, Shown> read_sides(const fs::path& out) {
  const fs::path file = out / "sides.json";
  const json all = json::parse(read_text(file, size_t{64} << 20), nullptr, false);
  const auto stimuli = all.is_object() ? all.find("stimuli") : all.end();
  if (!all.is_object() || stimuli == all.end() || !stimuli->is_object())
    throw Error(file.string(), "has no `stimuli`", "name a folder that `crowdbench study export` made");
  std::map<std::string, Shown> shown;
  for (const auto& each : stimuli->items()) {
    const json& s = each.value();
    if (!s.is_object()) throw Error(file.string(), fmt::format("`{}` is not a stimulus", printable(each.key(), 60)));
    shown[each.key()] = {field(s, "condition"),  field(s, "crowd"),      field(s, "level"),   field(s, "kind"),
                         field(s, "item_upper"), field(s, "item_lower"), field(s, "expected")};
  }
  return shown;
}

// ---- writing

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n\t ") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// The page's word for an answer in those of `study analyze`.
std::string analysis_word(const std::string& answer) {
  static const std::map<std::string, std::string> words = {
      {"upper", "first"}, {"lower", "second"}, {"cannot-tell", "cannot tell"}};
  const auto found = words.find(answer);
  return found != words.end() ? found->second : answer;
}

template <typename T>
std::string optional_text(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

struct CsvColumn {
  const char* name;
  std::string (*value)(const StudyAnswerRow& answer, const StudyParticipantRow& who, const Shown& shown);
  bool needed = false;  // also where it is empty in every row
};

bool compares_items(const Shown& s) { return !s.item_upper.empty() && s.item_upper != s.item_lower; }
// Items have one order whichever stands above, so that a pair of conditions is one pair.
const std::string& first_item(const Shown& s) { return std::min(s.item_upper, s.item_lower); }
const std::string& second_item(const Shown& s) { return std::max(s.item_upper, s.item_lower); }

using Answered = const StudyAnswerRow&;
using Who = const StudyParticipantRow&;
using What = const Shown&;
const std::vector<CsvColumn>& csv_columns() {
  static const std::vector<CsvColumn> all = {
      {"participant", [](Answered, Who w, What) { return w.participant; }, true},
      {"trial", [](Answered a, Who, What) { return a.item; }, true},
      {"condition", [](Answered, Who, What s) { return s.condition; }},
      {"clip", [](Answered, Who, What s) { return s.clip; }},
      {"level", [](Answered, Who, What s) { return s.level; }},
      {"item_a", [](Answered, Who, What s) { return compares_items(s) ? first_item(s) : std::string(); }},
      {"item_b", [](Answered, Who, What s) { return compares_items(s) ? second_item(s) : std::string(); }},
      {"shown_first", [](Answered, Who, What s) { return compares_items(s) ? s.item_upper : std::string(); }},
      {"answer", [](Answered a, Who, What) { return analysis_word(*a.answer); }, true},
      {"expected", [](Answered, Who, What s) { return analysis_word(s.expected); }},
      {"rt", [](Answered a, Who, What) { return optional_text(a.rt); }, true},
      {"catch", [](Answered a, Who, What s) { return a.kind == "catch" ? s.kind : std::string(); }},
      {"list", [](Answered, Who w, What) { return w.list; }, true},
      {"block", [](Answered a, Who, What) { return optional_text(a.block); }, true},
      {"stimulus", [](Answered a, Who, What) { return a.stimulus.value_or(""); }, true},
      {"replays", [](Answered a, Who, What) { return optional_text(a.replays); }, true},
      {"frames_dropped", [](Answered a, Who, What) { return optional_text(a.frames_dropped); }, true},
      {"hidden", [](Answered a, Who, What) { return optional_text(a.hidden); }, true},
      {"restarts", [](Answered a, Who, What) { return optional_text(a.restarts); }, true},
      {"pixels_per_degree", [](Answered, Who w, What) { return optional_text(w.pixels_per_degree); }, true},
      {"pixels_per_degree_se", [](Answered, Who w, What) { return optional_text(w.pixels_per_degree_se); }, true}};
  return all;
}

}  // namespace

StudyAnswers read_study_answers(const std::vector<fs::path>& files, const std::string& study) {
  StudyAnswers all{.study = study, .participants = {}, .answers = {}};
  for (const fs::path& file : files) {
    if (file.extension() == ".json")
      add_saved_file(all, file);
    else
      add_result_file(all, file);
  }
  if (all.answers.empty())
    throw Error(files.front().string(), "has no answers of this study", "name the file of `study serve --answers`");
  return all;
}

std::string json_lines(const StudyAnswers& answers) {
  std::map<int64_t, const StudyParticipantRow*> who;
  for (const StudyParticipantRow& row : answers.participants) who[row.id] = &row;
  std::string text;
  for (const StudyAnswerRow& row : answers.answers) {
    json record = json::parse(row.data);
    record["study"] = answers.study;
    record["participant"] = who.at(row.participant)->participant;
    record["list"] = who.at(row.participant)->list;
    if (!row.received.empty()) record["received"] = row.received;
    text += record.dump() + "\n";
  }
  return text;
}

std::string jspsych_json(const StudyAnswers& answers) {
  std::string lines = json_lines(answers);
  lines.pop_back();
  std::string text = "[\n";
  for (const char c : lines) text += c == '\n' ? std::string(",\n") : std::string(1, c);
  return text + "\n]\n";
}

std::string answers_csv(const StudyAnswers& answers, const fs::path& out) {
  const std::map<std::string, Shown> shown = read_sides(out);
  std::map<int64_t, const StudyParticipantRow*> who;
  for (const StudyParticipantRow& row : answers.participants) who[row.id] = &row;
  std::vector<std::vector<std::string>> rows;
  std::set<size_t> used;
  const std::vector<CsvColumn>& columns = csv_columns();
  for (const StudyAnswerRow& row : answers.answers) {
    if (row.kind != "main" && row.kind != "catch") continue;
    const auto found = shown.find(row.stimulus.value_or(""));
    if (found == shown.end() || !row.answer)
      throw Error(out.string(), fmt::format("sides.json does not know the stimulus '{}'", row.stimulus.value_or("")),
                  "name the folder that these answers were given to");
    std::vector<std::string>& fields = rows.emplace_back();
    for (size_t i = 0; i < columns.size(); ++i) {
      fields.push_back(columns[i].value(row, *who.at(row.participant), found->second));
      if (columns[i].needed || !fields.back().empty()) used.insert(i);
    }
  }
  if (rows.empty()) throw Error(out.string(), "no trial but training was answered", "wait for answers");
  std::string text;
  const auto line = [&](const auto& value_of) {
    std::string separator;
    for (const size_t i : used) {
      text += separator + csv_field(value_of(i));
      separator = ",";
    }
    text += "\n";
  };
  line([&](size_t i) { return std::string(columns[i].name); });
  for (const auto& fields : rows) line([&](size_t i) { return fields[i]; });
  return text;
}

}  // namespace crowdbench::studies
