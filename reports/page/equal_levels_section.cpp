#include <fmt/format.h>

#include "reports/model/equal_levels.h"
#include "reports/model/number_text.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

// Of the level as wrong: which is the cheaper one, where the interval tells.
std::string cheaper_text(const EqualLevels& row) {
  if (!row.equal_error) return "–";
  // Of a level beyond the coarsest all that is known is that it takes less.
  const bool bound = row.equal_error->where == LevelPlace::Where::beyond_coarsest;
  if (row.high < 1) return "the level";
  if (row.low > 1 && !bound) return row.representation;
  return "not distinguishable";
}

TemplateValues table_values(const SceneOnPage& page, const LevelTable& table) {
  std::vector<TemplateValues> rows;
  const auto dash = std::string("–");
  for (const EqualLevels& row : table.rows) {
    const bool bound = row.equal_error && row.equal_error->where == LevelPlace::Where::beyond_coarsest;
    const bool least = row.equal_time.where == LevelPlace::Where::beyond_coarsest;
    rows.push_back(
        {{"representation", page.mark(row.representation)},
         {"error_value", row.error ? score_text(table.score, *row.error) : dash},
         {"equal_error", row.equal_error ? place_text(*row.equal_error) : dash},
         {"factor", row.equal_error ? fmt::format("{}{} ({} to {})", bound ? "less than " : "", factor_text(row.factor),
                                                  factor_text(row.low), factor_text(row.high))
                                    : dash},
         {"equal_time", place_text(row.equal_time)},
         {"its_error", row.error_of_equal_time
                           ? (least ? "worse than " : "") + score_text(table.score, *row.error_of_equal_time)
                           : dash},
         {"cheaper", cheaper_text(row)}});
  }
  const bool scored = !table.score.name.empty();
  return {{"where", fmt::format("{}, {}", agents_text(table.agents), occupancy_title(table.occupancy))},
          {"reference", page.scene.reference},
          {"scored", scored ? fmt::format("Wrong: {} of the crowd’s pictures.", table.score.title)
                            : std::string("The crowd’s pictures were not scored, so cost alone is told.")},
          {"error", scored ? heading(table.score) : std::string("Error")},
          {"levels", fmt::format("{} level{}", table.levels, table.levels == 1 ? "" : "s")},
          {"rows", std::move(rows)}};
}

}  // namespace

Html equal_levels_section(const SceneOnPage& page) {
  std::vector<TemplateValues> tables;
  for (const LevelTable& table : level_tables(page.scene)) tables.push_back(table_values(page, table));
  if (tables.empty()) return {};
  return fill_template(page_file("equal_levels.html"), {{"tables", std::move(tables)}});
}

}  // namespace crowdbench::reports
