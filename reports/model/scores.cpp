#include "reports/model/scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace crowdbench::reports {

std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name) {
  for (const ScoreRow& score : comparison.scores)
    if (score.name == name) return score.value;
  return std::nullopt;
}

std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score) {
  std::vector<ScoreByHeight> all;
  for (const std::string& representation : scene.representations) {
    std::map<double, std::vector<double>> values;
    for (const ComparisonRow* row : scene.agent_comparisons) {
      if (row->representation != representation || !row->height_px) continue;
      const std::optional<double> value = score_of(*row, score);
      if (value && std::isfinite(*value)) values[*row->height_px].push_back(*value);
    }
    for (const auto& [height, list] : values) {
      double sum = 0;
      for (const double value : list) sum += value;
      const auto [least, greatest] = std::minmax_element(list.begin(), list.end());
      all.push_back({representation, height, sum / static_cast<double>(list.size()), *least, *greatest, list.size()});
    }
  }
  return all;
}

double worst_of(const ScoreDoc& doc, const ScoreByHeight& views) {
  return doc.higher_is_better ? views.least : views.greatest;
}

std::vector<ScoreDoc> scores_in(const Scene& scene, const std::vector<const ComparisonRow*>& comparisons) {
  std::vector<ScoreDoc> found;
  for (const ScoreDoc& doc : scene.scores)
    if (std::any_of(comparisons.begin(), comparisons.end(),
                    [&](const ComparisonRow* row) { return score_of(*row, doc.name).has_value(); }))
      found.push_back(doc);
  return found;
}

AgentScoreTable agent_score_table(const Scene& scene) {
  AgentScoreTable table;
  table.columns = scores_in(scene, scene.agent_comparisons);
  for (const std::string& representation : scene.representations) {
    std::map<double, size_t> views;
    for (const ComparisonRow* row : scene.agent_comparisons)
      if (row->representation == representation && row->height_px) ++views[*row->height_px];
    for (const auto& [height, count] : views) table.rows.push_back({representation, height, count, {}});
  }
  for (const ScoreDoc& doc : table.columns) {
    const std::vector<ScoreByHeight> values = scores_by_height(scene, doc.name);
    for (AgentScoreRow& row : table.rows) {
      const auto value = std::find_if(values.begin(), values.end(), [&](const ScoreByHeight& v) {
        return v.representation == row.representation && v.height_px == row.height_px;
      });
      row.cells.emplace_back();
      if (value != values.end())
        row.cells.back() = ScoreCell{score_text(doc, value->mean), score_text(doc, worst_of(doc, *value))};
    }
  }
  return table;
}

std::string headline_scores(const Scene& scene, const ComparisonRow& comparison) {
  std::string text;
  for (const ScoreDoc& doc : scene.scores)
    if (const auto value = score_of(comparison, doc.name); value && doc.headline)
      text += (text.empty() ? "" : ", ") + doc.title + " " + score_text(doc, *value);
  return text;
}

}  // namespace crowdbench::reports
