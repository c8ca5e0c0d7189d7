#include "reports/exports/scores_markdown.h"

#include <fmt/format.h>

#include "reports/exports/markdown_cell.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

// The two lines above a table: what tells the rows apart, the first of it a text, then the scores.
std::string head(const std::vector<std::string>& keys, const std::vector<ScoreDoc>& scores) {
  std::string titles = "|";
  std::string rule = "|";
  for (const std::string& key : keys) {
    titles += fmt::format(" {} |", key);
    rule += rule.size() == 1 ? "---|" : "--:|";
  }
  for (const ScoreDoc& doc : scores) {
    titles += fmt::format(" {} |", markdown_cell(heading(doc)));
    rule += "--:|";
  }
  return fmt::format("{}\n{}\n", titles, rule);
}

std::string agents_markdown(const Scene& scene) {
  const AgentScoreTable table = agent_score_table(scene);
  if (table.rows.empty()) return {};
  std::string out = "\n## Difference of single agents\n\nMean over the views, with the worst view in brackets.\n\n";
  out += head({"representation", "height, px", "views"}, table.columns);
  for (const AgentScoreRow& row : table.rows) {
    out += fmt::format("| {} | {:.0f} | {} |", markdown_cell(row.representation), row.height_px, row.views);
    for (const std::optional<ScoreCell>& score : row.cells)
      out += score ? fmt::format(" {} ({}) |", score->mean, score->worst) : std::string(" – |");
    out += '\n';
  }
  return out;
}

std::string frames_markdown(const Scene& scene) {
  const std::vector<ScoreDoc> scores = scores_in(scene, scene.crowd_comparisons);
  if (scores.empty()) return {};
  std::string out = "\n## Difference of whole frames\n\n";
  out += head({"representation", "agents", "occupancy"}, scores);
  for (const ComparisonRow* row : scene.crowd_comparisons) {
    out += fmt::format("| {} | {} | {} |", markdown_cell(row->representation), count_text(row->agents),
                       occupancy_text(row->requested_occupancy));
    for (const ScoreDoc& doc : scores) {
      const auto value = score_of(*row, doc.name);
      out += value ? fmt::format(" {} |", score_text(doc, *value)) : std::string(" – |");
    }
    out += '\n';
  }
  return out;
}

}  // namespace

std::string scores_markdown(const Scene& scene) { return agents_markdown(scene) + frames_markdown(scene); }

}  // namespace crowdbench::reports
