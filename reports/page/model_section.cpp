#include <fmt/format.h>

#include <algorithm>

#include "reports/charts/cost_charts.h"
#include "reports/model/cost_text.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

Rows chart_rows(SceneOnPage& page, const std::string& chart, const std::string& title) {
  Rows rows;
  if (!chart.empty()) rows.push_back({{"html", page.chart(chart, title)}});
  return rows;
}

TemplateValues front_values(SceneOnPage& page, const ParetoFront& front) {
  Rows entries;
  for (const ParetoEntry& entry : front.entries)
    entries.push_back({{"representation", page.mark(entry.representation)},
                       {"time", time_ratio_text(entry)},
                       {"bytes", entry.bytes ? bytes_text(*entry.bytes) : std::string("–")},
                       {"error_value", entry.error ? score_text(front.score, *entry.error) : std::string("–")},
                       {"state", front_text(front, entry)}});
  const bool scored = !front.score.name.empty();
  return {{"where", fmt::format("{}, {}", agents_text(front.agents), occupancy_title(front.occupancy))},
          {"scored", scored ? fmt::format("Error: {} over {}.", front.score.title, front.scored_over)
                            : std::string("Nothing was scored, so time and bytes alone decide.")},
          {"error", scored ? heading(front.score) : std::string("Error")},
          {"charts", chart_rows(page, front_chart(page.scene, front), "The trade")},
          {"entries", std::move(entries)}};
}

// Of the occupancies that curves are drawn of; where there are none, of the first.
std::vector<ParetoFront> shown_fronts(const Scene& scene) {
  std::vector<ParetoFront> all = pareto_fronts(scene);
  const std::vector<double> shown = shown_occupancies(scene);
  if (shown.empty() && !all.empty()) all.resize(1);
  if (!shown.empty())
    std::erase_if(all, [&](const ParetoFront& front) {
      return std::find(shown.begin(), shown.end(), front.occupancy) == shown.end();
    });
  return all;
}

}  // namespace

Html model_section(SceneOnPage& page) {
  const Scene& scene = page.scene;
  if (scene.rows.empty()) return {};
  std::vector<CostModel> models;
  for (const std::string& name : scene.representations) models.push_back(cost_model(scene, name));
  const std::vector<ParetoFront> found = shown_fronts(scene);
  if (found.empty() &&
      std::none_of(models.begin(), models.end(), [](const CostModel& model) { return model.absent.empty(); }))
    return {};
  Rows rows;
  for (const CostModel& model : models)
    rows.push_back({{"representation", page.mark(model.representation)},
                    {"formula", model.absent.empty() ? formula_text(model.fit) : std::string("no model")},
                    {"accuracy", model.absent.empty() ? accuracy_text(model) : model.absent}});
  const BreakEvenMap map = break_even_map(scene);
  Rows contours;
  Rows sentences;
  for (const std::string& sentence : break_even_sentences(scene, map)) sentences.push_back({{"text", sentence}});
  if (!sentences.empty()) contours.push_back({{"sentences", std::move(sentences)}});
  Rows prediction = chart_rows(page, prediction_chart(scene, models), "Predicted against measured");
  Rows cheapest = chart_rows(page, cheapest_chart(scene, map), "The cheapest one");
  Rows fronts;
  for (const ParetoFront& front : found) fronts.push_back(front_values(page, front));
  return fill_template(page_file("model.html"), {{"metric", metric_title(scene.run->headline)},
                                                 {"models", std::move(rows)},
                                                 {"prediction", std::move(prediction)},
                                                 {"map", std::move(cheapest)},
                                                 {"contours", std::move(contours)},
                                                 {"fronts", std::move(fronts)}});
}

Html samples_section(SceneOnPage& page) {
  const Scene& scene = page.scene;
  if (scene.occupancies.empty()) return {};
  const double occupancy = scene.occupancies.front();
  const std::vector<const MeasurementRow*> rows = sampled_rows(scene, occupancy);
  if (rows.empty()) return {};
  const std::string series = samples_chart(scene, rows);
  if (series.empty()) return {};
  std::vector<Html> charts{page.chart(series, "In the order drawn"),
                           page.chart(histogram_chart(scene, rows), "How often")};
  return fill_template(page_file("samples.html"), {{"agents", agents_text(rows.front()->key.agents)},
                                                   {"occupancy", occupancy_title(occupancy)},
                                                   {"metric", metric_title(scene.run->headline)},
                                                   {"budget", series.find("strokeDash") != std::string::npos},
                                                   {"charts", html_rows(std::move(charts))}});
}

}  // namespace crowdbench::reports
