#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <set>

#include "core/error.h"
#include "studies/analysis/score_prediction.h"

namespace crowdbench::studies {
namespace {

// Which column names the stimuli.
size_t key_column(const Table& table, ScoreTable::Key& key) {
  const std::pair<const char*, ScoreTable::Key> names[] = {
      {"clip", ScoreTable::Key::clip}, {"condition", ScoreTable::Key::condition}, {"item", ScoreTable::Key::item}};
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
                "name one column `clip`, `condition` or `item`, as the answers name them");
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

}  // namespace

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
