#include "reports/model/equal_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "reports/model/number_text.h"
#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

// What was timed at a point: times over the reference's.
struct Timed {
  std::string representation;
  double triangles = 0;
  double time = 1, low = 1, high = 1;
  std::optional<double> error;
};
struct PointTimes {
  std::vector<Timed> levels;  // the whole reference first, each with fewer triangles than the one before
  std::vector<Timed> others;
};

std::optional<Timed> timed_at(const Scene& scene, const std::string& name, uint32_t agents, double occupancy) {
  const MeasurementRow* row = scene.find(name, agents, occupancy);
  if (row == nullptr || !is_timed(*row)) return std::nullopt;
  Timed out{name, static_cast<double>(row->triangles_per_agent.value_or(0)), 1, 1, 1, std::nullopt};
  if (name == scene.reference) return out;
  const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, scene.run->headline);
  if (ratio == nullptr || !(ratio->low > 0)) return std::nullopt;
  out.time = 1 / ratio->ratio;
  out.low = 1 / ratio->high;
  out.high = 1 / ratio->low;
  return out;
}

PointTimes times_at(const Scene& scene, uint32_t agents, double occupancy) {
  PointTimes out;
  for (const std::string& name : scene.representations) {
    const std::optional<Timed> timed = timed_at(scene, name, agents, occupancy);
    if (!timed) continue;
    const bool level = name == scene.reference || is_level(scene, name);
    if (level && !(timed->triangles > 0)) continue;
    (level ? out.levels : out.others).push_back(*timed);
  }
  std::ranges::stable_sort(out.levels, [](const Timed& a, const Timed& b) { return a.triangles > b.triangles; });
  const auto as_fine = [](const Timed& a, const Timed& b) { return a.triangles == b.triangles; };
  out.levels.erase(std::unique(out.levels.begin(), out.levels.end(), as_fine), out.levels.end());
  return out;
}

// The score of everything at the point by the crowd's pictures; the reference has what equal pictures have. Whether one
// that is no level has it, and a level.
bool put_errors(const Scene& scene, const ScoreDoc& doc, uint32_t agents, double occupancy, PointTimes& times) {
  const auto put = [&](std::vector<Timed>& some) {
    bool any = false;
    for (Timed& one : some) {
      one.error.reset();
      if (one.representation == scene.reference) one.error = doc.best;
      for (const ComparisonRow* row : scene.crowd_comparisons)
        if (row->representation == one.representation && row->agents == agents &&
            row->requested_occupancy == occupancy) {
          one.error = score_of(*row, doc.name);
          any = any || one.error.has_value();
        }
      if (one.error && !std::isfinite(*one.error)) one.error.reset();
    }
    return any;
  };
  const bool levels = put(times.levels);
  return put(times.others) && levels;
}

// Something of the levels against their triangles, x falling; straight between them.
struct Line {
  std::vector<double> x, y;
};
Line times_of(const std::vector<Timed>& levels, double Timed::*time) {
  Line line;
  for (const Timed& level : levels) {
    line.x.push_back(level.triangles);
    line.y.push_back(level.*time);
  }
  return line;
}
// Of those that were scored, against the logarithm of the triangles.
Line errors_of(const std::vector<Timed>& levels) {
  Line line;
  for (const Timed& level : levels) {
    if (!level.error) continue;
    line.x.push_back(std::log(level.triangles));
    line.y.push_back(*level.error);
  }
  return line;
}

// Where the line first comes to y from its beginning; `triangles` is the line's x.
LevelPlace place_of(const Line& line, double y, bool rises) {
  using Where = LevelPlace::Where;
  const auto passed = [&](double value) { return rises ? value >= y : value <= y; };
  if (line.y.front() != y && passed(line.y.front())) return {Where::beyond_finest, line.x.front()};
  for (size_t i = 0; i + 1 < line.x.size(); ++i) {
    if (line.y[i] == y) return {Where::between, line.x[i]};
    if (!passed(line.y[i + 1])) continue;
    const double share = (y - line.y[i]) / (line.y[i + 1] - line.y[i]);
    return {Where::between, line.x[i] + share * (line.x[i + 1] - line.x[i])};
  }
  return {line.y.back() == y ? Where::between : Where::beyond_coarsest, line.x.back()};
}

// The line's y at x; its ends go on level.
double value_at(const Line& line, double x) {
  if (x >= line.x.front()) return line.y.front();
  for (size_t i = 0; i + 1 < line.x.size(); ++i)
    if (x >= line.x[i + 1])
      return line.y[i + 1] + (line.y[i] - line.y[i + 1]) * (x - line.x[i + 1]) / (line.x[i] - line.x[i + 1]);
  return line.y.back();
}

EqualLevels beside(const std::vector<Timed>& levels, const Timed& one, const ScoreDoc& score) {
  EqualLevels row;
  row.representation = one.representation;
  row.error = one.error;
  row.equal_time = place_of(times_of(levels, &Timed::time), one.time, false);
  const Line errors = errors_of(levels);
  if (!one.error || errors.x.size() < 2) return row;
  row.equal_error = place_of(errors, *one.error, !score.higher_is_better);
  row.equal_error->triangles = std::exp(row.equal_error->triangles);
  const auto level_time = [&](double Timed::*time) {
    return value_at(times_of(levels, time), row.equal_error->triangles);
  };
  row.factor = level_time(&Timed::time) / one.time;
  row.low = level_time(&Timed::low) / one.high;
  row.high = level_time(&Timed::high) / one.low;
  row.error_of_equal_time = value_at(errors, std::log(row.equal_time.triangles));
  return row;
}

// The first that everything of interest has: errors before likenesses. Without a name where there is none.
ScoreDoc put_first_score(const Scene& scene, uint32_t agents, double occupancy, PointTimes& times) {
  for (const bool likeness : {false, true})
    for (const ScoreDoc& doc : scene.scores)
      if (doc.headline && doc.higher_is_better == likeness && doc.best && std::isfinite(*doc.best) &&
          put_errors(scene, doc, agents, occupancy, times))
        return doc;
  for (std::vector<Timed>* some : {&times.levels, &times.others})
    for (Timed& one : *some) one.error.reset();
  return {};
}

// Whether `line` holds the word, neither end of it within a longer one.
bool names_word(const std::string& line, const std::string& word) {
  constexpr const char* kBetween = " ,='\"\t\n()";
  for (size_t at = line.find(word); at != std::string::npos; at = line.find(word, at + 1)) {
    const size_t end = at + word.size();
    const auto between = [&](char c) { return std::string_view(kBetween).find(c) != std::string_view::npos; };
    if ((at == 0 || between(line[at - 1])) && (end == line.size() || between(line[end]))) return true;
  }
  return false;
}

std::optional<LevelTable> table_at(const Scene& scene, double occupancy) {
  std::optional<LevelTable> unscored;
  for (auto agents = scene.agents.rbegin(); agents != scene.agents.rend(); ++agents) {
    PointTimes times = times_at(scene, *agents, occupancy);
    if (times.others.empty() || times.levels.size() < 2 || times.levels.front().representation != scene.reference)
      continue;
    LevelTable table;
    table.agents = *agents;
    table.occupancy = occupancy;
    table.levels = times.levels.size() - 1;
    table.score = put_first_score(scene, *agents, occupancy, times);
    for (const Timed& one : times.others) table.rows.push_back(beside(times.levels, one, table.score));
    if (!table.score.name.empty()) return table;
    if (!unscored) unscored = std::move(table);
  }
  return unscored;
}

}  // namespace

bool is_level(const Scene& scene, const std::string& name) {
  // What changes between levels by itself has no number of triangles that it could be set by.
  return name.starts_with(scene.reference + ":") && name.find("lods=") == std::string::npos;
}

bool is_ruler(const Scene& scene, const std::string& name) {
  const auto answers = [&](const std::string& other) { return other != scene.reference && !is_level(scene, other); };
  return is_level(scene, name) && scene.run->command != "sweep" &&
         std::ranges::any_of(scene.representations, answers) && !names_word(scene.run->arguments, name);
}

std::vector<std::string> subjects_of(const Scene& scene) {
  std::vector<std::string> out;
  for (const std::string& name : scene.representations)
    if (name != scene.reference && !is_ruler(scene, name)) out.push_back(name);
  return out;
}

std::vector<LevelTable> level_tables(const Scene& scene) {
  std::vector<LevelTable> out;
  for (const double occupancy : scene.occupancies)
    if (std::optional<LevelTable> table = table_at(scene, occupancy)) out.push_back(std::move(*table));
  return out;
}

std::string place_text(const LevelPlace& place) {
  const std::string count = count_text(static_cast<uint64_t>(std::llround(place.triangles)));
  switch (place.where) {
    case LevelPlace::Where::beyond_finest: return fmt::format("more than {} triangles", count);
    case LevelPlace::Where::beyond_coarsest: return fmt::format("fewer than {} triangles", count);
    case LevelPlace::Where::between: break;
  }
  return fmt::format("about {} triangles", count);
}

std::optional<LevelsBeside> levels_beside(const Scene& scene, const std::string& representation, double occupancy) {
  const std::optional<LevelTable> table = table_at(scene, occupancy);
  if (!table) return std::nullopt;
  for (const EqualLevels& row : table->rows)
    if (row.representation == representation) return LevelsBeside{*table, row};
  return std::nullopt;
}

std::string equal_levels_clause(const EqualLevels& row) {
  const bool cheaper = row.equal_time.where == LevelPlace::Where::beyond_coarsest;
  if (!row.equal_error)
    return fmt::format("a level of {} {} as {}", place_text(row.equal_time), cheaper ? "would be" : "is",
                       cheaper ? "cheap" : "dear");
  return fmt::format("a level of {} is as wrong, at {}{} times its time", place_text(*row.equal_error),
                     row.equal_error->where == LevelPlace::Where::beyond_coarsest ? "less than " : "",
                     factor_text(row.factor));
}

std::string equal_levels_text(const LevelTable& table, const EqualLevels& row, const std::string& reference) {
  std::string text;
  if (row.equal_error)
    text = fmt::format(" With {}, a level of {} of {} is as wrong ({} {}) and takes {}{} times its time ({} to {}).",
                       agents_text(table.agents), place_text(*row.equal_error), reference, table.score.title,
                       score_text(table.score, *row.error),
                       row.equal_error->where == LevelPlace::Where::beyond_coarsest ? "less than " : "",
                       factor_text(row.factor), factor_text(row.low), factor_text(row.high));
  text += row.equal_time.where == LevelPlace::Where::beyond_coarsest ? " As cheap would be a level of "
                                                                     : " As dear is a level of ";
  text += place_text(row.equal_time);
  if (row.error_of_equal_time)
    text += fmt::format(" ({} {}{})", table.score.title,
                        row.equal_time.where == LevelPlace::Where::beyond_coarsest ? "worse than " : "",
                        score_text(table.score, *row.error_of_equal_time));
  return text + ".";
}

}  // namespace crowdbench::reports
