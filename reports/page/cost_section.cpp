#include <fmt/format.h>

#include "reports/charts/charts.h"
#include "reports/charts/cost_charts.h"
#include "reports/model/crossovers.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/folded.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

Rows crossovers(const SceneOnPage& page) {
  Rows lines;
  for (const CrossoverLine& line : crossovers_of(page.scene, page.scene.run->headline)) {
    lines.push_back({{"first", page.mark(line.first)},
                     {"second", page.mark(line.second)},
                     {"occupancy", occupancy_text(line.occupancy)},
                     {"text", crossover_text(line)},
                     {"time", line.agents ? ", a frame taking " + time_text(line.time_ns) : std::string()}});
  }
  if (lines.empty()) return {};
  return {{{"lines", std::move(lines)}}};
}

std::string covered_text(const Scene& scene, const MeasurementRow& row) {
  if (!row.covered_px) return "–";
  return percent_text(static_cast<double>(*row.covered_px) / (static_cast<double>(scene.width) * scene.height));
}

TemplateValues timed_cells(const Scene& scene, const MeasurementRow& row, const TimeSummary& time) {
  Rows speed;
  const PointKey& key = row.key;
  if (const RatioRow* ratio =
          scene.ratio("speed", key.representation, key.agents, key.requested_occupancy, scene.run->headline))
    speed.push_back(
        {{"factor", factor_text(ratio->ratio)}, {"low", factor_text(ratio->low)}, {"high", factor_text(ratio->high)}});
  return {{"median", time_text(time.median)},
          {"low", time_text(time.low)},
          {"high", time_text(time.high)},
          {"p05", time_text(time.p05)},
          {"p95", time_text(time.p95)},
          {"wall", time_text(row.frame_ns->median)},
          {"wall_p99", time_text(row.frame_ns->p99)},
          {"low_fps", row.low_1_percent_fps ? fmt::format("{:.1f}", *row.low_1_percent_fps) : "–"},
          {"speed", std::move(speed)},
          {"covered", covered_text(scene, row)},
          {"fault", row.status != Status::valid},
          {"status", status_name(row.status)},
          {"rounds", row.rounds}};
}

Rows table_rows(const SceneOnPage& page, double occupancy) {
  const Scene& scene = page.scene;
  Rows rows;
  for (const uint32_t agents : scene.agents) {
    for (const std::string& name : scene.representations) {
      const MeasurementRow* row = scene.find(name, agents, occupancy);
      if (row == nullptr) continue;
      const auto& time = time_of(*row, scene.run->headline);
      Rows timed;
      Rows untimed;
      if (row->frame_ns && time)
        timed.push_back(timed_cells(scene, *row, *time));
      else
        untimed.push_back(
            {{"columns", scene.run->software ? 9 : 10}, {"status", status_name(row->status)}, {"reason", row->reason}});
      rows.push_back({{"representation", page.mark(name)},
                      {"agents", count_text(agents)},
                      {"timed", std::move(timed)},
                      {"untimed", std::move(untimed)}});
    }
  }
  return rows;
}

// What heads the column of a table that metric_title() would make too wide.
const char* short_title(const std::string& metric) {
  if (metric == "gpu") return "GPU time";
  if (metric == "wall") return "Wall clock";
  return "CPU time";
}

Rows fewer_curves(const Scene& scene, const std::vector<double>& shown) {
  if (shown.size() == scene.occupancies.size()) return {};
  const std::string all = count_text(scene.occupancies.size());
  return {
      {{"text", shown.empty() ? "Each of the " + all + " occupancies was timed with one crowd: points, and no curves."
                              : fmt::format("Curves are of {} of {} occupancies with several crowds, from end to "
                                            "end; the tables have all.",
                                            shown.size(), all)}}};
}

}  // namespace

Html cost_section(SceneOnPage& page) {
  const Scene& scene = page.scene;
  std::vector<Html> time_charts;
  const std::vector<double> shown = shown_occupancies(scene);
  for (const double occupancy : shown)
    if (const std::string chart = time_chart(scene, occupancy); !chart.empty())
      time_charts.push_back(page.chart(chart, occupancy_title(occupancy)));
  if (time_charts.empty())
    if (const std::string chart = scatter_chart(scene); !chart.empty())
      time_charts.push_back(page.chart(chart, "Every occupancy"));
  std::vector<Html> speed_charts;
  if (const std::string chart = speed_chart(scene); !chart.empty())
    speed_charts.push_back(page.chart(chart, "Speed against " + scene.reference));
  Rows tables;
  for (const double occupancy : scene.occupancies) {
    Rows rows = table_rows(page, occupancy);
    auto folded = folded_rows(rows.size());
    const bool unfold = !folded.empty();
    tables.push_back({{"occupancy", occupancy_title(occupancy)},
                      {"folded", std::move(folded)},
                      {"unfold", unfold},
                      {"rows", std::move(rows)}});
  }
  return fill_template(page_file("cost.html"), {{"metric", metric_title(scene.run->headline)},
                                                {"heading", short_title(scene.run->headline)},
                                                {"reference", scene.reference},
                                                {"fewer", fewer_curves(scene, shown)},
                                                {"frame_rates", !scene.run->software},
                                                {"time_charts", html_rows(std::move(time_charts))},
                                                {"speed_charts", html_rows(std::move(speed_charts))},
                                                {"crossovers", crossovers(page)},
                                                {"tables", std::move(tables)}});
}

}  // namespace crowdbench::reports
