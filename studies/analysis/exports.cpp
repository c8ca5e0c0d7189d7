#include "studies/analysis/exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/counted.h"
#include "core/csv.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/analysis/r_script.h"
#include "studies/analysis/text_numbers.h"

namespace crowdbench::studies {
namespace {

std::string name_of(const std::vector<std::string>& names, const std::optional<uint32_t>& index) {
  return index ? names[*index] : "";
}

std::string safe_field(const std::string& text) { return csv_field(text::spreadsheet_safe(text)); }

struct DataColumn {
  const char* name;
  const char* meaning;
  std::string (*text)(const Answers& answers, const Answer& row, TieRule ties);
};

const std::vector<DataColumn>& data_columns() {
  using A = const Answers&;
  using R = const Answer&;
  static const std::vector<DataColumn> all = {
      {"task", "what was asked", [](A a, R r, TieRule) { return name_of(a.tasks, r.task); }},
      {"observers", "\"simulated\": of simulated observers, and not of people",
       [](A, R r, TieRule) { return std::string(r.simulated ? "simulated" : ""); }},
      {"participant", "who answered", [](A a, R r, TieRule) { return name_of(a.participants, r.participant); }},
      {"trial", "which of the participant's trials", [](A, R r, TieRule) { return r.trial; }},
      {"condition", "what is compared", [](A a, R r, TieRule) { return name_of(a.conditions, r.condition); }},
      {"clip", "what was shown", [](A a, R r, TieRule) { return name_of(a.clips, r.clip); }},
      {"level", "the axis of the psychometric function",
       [](A, R r, TieRule) { return r.level ? fmt::format("{}", *r.level) : ""; }},
      {"signal", "1: there was something to see",
       [](A, R r, TieRule) { return std::string(r.signal ? (*r.signal ? "1" : "0") : ""); }},
      {"item_a", "the first of the two things compared", [](A a, R r, TieRule) { return name_of(a.items, r.item_a); }},
      {"item_b", "the second", [](A a, R r, TieRule) { return name_of(a.items, r.item_b); }},
      {"shown_first", "the item that stood first",
       [](A a, R r, TieRule) {
         return r.shown_first_is_a ? name_of(a.items, *r.shown_first_is_a ? r.item_a : r.item_b) : "";
       }},
      {"yes_first", "1: what counts as yes stood first",
       [](A, R r, TieRule) { return std::string(r.yes_first ? (*r.yes_first ? "1" : "0") : ""); }},
      {"yes", "answers yes (right, seen, item_a)", [](A, R r, TieRule) { return fmt::format("{}", r.yes); }},
      {"ties", "answers \"cannot tell\"", [](A, R r, TieRule) { return fmt::format("{}", r.ties); }},
      {"no", "answers no", [](A, R r, TieRule) { return fmt::format("{}", r.no); }},
      {"chosen", "answers that count as yes by the rule for \"cannot tell\", which may halve them",
       [](A, R r, TieRule t) {
         const Counted c = counted(r.yes, r.ties, r.no, t);
         return fmt::format("{}", static_cast<double>(c.yes) + static_cast<double>(c.halves) / 2);
       }},
      {"decided", "answers that count",
       [](A, R r, TieRule t) { return fmt::format("{}", counted(r.yes, r.ties, r.no, t).of); }},
      {"pixels_per_degree", "CSS pixels of the participant's screen by degree of visual angle",
       [](A, R r, TieRule) { return r.pixels_per_degree ? fmt::format("{}", *r.pixels_per_degree) : ""; }},
      {"pixels_per_degree_se", "its standard error",
       [](A, R r, TieRule) { return r.pixels_per_degree_se ? fmt::format("{}", *r.pixels_per_degree_se) : ""; }},
      {"css_px_per_clip_px", "CSS pixels by pixel of the clip",
       [](A, R r, TieRule) { return r.pixels_per_degree ? fmt::format("{}", r.css_px_per_clip_px) : ""; }},
      {"rt", "response time in milliseconds",
       [](A, R r, TieRule) { return r.rt_ms ? fmt::format("{}", *r.rt_ms) : ""; }},
  };
  return all;
}

// Columns that are empty in every row are left out: the table is one that `study analyze` reads.
std::vector<DataColumn> columns_of(const Analysis& a) {
  std::vector<DataColumn> out;
  for (const DataColumn& column : data_columns())
    if (std::any_of(a.answers.rows.begin(), a.answers.rows.end(),
                    [&](const Answer& row) { return !column.text(a.answers, row, a.settings.ties).empty(); }))
      out.push_back(column);
  return out;
}

std::string data_csv(const Analysis& a) {
  const std::vector<DataColumn> columns = columns_of(a);
  std::string out;
  for (const DataColumn& column : columns) out += fmt::format("{}{}", out.empty() ? "" : ",", column.name);
  out += "\n";
  for (const Answer& row : a.answers.rows) {
    bool first = true;
    for (const DataColumn& column : columns) {
      out += (first ? "" : ",") + safe_field(column.text(a.answers, row, a.settings.ties));
      first = false;
    }
    out += "\n";
  }
  return out;
}

std::string dataset_description(const Analysis& a) {
  Json measured = Json::array();
  for (const DataColumn& column : columns_of(a))
    measured.push_back({{"@type", "PropertyValue"}, {"name", column.name}, {"description", column.meaning}});
  return Json{{"@context", "https://schema.org"},
              {"@type", "Dataset"},
              {"name", "answers of a study of crowds"},
              {"description", fmt::format("Answers as they were analysed, after exclusions: {} of {}.",
                                          crowdbench::counted(a.answers.rows.size(), "row", "rows"),
                                          crowdbench::counted(a.participants, "participant", "participants"))},
              {"variableMeasured", measured}}
             .dump(2) +
         "\n";
}

// "1", "2", ... with what they stand for in README.md: names from files make no file names.
struct Numbers {
  std::map<std::string, size_t> of;
  size_t number(const std::string& name) { return of.emplace(name, of.size() + 1).first->second; }
};

std::string task_of_row(const Analysis& a, const Answer& row) { return name_of(a.answers.tasks, row.task); }

// One row an answer; "cannot tell" has no place in this form.
void add_pwcmp(const Analysis& a, Numbers& tasks, std::vector<ExportedFile>& out, std::string& readme) {
  std::map<size_t, std::string> by_task;
  uint64_t ties = 0;
  uint64_t counted = 0;
  for (const Answer& row : a.answers.rows) {
    if (!row.item_a) continue;
    std::string& text = by_task[tasks.number(task_of_row(a, row))];
    if (text.empty()) text = "Observer,Session,Scene,Condition_1,Condition_2,Selection\n";
    std::string scene = name_of(a.answers.conditions, row.condition);
    if (scene.empty()) scene = name_of(a.answers.clips, row.clip);
    const std::string who = name_of(a.answers.participants, row.participant);
    ties += row.ties;
    for (const auto& [count, selection] : {std::pair{row.yes, 1}, std::pair{row.no, 2}}) {
      counted += count;
      if (counted > kMostTableRows) continue;
      for (uint64_t i = 0; i < count; ++i)
        text += fmt::format("{},1,{},{},{},{}\n", safe_field(who.empty() ? "1" : who),
                            safe_field(scene.empty() ? "all" : scene), safe_field(a.answers.items[*row.item_a]),
                            safe_field(a.answers.items[*row.item_b]), selection);
    }
  }
  if (by_task.empty()) return;
  if (counted > kMostTableRows) {
    readme += fmt::format("\nNo pwcmp files: {} answers, one a row, are too many.\n", counted);
    return;
  }
  readme += fmt::format("\n`pwcmp/TASK.csv`: comparisons, one a row. {} \"cannot tell\" are left out.\n", ties);
  for (auto& [task, text] : by_task) out.push_back({fmt::format("pwcmp/{}.csv", task), std::move(text)});
}

void add_psignifit(const Analysis& a, Numbers& tasks, Numbers& conditions, std::vector<ExportedFile>& out,
                   std::string& readme) {
  struct Counts {
    uint64_t yes = 0, ties = 0, no = 0;
  };
  std::map<std::pair<size_t, size_t>, std::map<double, Counts>> by;
  for (const Answer& row : a.answers.rows) {
    if (!row.level || row.item_a) continue;
    Counts& c = by[{tasks.number(task_of_row(a, row)), conditions.number(name_of(a.answers.conditions, row.condition))}]
                  [*row.level];
    c = {c.yes + row.yes, c.ties + row.ties, c.no + row.no};
  }
  if (by.empty()) return;
  readme += "\n`psignifit/TASK-CONDITION.csv`: level, correct, total.\n";
  for (const auto& [key, levels] : by) {
    std::string text = "level,correct,total\n";
    for (const auto& [level, c] : levels) {
      const Decided d = decided(c.yes, c.ties, c.no, a.settings.ties);
      if (d.of > 0) text += fmt::format("{},{},{}\n", level, d.yes, d.of);
    }
    out.push_back({fmt::format("psignifit/{}-{}.csv", key.first, key.second), std::move(text)});
  }
}

std::string legend(const char* what, const Numbers& numbers) {
  std::string out;
  for (const auto& [name, number] : numbers.of)
    out += fmt::format("    {} {}: {}\n", what, number, name.empty() ? "all" : name);
  return out.empty() ? "" : "\n" + out;
}

}  // namespace

std::vector<ExportedFile> export_files(const Analysis& a) {
  std::vector<ExportedFile> out;
  std::string readme =
      "# Answers in the forms of other tools\n\n"
      "`data/study_answers_data.csv` with `dataset_description.json`: the answers that were analysed. `analysis.R` "
      "repeats the mixed\nmodels by lme4 from them (Rscript analysis.R, in this folder) and holds them against "
      "`estimates.csv`. In all\nCSV files names that begin with = + - @ have an apostrophe before them: "
      "spreadsheets would run them as formulas.\n";
  Numbers tasks;
  Numbers conditions;
  out.push_back({"dataset_description.json", dataset_description(a)});
  out.push_back({"data/study_answers_data.csv", data_csv(a)});
  add_pwcmp(a, tasks, out, readme);
  add_psignifit(a, tasks, conditions, out, readme);
  out.push_back({"analysis.R", r_script(a)});
  out.push_back({"estimates.csv", estimates_csv(a)});
  out.push_back({"README.md", readme + legend("task", tasks) + legend("condition", conditions)});
  return out;
}

void write_exports(const Analysis& analysis, const std::filesystem::path& folder) {
  make_folder(folder);
  for (const ExportedFile& file : export_files(analysis)) {
    const std::filesystem::path path = folder / file.name;
    if (path.parent_path() != folder) make_folder(path.parent_path());
    write_file(path, file.text);
  }
}

}  // namespace crowdbench::studies
