#include <fmt/format.h>

#include "reports/charts/distance_chart.h"
#include "reports/page/blocks.h"
#include "reports/page/distance_page.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {

Html distance_section(const std::vector<DistanceScore>& scores, int& last_chart) {
  std::vector<Html> charts;
  std::vector<TemplateValues> rows;
  for (const DistanceScore& score : scores)
    for (const DistanceGraph& graph : score.graphs) {
      if (const std::string chart = distance_chart(score.doc, graph); !chart.empty())
        charts.push_back(chart_block(chart, fmt::format("{} by {}", heading(score.doc), graph.against), ++last_chart));
      for (const DistanceSeries& series : graph.series)
        for (const DistanceThresholdText& threshold : series.thresholds)
          rows.push_back({{"representation", series.representation},
                          {"score", score.doc.title},
                          {"value", fmt::format("{:g}", threshold.value)},
                          {"against", graph.against},
                          {"place", threshold.place}});
    }
  std::vector<TemplateValues> thresholds;
  if (!rows.empty()) thresholds.push_back({{"rows", std::move(rows)}});
  return fill_template(page_file("distance.html"),
                       {{"thresholds", std::move(thresholds)}, {"charts", html_rows(std::move(charts))}});
}

}  // namespace crowdbench::reports
