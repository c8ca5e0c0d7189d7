#include "reports/model/lead.h"

#include <fmt/format.h>

#include "reports/model/distance_series.h"
#include "reports/model/equal_levels.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

// Time over the reference's at the largest crowd of the character that the file has a ratio of; beside it the level of
// detail that is as wrong, and those that were asked for.
std::string cost_of(const std::vector<Scene>& scenes, const std::string& character, const std::string& name) {
  const RatioRow* best = nullptr;
  const Scene* where = nullptr;
  for (const Scene& scene : scenes) {
    if (scene.character != character) continue;
    for (const double occupancy : scene.occupancies)
      for (const uint32_t agents : scene.agents) {
        const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, scene.run->headline);
        if (ratio == nullptr || !(ratio->low > 0) || (best != nullptr && best->of.agents >= agents)) continue;
        best = ratio;
        where = &scene;
      }
  }
  if (best == nullptr) return "not timed in this file";
  std::string levels;
  const auto beside = levels_beside(*where, name, best->of.requested_occupancy);
  if (beside) levels = "; " + equal_levels_clause(beside->row);
  for (const std::string& level : where->representations) {
    if (!is_level(*where, level) || level == name || (beside && is_ruler(*where, level))) continue;
    const RatioRow* own =
        where->ratio("speed", level, best->of.agents, best->of.requested_occupancy, where->run->headline);
    if (own != nullptr) levels += fmt::format("; {:.3g} of {}’s", own->ratio / best->ratio, level);
  }
  return fmt::format("{:.3g} of {}’s time ({:.3g} to {:.3g}), {}{}", 1 / best->ratio, where->reference, 1 / best->high,
                     1 / best->low, agents_text(best->of.agents), levels);
}

// A tuned rule weighs what a switch shows, too.
void add_tuned(const StoreContents& contents, const std::vector<Scene>& scenes, const std::vector<ScoreDoc>& docs,
               Lead& out) {
  for (const TuningRow& tuning : contents.tunings)
    for (const TunedSwitchRow& row : tuning.switches) {
      std::string from = fmt::format("from {:.1f} m on, where figures are {:.1f} px tall", row.depth, row.height_px);
      from += row.decided && row.low_px ? fmt::format(" (95 %: {:.1f} to {:.1f} px)", *row.low_px, *row.high_px)
                                        : std::string(" (undecided)");
      const ScoreDoc doc = doc_of(docs, tuning.score);
      out.rows.push_back({tuning.character, row.to,
                          tuning.budget_ns ? time_text(*tuning.budget_ns) + " a frame"
                                           : doc.title + " " + score_text(doc, tuning.threshold),
                          std::move(from), cost_of(scenes, tuning.character, row.to)});
    }
}

}  // namespace

Lead lead_of(const StoreContents& contents, const std::vector<Scene>& scenes, const std::vector<ScoreDoc>& docs) {
  Lead out;
  add_tuned(contents, scenes, docs, out);
  const bool tuned = !out.rows.empty();
  for (const CurveRow& curve : contents.curves) {
    if (curve.against != "distance_m" || curve.bins.empty()) continue;
    for (const ThresholdRow& row : contents.thresholds) {
      if (row.curve != curve.id) continue;
      const ScoreDoc doc = doc_of(docs, curve.score);
      out.rows.push_back({curve.character, curve.representation, doc.title + " " + score_text(doc, row.value),
                          threshold_text(row, curve), cost_of(scenes, curve.character, curve.representation)});
    }
  }
  if (out.rows.empty())
    out.silent =
        "From which distance on another representation may be drawn is not in this file: nothing in it was scored "
        "against distance. The command “tune” with --db adds that, and “distance” without what switches show.";
  else if (tuned)
    out.basis =
        "Rows of “tune”: the cheapest chain in which neither errors nor switches show more than was allowed; others "
        "are "
        "read from what each agent of a crowd scored against how far away it was, and from paired times.";
  else
    out.basis =
        "Read from what each agent of a crowd scored against how far away it was, and from paired times. What a switch "
        "itself shows is not in these rows: the command “tune” weighs it too.";
  return out;
}

}  // namespace crowdbench::reports
