#include "studies/server/answers_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/csv.h"
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

// A text or a number as a field; nothing else.
std::string field(const json& of, const char* name) {
  const auto found = of.find(name);
  if (found == of.end() || found->is_null()) return {};
  if (found->is_string()) return found->get<std::string>();
  return found->is_number() ? found->dump() : std::string();
}

// ---- writing

// Of two items that are ranked, the one that `item_a` names: whichever stands above, a pair is one pair.
const std::string& first_item(const ShownStimulus& s) { return std::min(s.upper, s.lower); }
const std::string& second_item(const ShownStimulus& s) { return std::max(s.upper, s.lower); }

// The page's word for an answer in those of `study analyze`: of ranked items a or b, else as it is.
std::string analysis_word(const std::string& answer, const ShownStimulus& shown, bool ranked) {
  if (answer == "cannot-tell") return "cannot tell";
  if (!ranked || (answer != "upper" && answer != "lower")) return answer;
  return (answer == "upper") == (shown.upper <= shown.lower) ? "a" : "b";
}

template <typename T>
std::string optional_text(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

// One row of the table on its way out.
struct CsvRow {
  const StudyAnswerRow& answer;
  const StudyParticipantRow& who;
  const ShownStimulus& shown;
  const std::string& study;
  bool ranked;
  bool same_different;
  json record;            // `answer.data`; not an object where that is none
  bool has_axis = false;  // there is a column `level`: what it says is not said by the condition
};
struct CsvColumn {
  const char* name;
  std::string (*value)(const CsvRow& row);
  bool always = true;  // otherwise only where some row has a value
};

// How many of the clip's frames were not shown. The browser counts over all showings, those that were asked for again
// included: their share, of one showing.
std::string dropped_frames(const CsvRow& r) {
  const json& record = r.record;
  if (!record.is_object() || !r.answer.frames_dropped) return {};
  const auto total = member<double>(record, "frames_total");
  const auto frames = member<uint32_t>(record, "frames");
  if (!total || *total <= 0 || !frames) return {};
  return fmt::format("{}", std::llround(std::min(1.0, *r.answer.frames_dropped / *total) * *frames));
}
// Items that are ranked are all that varies: no condition stands beside them, whatever an export says of the first.
std::string condition_of(const CsvRow& r) {
  if (r.ranked) return {};
  return r.has_axis ? r.shown.series : r.shown.condition;
}

// How large the page showed a pixel of the clip: the calibration is in CSS pixels, and heights are in the clip's.
std::string shown_size(const CsvRow& r) {
  const json& record = r.record;
  return record.is_object() ? optional_text(member<double>(record, "css_px_per_clip_px")) : std::string();
}

// "simulated" of simulated observers.
std::string observers_of(const CsvRow& r) {
  const json& record = r.record;
  return record.is_object() ? field(record, "observers") : std::string();
}
std::string level_of(const CsvRow& r) {
  // Catch trials are judged and then taken out; where their clips have no level, a number stands there all the same.
  return r.shown.level.empty() && r.answer.kind == "catch" ? "0" : r.shown.level;
}

// Of same or different yes is "said different": with `signal`, hits and false alarms.
std::string expected_word(const CsvRow& r) {
  return r.same_different ? "different" : analysis_word(r.shown.expected, r.shown, r.ranked);
}
std::string signal_of(const CsvRow& r) {
  if (!r.same_different) return {};
  return r.shown.expected == "different" ? "1" : "0";
}

// Of two halves of which one is looked for: whether it stands above.
std::string yes_first_of(const CsvRow& r) {
  if (r.ranked || r.same_different) return {};
  return r.shown.expected == "upper" ? "1" : r.shown.expected == "lower" ? "0" : "";
}

using R = const CsvRow&;
const std::vector<CsvColumn>& csv_columns() {
  static const std::vector<CsvColumn> all = {
      {"observers", observers_of, false},
      {"study", [](R r) { return r.study; }},
      {"participant", [](R r) { return r.who.participant; }},
      {"trial", [](R r) { return r.answer.item; }},
      {"condition", condition_of, false},
      {"clip", [](R r) { return r.shown.clip; }, false},
      {"level", level_of, false},
      {"signal", signal_of, false},
      {"item_a", [](R r) { return r.ranked ? first_item(r.shown) : std::string(); }, false},
      {"item_b", [](R r) { return r.ranked ? second_item(r.shown) : std::string(); }, false},
      {"shown_first", [](R r) { return r.ranked ? r.shown.upper : std::string(); }, false},
      {"answer", [](R r) { return analysis_word(*r.answer.answer, r.shown, r.ranked); }},
      {"expected", expected_word, false},
      {"yes_first", yes_first_of, false},
      {"rt", [](R r) { return optional_text(r.answer.rt); }},
      {"frames_dropped", dropped_frames},
      {"hidden", [](R r) { return std::string(r.answer.hidden.value_or(0) > 0 ? "1" : "0"); }},
      {"catch", [](R r) { return r.answer.kind == "catch" ? r.shown.kind : std::string(); }, false},
      {"list", [](R r) { return r.who.list; }},
      {"block", [](R r) { return optional_text(r.answer.block); }},
      {"stimulus", [](R r) { return r.answer.stimulus.value_or(""); }},
      {"upper", [](R r) { return r.shown.upper; }},
      {"lower", [](R r) { return r.shown.lower; }},
      {"replays", [](R r) { return optional_text(r.answer.replays); }},
      {"restarts", [](R r) { return optional_text(r.answer.restarts); }},
      {"pixels_per_degree", [](R r) { return optional_text(r.who.pixels_per_degree); }},
      {"pixels_per_degree_se", [](R r) { return optional_text(r.who.pixels_per_degree_se); }},
      {"css_px_per_clip_px", shown_size, false},
      {"state", [](R r) { return r.who.state; }}};
  return all;
}

// Whether the trial is of the table: with a right answer, or of items that are ranked; with a level where that is
// asked.
bool is_row(const StudyAnswerRow& row, const ShownStimulus& shown, bool ranked, bool levels) {
  if (levels && row.kind != "catch" && shown.level.empty()) return false;
  return !shown.expected.empty() || (ranked && row.kind != "catch");
}

std::string csv_of(std::vector<CsvRow> rows) {
  // A level that some trials do not have (infinity) is no axis.
  const bool axis = std::all_of(rows.begin(), rows.end(), [](R row) { return !level_of(row).empty(); });
  for (CsvRow& row : rows) row.has_axis = axis;
  std::vector<const CsvColumn*> used;
  for (const CsvColumn& column : csv_columns()) {
    const auto has = [&](const CsvRow& row) { return !column.value(row).empty(); };
    const bool is_level = std::string(column.name) == "level";
    if (column.always || (is_level ? axis : std::any_of(rows.begin(), rows.end(), has))) used.push_back(&column);
  }
  std::string text;
  const auto line = [&](const auto& value_of) {
    for (size_t i = 0; i < used.size(); ++i) text += (i > 0 ? "," : "") + csv_field(value_of(*used[i]));
    text += "\n";
  };
  line([](const CsvColumn& column) { return std::string(column.name); });
  for (const CsvRow& row : rows) line([&](const CsvColumn& column) { return column.value(row); });
  return text;
}

}  // namespace

std::map<std::string, ShownStimulus> read_sides(const fs::path& out, const std::string& study) {
  const fs::path file = out / "sides.json";
  const json all = json::parse(read_text(file, size_t{64} << 20), nullptr, false);
  const auto stimuli = all.is_object() ? all.find("stimuli") : all.end();
  if (!all.is_object() || stimuli == all.end() || !stimuli->is_object())
    throw Error(file.string(), "has no `stimuli`", "name a folder that `crowdbench study export` made");
  if (all.value("format", json(1)) != json(1))
    throw Error(file.string(), "is of another format", "use the crowdbench that exported it, or export it again");
  if (!study.empty() && all.value("study", json(study)) != json(study))
    throw Error(file.string(), "is of another study", "keep what `crowdbench study export` made in one folder");
  std::map<std::string, ShownStimulus> shown;
  for (const auto& each : stimuli->items()) {
    const json& s = each.value();
    if (!s.is_object()) throw Error(file.string(), fmt::format("`{}` is not a stimulus", printable(each.key(), 60)));
    const std::string condition = field(s, "condition_name");
    shown[each.key()] = {condition,         s.contains("series") ? field(s, "series") : condition,
                         field(s, "crowd"), field(s, "level"),
                         field(s, "kind"),  field(s, "upper"),
                         field(s, "lower"), field(s, "expected")};
  }
  return shown;
}

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

std::string answers_csv(const StudyAnswers& answers, const fs::path& out, bool levels) {
  const std::map<std::string, ShownStimulus> shown = read_sides(out, answers.study);
  std::map<int64_t, const StudyParticipantRow*> who;
  for (const StudyParticipantRow& row : answers.participants) who[row.id] = &row;
  const bool ranked =
      std::any_of(shown.begin(), shown.end(), [](const auto& each) { return each.second.kind == "pair"; });
  const bool same_different =
      std::any_of(shown.begin(), shown.end(), [](const auto& each) { return each.second.expected == "same"; });
  std::vector<CsvRow> rows;
  for (const StudyAnswerRow& row : answers.answers) {
    if (row.kind != "main" && row.kind != "catch") continue;
    const auto found = shown.find(row.stimulus.value_or(""));
    if (found == shown.end() || !row.answer)
      throw Error(out.string(),
                  fmt::format("sides.json does not know the stimulus '{}'", printable(row.stimulus.value_or(""), 60)),
                  "name the folder that these answers were given to");
    if (is_row(row, found->second, ranked, levels))
      rows.push_back(CsvRow{row, *who.at(row.participant), found->second, answers.study, ranked, same_different,
                            json::parse(row.data, nullptr, false)});
  }
  if (rows.empty()) throw Error(out.string(), "no trial that a table holds was answered", "wait for answers");
  return csv_of(std::move(rows));
}

}  // namespace crowdbench::studies
