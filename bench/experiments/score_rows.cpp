#include "bench/experiments/score_rows.h"

#include "metrics/popping.h"

namespace crowdbench::bench {

metrics::Buffers buffers_of(const renderers::Capture& capture) {
  metrics::Buffers out;
  out.codes = &capture.colour;
  out.ids = &capture.ids;
  if (!capture.linear.empty()) out.linear = &capture.linear;
  if (!capture.depth.empty()) out.depth = &capture.depth;
  return out;
}

std::vector<ScoreRow> score_rows(std::span<const metrics::Scored> scores) {
  std::vector<ScoreRow> rows;
  for (const auto& [score, result] : scores) {
    const std::string name(score->name);
    rows.push_back({name, result.value, result.reason});
    for (const auto* figures : {&result.pooled, &result.details})
      for (const metrics::ScoreFigure& of : *figures) rows.push_back({name + "." + of.name, of.value, ""});
  }
  return rows;
}

void put_display(ComparisonRow& row, const metrics::ChosenDisplay& chosen) {
  row.display = metrics::display_text(chosen);
  row.display_given = chosen.given;
}

std::vector<reports::ScoreDoc> score_docs(metrics::ScoreTable table) {
  std::vector<reports::ScoreDoc> docs;
  for (const metrics::Score* score : table) {
    reports::ScoreDoc& doc = docs.emplace_back();
    doc.name = score->name;
    doc.title = score->title;
    doc.unit = score->unit;
    doc.computes = score->computes;
    doc.higher_is_better = score->direction == metrics::Direction::higher_is_better;
    doc.digits = score->digits;
    doc.best = metrics::best_value(*score);
    doc.least = score->least;
    doc.greatest = score->greatest;
    doc.headline = (score->uses & metrics::kHeadline) != 0;
    doc.charted = (score->uses & metrics::kCharted) != 0;
    doc.ranking = (score->uses & metrics::kRanking) != 0;
  }
  return docs;
}

std::vector<reports::ScoreDoc> pop_score_docs() {
  constexpr size_t kHeadlines = 2;
  std::vector<reports::ScoreDoc> docs;
  for (const metrics::PopScore& score : metrics::pop_scores()) {
    reports::ScoreDoc& doc = docs.emplace_back();
    doc.name = score.name;
    doc.title = score.title;
    doc.unit = score.unit;
    doc.computes = score.computes;
    doc.higher_is_better = score.direction == metrics::Direction::higher_is_better;
    doc.digits = score.digits;
    doc.best = score.equal;
    doc.headline = docs.size() <= kHeadlines;
  }
  return docs;
}

}  // namespace crowdbench::bench
