#include "reports/exports/side_markdown.h"

#include <fmt/format.h>

#include "reports/exports/markdown_cell.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {

std::string side_markdown(const SideBySide& sides) {
  if (sides.files.size() < 2) return {};
  std::string out =
      "# The files beside each other\n\nRatios to the reference that was drawn in the same rounds, each file by its "
      "own: "
      "times of different runs are not compared.\n";
  if (sides.groups.empty())
    out +=
        "\nNo two of them have a point of the same scenario, character, picture size, representation, crowd and "
        "occupancy.\n";
  for (const SideGroup& group : sides.groups) {
    out += fmt::format("\n## {}, {} × {} pixels, scenario “{}”\n\n| representation | agents | occupancy |",
                       markdown_cell(group.scene->character), group.scene->width, group.scene->height,
                       markdown_cell(group.scene->run->scenario_name));
    std::string rule = "\n|---|--:|--:|";
    for (const std::string& file : sides.files) {
      out += fmt::format(" {}: times as fast as {} |", markdown_cell(file), markdown_cell(group.scene->reference));
      rule += "--:|";
    }
    out += rule + "\n";
    for (const SideRow& row : group.rows) {
      out += fmt::format("| {} | {} | {} |", markdown_cell(row.representation), count_text(row.agents),
                         occupancy_text(row.occupancy));
      for (const SideCell& cell : row.cells)
        out += fmt::format(" {}{} |", side_text(cell), cell.scores.empty() ? "" : "; " + markdown_cell(cell.scores));
      out += "\n";
    }
  }
  return out + "\n";
}

}  // namespace crowdbench::reports
