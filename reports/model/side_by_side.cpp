#include "reports/model/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "reports/model/number_text.h"
#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

void add_scene(const Scene& scene, size_t file, size_t files, SideGroup& group) {
  group.metric[file] = scene.run->headline;
  for (const std::string& name : scene.representations)
    for (const double occupancy : scene.occupancies)
      for (const uint32_t agents : scene.agents) {
        SideCell cell;
        cell.ratio = scene.ratio("speed", name, agents, occupancy, scene.run->headline);
        for (const ComparisonRow* row : scene.crowd_comparisons)
          if (row->representation == name && row->agents == agents && row->requested_occupancy == occupancy)
            cell.scores = headline_scores(scene, *row);
        if (cell.ratio == nullptr && cell.scores.empty()) continue;
        auto row = std::ranges::find_if(group.rows, [&](const SideRow& one) {
          return one.representation == name && one.agents == agents && one.occupancy == occupancy;
        });
        if (row == group.rows.end())
          row = group.rows.insert(row, {name, agents, occupancy, std::vector<SideCell>(files)});
        row->cells[file] = std::move(cell);
      }
}

size_t files_of(const SideRow& row) {
  return static_cast<size_t>(std::ranges::count_if(
      row.cells, [](const SideCell& cell) { return cell.ratio != nullptr || !cell.scores.empty(); }));
}

}  // namespace

SideBySide side_by_side(const std::vector<Scene>& scenes) {
  SideBySide out;
  for (const Scene& scene : scenes)
    if (std::ranges::find(out.files, scene.source) == out.files.end()) out.files.push_back(scene.source);
  if (out.files.size() < 2) return {};
  std::map<std::tuple<std::string, std::string, int, int>, size_t> places;
  for (const Scene& scene : scenes) {
    const auto [place, fresh] =
        places.try_emplace({scene.likeness, scene.character, scene.width, scene.height}, out.groups.size());
    if (fresh) out.groups.push_back({&scene, {}, std::vector<std::string>(out.files.size())});
    const auto file = std::ranges::find(out.files, scene.source) - out.files.begin();
    add_scene(scene, static_cast<size_t>(file), out.files.size(), out.groups[place->second]);
  }
  for (SideGroup& group : out.groups) {
    std::erase_if(group.rows, [](const SideRow& row) { return files_of(row) < 2; });
    const auto order = [&](const SideRow& row) {
      const auto& names = group.scene->representations;
      return std::tuple(std::ranges::find(names, row.representation) - names.begin(), row.representation, row.occupancy,
                        row.agents);
    };
    std::ranges::sort(group.rows, {}, order);
  }
  std::erase_if(out.groups, [](const SideGroup& group) { return group.rows.empty(); });
  return out;
}

std::string side_text(const SideCell& cell) {
  if (cell.ratio == nullptr) return "–";
  return fmt::format("{}× ({} to {})", factor_text(cell.ratio->ratio), factor_text(cell.ratio->low),
                     factor_text(cell.ratio->high));
}

}  // namespace crowdbench::reports
