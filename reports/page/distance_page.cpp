#include "reports/page/distance_page.h"

#include <fmt/format.h>

#include <utility>

#include "reports/charts/distance_chart.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {

std::string distance_page(const DistancePage& page) {
  std::vector<Html> charts;
  std::vector<TemplateValues> rows;
  for (const DistanceScore& score : page.scores)
    for (const DistanceGraph& graph : score.graphs) {
      if (const std::string chart = distance_chart(score.doc, graph); !chart.empty())
        charts.push_back(chart_block(chart, fmt::format("{} by {}", heading(score.doc), graph.against),
                                     static_cast<int>(charts.size()) + 1));
      for (const DistanceSeries& series : graph.series)
        for (const DistanceThresholdText& threshold : series.thresholds)
          rows.push_back({{"representation", series.representation},
                          {"score", score.doc.title},
                          {"value", fmt::format("{:g}", threshold.value)},
                          {"against", graph.against},
                          {"place", threshold.place}});
    }
  std::vector<TemplateValues> cause_rows;
  for (const auto& [representation, words] : page.causes)
    cause_rows.push_back({{"representation", representation}, {"words", words}});
  std::vector<TemplateValues> causes;
  if (!cause_rows.empty()) causes.push_back({{"rows", std::move(cause_rows)}});
  std::vector<TemplateValues> thresholds;
  if (!rows.empty()) thresholds.push_back({{"rows", std::move(rows)}});
  Html content = fill_template(page_file("distance_page.html"), {{"scene", page.scene},
                                                                 {"reference", page.reference},
                                                                 {"counts", page.counts},
                                                                 {"renderer", page.renderer},
                                                                 {"display", page.display},
                                                                 {"thresholds", std::move(thresholds)},
                                                                 {"causes", std::move(causes)},
                                                                 {"charts", html_rows(std::move(charts))}});
  return page_frame("Difference over distance", std::move(content), "");
}

}  // namespace crowdbench::reports
