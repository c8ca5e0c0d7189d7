#include "reports/page/history_page.h"

#include <fmt/format.h>

#include "reports/charts/history_chart.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {

std::string history_page(const std::vector<HistorySeries>& all, const std::string& method) {
  std::vector<TemplateValues> changes;
  std::vector<Html> charts;
  for (const HistorySeries& series : all) {
    const std::string name = series_name(series);
    for (const HistoryChange& change : series.changes)
      changes.push_back(
          {{"point", name},
           {"revision", change.revision},
           {"before", change.revision_before},
           {"started", change.started},
           {"change", fmt::format("{:+.1f} %", 100 * (change.point.mean_after / change.point.mean_before - 1))},
           {"p", fmt::format("{:.2g}", change.point.p)}});
    charts.push_back(chart_block(history_chart(series), name, static_cast<int>(charts.size()) + 1));
  }
  const bool any = !changes.empty();
  std::vector<TemplateValues> table;
  if (any) table.push_back({{"rows", std::move(changes)}});
  Html content =
      fill_template(page_file("history_page.html"),
                    {{"method", method}, {"changes", std::move(table)}, {"charts", html_rows(std::move(charts))}});
  return page_frame("What runs took over time", std::move(content), "");
}

}  // namespace crowdbench::reports
