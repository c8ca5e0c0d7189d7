#include "reports/exports/cost_export.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/exports/markdown_cell.h"
#include "reports/model/cost_text.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json model_json(const CostModel& model) {
  Json out = {{"representation", model.representation},
              {"absent", model.absent.empty() ? Json(nullptr) : Json(model.absent)},
              {"terms", Json::array()},
              {"points", Json::array()}};
  for (const CostCoefficient& term : model.fit.terms)
    out["terms"].push_back({{"of", cost_term_name(term.term)}, {"ns", term.ns}});
  for (const CostPrediction& one : model.held_out)
    out["points"].push_back({{"agents", one.point.agents},
                             {"requested_occupancy", one.point.occupancy},
                             {"measured_ns", one.point.time_ns},
                             {"predicted_ns", one.predicted_ns},
                             {"between", one.between}});
  const bool none = !model.absent.empty();
  out["held_out_error"] = none ? Json(nullptr) : Json(model.error);
  out["within_15_percent"] = none ? Json(nullptr) : Json(model.within_15);
  out["between"] = none ? Json(nullptr)
                        : Json({{"points", model.between},
                                {"within_15_percent", model.between_within_15},
                                {"held_out_error", model.between_error}});
  out["within_share"] =
      none ? Json(nullptr) : Json({{"low", model.within_share.low}, {"high", model.within_share.high}});
  return out;
}

Json pair_json(const BreakEven& pair) {
  Json out = {{"first", pair.first},
              {"second", pair.second},
              {"ratio_bias", pair.ratio_bias},
              {"ratio_factor", pair.ratio_factor},
              {"contour", Json::array()}};
  for (const BreakEvenPoint& point : pair.contour)
    out["contour"].push_back(
        {{"occupancy", point.occupancy},
         {"from", point.from},
         {"to", point.to},
         {"agents", number_or_null(point.agents)},
         {"low", number_or_null(point.low)},
         {"high", number_or_null(point.high)},
         {"low_open", point.low_open},
         {"high_open", point.high_open},
         {"cheaper_below", point.cheaper_below.empty() ? Json(nullptr) : Json(point.cheaper_below)},
         {"cheaper_beyond", point.cheaper_beyond.empty() ? Json(nullptr) : Json(point.cheaper_beyond)}});
  return out;
}

Json front_json(const ParetoFront& front) {
  Json out = {{"agents", front.agents},
              {"requested_occupancy", front.occupancy},
              {"score", front.score.name.empty() ? Json(nullptr) : Json(front.score.name)},
              {"scored_over", front.scored_over},
              {"entries", Json::array()}};
  for (const ParetoEntry& entry : front.entries)
    out["entries"].push_back({{"representation", entry.representation},
                              {"time_over_reference", entry.time},
                              {"low", entry.low},
                              {"high", entry.high},
                              {"gpu_bytes", entry.bytes ? Json(*entry.bytes) : Json(nullptr)},
                              {"error", number_or_null(entry.error)},
                              {"beaten_by", entry.beaten_by.empty() ? Json(nullptr) : Json(entry.beaten_by)}});
  return out;
}

std::string models_markdown(const std::vector<CostModel>& models) {
  std::string out = "| representation | time | predicting points not fitted |\n|---|---|---|\n";
  for (const CostModel& model : models)
    out += fmt::format("| {} | {} | {} |\n", markdown_cell(model.representation),
                       model.absent.empty() ? formula_text(model.fit) : "no model",
                       model.absent.empty() ? accuracy_text(model) : model.absent);
  return out;
}

std::string front_markdown(const ParetoFront& front) {
  std::string out =
      fmt::format("\n{}, {}{}:\n\n", agents_text(front.agents),
                  front.occupancy > 0 ? percent_text(front.occupancy) + " of the picture covered"
                                      : std::string("the scenario's own camera"),
                  front.scored_over.empty() ? "; nothing was scored" : "; error over " + front.scored_over);
  out +=
      fmt::format("| representation | time over the reference's | bytes on the GPU | {} | |\n|---|--:|--:|--:|---|\n",
                  front.score.name.empty() ? "error" : markdown_cell(heading(front.score)));
  for (const ParetoEntry& entry : front.entries)
    out +=
        fmt::format("| {} | {} | {} | {} | {} |\n", markdown_cell(entry.representation), time_ratio_text(entry),
                    entry.bytes ? bytes_text(*entry.bytes) : "–",
                    entry.error ? score_text(front.score, *entry.error) : "–", markdown_cell(front_text(front, entry)));
  return out;
}

}  // namespace

Json cost_json(const Scene& scene) {
  Json out = {{"character", scene.character},  {"width_px", scene.width},
              {"height_px", scene.height},     {"scenario", scene.run->scenario_name},
              {"metric", scene.run->headline}, {"renderer", scene.run->gl_renderer},
              {"models", Json::array()},       {"models_beforehand", Json::array()},
              {"break_even", Json::array()},   {"cheapest", Json::array()},
              {"pareto", Json::array()}};
  for (const std::string& name : scene.representations) out["models"].push_back(model_json(cost_model(scene, name)));
  const BreakEvenMap map = break_even_map(scene);
  for (const CostModel& model : map.models) out["models_beforehand"].push_back(model_json(model));
  for (const BreakEven& pair : map.pairs) out["break_even"].push_back(pair_json(pair));
  for (const CheapestCell& cell : map.cells)
    out["cheapest"].push_back({{"agents", cell.agents},
                               {"occupancy", cell.occupancy},
                               {"representation", cell.cheapest},
                               {"not_told_apart", cell.not_told_apart}});
  for (const ParetoFront& front : pareto_fronts(scene)) out["pareto"].push_back(front_json(front));
  return out;
}

std::string cost_markdown(const Scene& scene) {
  if (std::all_of(scene.representations.begin(), scene.representations.end(),
                  [&](const std::string& name) { return cost_points(scene, name).empty(); }))
    return {};
  std::vector<CostModel> models;
  for (const std::string& name : scene.representations) models.push_back(cost_model(scene, name));
  std::string out = fmt::format("\n## Cost model: {}, {} × {}, {}\n\n", markdown_cell(scene.character), scene.width,
                                scene.height, metric_title(scene.run->headline));
  out += models_markdown(models);
  const BreakEvenMap map = break_even_map(scene);
  if (const auto sentences = break_even_sentences(scene, map); !sentences.empty()) {
    out += "\n## Break-even\n\n";
    for (const std::string& sentence : sentences) out += "- " + markdown_cell(sentence) + "\n";
  }
  const std::vector<ParetoFront> fronts = pareto_fronts(scene);
  if (!fronts.empty()) out += "\n## Time, bytes and error\n";
  for (const ParetoFront& front : fronts) out += front_markdown(front);
  return out;
}

}  // namespace crowdbench::reports
