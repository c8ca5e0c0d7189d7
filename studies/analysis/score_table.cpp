#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "studies/analysis/score_prediction.h"

namespace crowdbench::studies {
namespace {

// Which column names the stimuli.
size_t key_column(const Table& table, ScoreTable::Key& key) {
  const std::pair<const char*, ScoreTable::Key> names[] = {{"stimulus", ScoreTable::Key::stimulus},
                                                           {"clip", ScoreTable::Key::clip},
                                                           {"condition", ScoreTable::Key::condition},
                                                           {"item", ScoreTable::Key::item}};
  std::vector<size_t> found;
  for (size_t i = 0; i < table.columns.size(); ++i)
    for (const auto& [name, each] : names)
      if (table.columns[i] == name) {
        found.push_back(i);
        key = each;
      }
  if (found.size() != 1)
    throw Error(table.source + ":1",
                found.empty() ? "has no column that says whose scores they are" : "says twice whose scores they are",
                "name one column `stimulus`, `clip`, `condition` or `item`, as the answers name them");
  return found.front();
}

std::optional<double> score_value(const Table& table, const Table::Row& row, size_t column) {
  const std::string& text = row.fields[column];
  if (text.empty()) return std::nullopt;
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw Error(
        fmt::format("{}:{}", table.source, row.line),
        fmt::format("'{}' in column '{}' is not a score", printable(text, 60), printable(table.columns[column], 60)),
        "a score is a finite number, or empty where there is none");
  return value;
}

constexpr size_t kMostJsonBytes = size_t{256} << 20U;

[[noreturn]] void refuse_study(const std::string& file, const std::string& wrong) {
  throw Error(file, wrong, "give the study.json that `crowdbench study export` wrote, or a table of scores");
}

// The place of a score's name in the table, added where it is new.
size_t score_place(ScoreTable& table, const std::string& name) {
  const auto found = std::find(table.scores.begin(), table.scores.end(), name);
  const auto place = static_cast<size_t>(found - table.scores.begin());
  if (found == table.scores.end()) table.scores.push_back(name);
  return place;
}

ScoreTable scores_of_study(const std::filesystem::path& file) {
  using Parsed = nlohmann::json;
  ScoreTable out;
  out.source = file.string();
  const Parsed study = Parsed::parse(read_text(file, kMostJsonBytes), nullptr, false);
  if (!study.is_object() || !study.contains("stimuli") || !study["stimuli"].is_array())
    refuse_study(out.source, "is not a study.json with a list `stimuli`");
  if (study.value("format", Parsed(1)) != Parsed(1)) refuse_study(out.source, "is of another format");
  if (study.contains("hash") && study["hash"].is_string()) out.study = study["hash"].get<std::string>();
  std::set<std::string> seen;
  for (const Parsed& stimulus : study["stimuli"]) {
    if (!stimulus.is_object() || !stimulus.contains("id") || !stimulus["id"].is_string() ||
        !stimulus.contains("scores") || !stimulus["scores"].is_array())
      refuse_study(out.source, "has a stimulus without `id` and `scores`");
    if (stimulus["scores"].empty()) continue;  // nothing was compared: a catch trial
    out.keys.push_back(stimulus["id"].get<std::string>());
    if (!seen.insert(out.keys.back()).second)
      refuse_study(out.source, fmt::format("has the stimulus '{}' twice", printable(out.keys.back(), 60)));
    out.values.emplace_back();
    for (const Parsed& score : stimulus["scores"]) {
      if (!score.is_object() || !score.contains("score") || !score["score"].is_string() || !score.contains("mean") ||
          !score["mean"].is_number())
        refuse_study(out.source, fmt::format("`{}` has a score without name and mean", printable(out.keys.back(), 60)));
      const size_t place = score_place(out, score["score"].get<std::string>());
      if (out.values.back().size() <= place) out.values.back().resize(place + 1);
      out.values.back()[place] = score["mean"].get<double>();
    }
  }
  if (out.scores.empty() || out.scores.size() > kMostScores)
    refuse_study(out.source, fmt::format("has {} scores, and 1 to {} are taken", out.scores.size(), kMostScores));
  for (auto& values : out.values) values.resize(out.scores.size());
  return out;
}

}  // namespace

ScoreTable read_scores(const std::filesystem::path& file) {
  return file.extension() == ".json" ? scores_of_study(file) : score_table(read_table(file));
}

ScoreTable score_table(const Table& table) {
  ScoreTable out;
  out.source = table.source;
  const size_t key = key_column(table, out.key);
  for (size_t i = 0; i < table.columns.size(); ++i)
    if (i != key) out.scores.push_back(table.columns[i]);
  if (out.scores.empty() || out.scores.size() > kMostScores)
    throw Error(table.source + ":1", fmt::format("has {} scores", out.scores.size()),
                fmt::format("give a column for each of 1 to {} scores", kMostScores));
  std::set<std::string> seen;
  for (const Table::Row& row : table.rows) {
    const std::string& name = row.fields[key];
    const std::string where = fmt::format("{}:{}", table.source, row.line);
    if (name.empty())
      throw Error(where, fmt::format("column '{}' is empty", printable(table.columns[key])), "every row needs one");
    if (!seen.insert(name).second)
      throw Error(where, fmt::format("has scores of '{}' again", printable(name, 60)), "remove one of the two rows");
    out.keys.push_back(name);
    out.values.emplace_back();
    for (size_t i = 0; i < table.columns.size(); ++i)
      if (i != key) out.values.back().push_back(score_value(table, row, i));
  }
  return out;
}

}  // namespace crowdbench::studies
