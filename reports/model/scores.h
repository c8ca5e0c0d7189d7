// The scores of comparisons, gathered for tables, charts and sentences.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"
#include "reports/model/score_doc.h"

namespace crowdbench::reports {

// Mean, least and greatest of one score over the agent comparisons of a representation at one height in pixels.
struct ScoreByHeight {
  std::string representation;
  double height_px = 0;
  double mean = 0, least = 0, greatest = 0;
  size_t views = 0;
};
std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score);
// The worse end of the views.
double worst_of(const ScoreDoc& doc, const ScoreByHeight& views);

// std::nullopt where the comparison lacks it.
std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name);

// Of the scene's scores those that one of the comparisons has a value of.
std::vector<ScoreDoc> scores_in(const Scene& scene, const std::vector<const ComparisonRow*>& comparisons);

// The scores of single agents by height, as texts.
struct ScoreCell {
  std::string mean, worst;
};
struct AgentScoreRow {
  std::string representation;
  double height_px = 0;
  size_t views = 0;
  std::vector<std::optional<ScoreCell>> cells;  // by column
};
struct AgentScoreTable {
  std::vector<ScoreDoc> columns;
  std::vector<AgentScoreRow> rows;  // by representation, then height
};
AgentScoreTable agent_score_table(const Scene& scene);

// "silhouette IoU 0.9871, SSIM 0.9500": what a comparison's picture is captioned with; empty where it has none of them.
std::string headline_scores(const Scene& scene, const ComparisonRow& comparison);

}  // namespace crowdbench::reports
