#include "reports/page/side_section.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "reports/charts/side_chart.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

constexpr size_t kMostCharts = 12;  // of a group; the table has all of its points

std::vector<Html> charts_of(const SideBySide& sides, const SideGroup& group, int& last_chart) {
  std::vector<Html> out;
  std::set<std::pair<std::string, double>> met;
  for (const SideRow& row : group.rows) {
    if (out.size() >= kMostCharts || !met.emplace(row.representation, row.occupancy).second) continue;
    const std::string chart = side_chart(sides, group, row.representation, row.occupancy);
    if (!chart.empty())
      out.push_back(chart_block(chart, row.representation + ", " + occupancy_title(row.occupancy), ++last_chart));
  }
  return out;
}

TemplateValues group_values(const SideBySide& sides, const SideGroup& group, int& last_chart) {
  const Scene& scene = *group.scene;
  Rows heads;
  for (const std::string& file : sides.files) heads.push_back({{"file", file}});
  Rows rows;
  for (const SideRow& row : group.rows) {
    Rows cells;
    for (const SideCell& cell : row.cells) cells.push_back({{"speed", side_text(cell)}, {"scores", cell.scores}});
    rows.push_back({{"representation", row.representation},
                    {"agents", count_text(row.agents)},
                    {"occupancy", occupancy_text(row.occupancy)},
                    {"cells", std::move(cells)}});
  }
  return {{"character", scene.character}, {"width", scene.width},
          {"height", scene.height},       {"scenario", scene.run->scenario_name},
          {"reference", scene.reference}, {"charts", html_rows(charts_of(sides, group, last_chart))},
          {"heads", std::move(heads)},    {"rows", std::move(rows)}};
}

}  // namespace

Html side_section(const SideBySide& sides, int& last_chart) {
  if (sides.files.size() < 2) return {};
  Rows files;
  for (const std::string& file : sides.files) files.push_back({{"file", file}});
  Rows groups;
  for (const SideGroup& group : sides.groups) groups.push_back(group_values(sides, group, last_chart));
  return fill_template(page_file("sides.html"),
                       {{"files", std::move(files)}, {"none", groups.empty()}, {"groups", std::move(groups)}});
}

}  // namespace crowdbench::reports
