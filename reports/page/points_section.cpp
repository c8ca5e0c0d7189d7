#include "reports/page/points_section.h"

#include <fmt/format.h>

#include <map>

#include "reports/model/number_text.h"
#include "reports/model/scores.h"
#include "reports/model/sweep_settings.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {
namespace {

// By point, of those that were compared.
using Comparisons = std::map<PointKey, const ComparisonRow*>;

Comparisons comparisons_of(const Scene& scene) {
  Comparisons out;
  for (const ComparisonRow* row : scene.crowd_comparisons)
    out[{row->representation, row->character, row->agents, scene.width, scene.height, row->requested_occupancy}] = row;
  return out;
}

// What sets a scene apart: its axes' values where a sweep made it, else its scenario.
using Settings = std::map<int64_t, std::string>;  // by measurement
Settings settings_of(const StoreContents& contents) {
  Settings out;
  const SweepSettings all(contents);
  for (const SweepPointRow& row : contents.sweep_points)
    if (std::string text = row.measurement ? all.of_point(row) : ""; !text.empty())
      out[*row.measurement] = std::move(text);
  return out;
}

}  // namespace

Html points_section(const StoreContents& contents, const std::vector<Scene>& scenes) {
  if (scenes.size() <= kScenesInFull) return {};
  const Settings settings = settings_of(contents);
  std::vector<TemplateValues> rows;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const Scene& scene = scenes[s];
    const Comparisons comparisons = comparisons_of(scene);
    for (const MeasurementRow* row : scene.rows) {
      const auto setting = settings.find(row->id);
      const RatioRow* ratio = scene.ratio("speed", row->key.representation, row->key.agents,
                                          row->key.requested_occupancy, scene.run->headline);
      const auto comparison = comparisons.find(row->key);
      const auto& time = time_of(*row, scene.run->headline);
      const bool timed = time && is_timed(*row);
      rows.push_back(
          {{"number", count_text(s + 1)},
           {"scene", setting != settings.end() ? setting->second : scene.character + ", " + scene.run->scenario_name},
           {"representation", row->key.representation},
           {"agents", count_text(row->key.agents)},
           {"occupancy", occupancy_text(row->key.requested_occupancy)},
           {"time", timed ? time_text(time->median) : std::string(status_name(row->status))},
           {"fast", ratio != nullptr ? factor_text(ratio->ratio) + "× (" + factor_text(ratio->low) + " to " +
                                           factor_text(ratio->high) + ")"
                                     : "–"},
           {"scores", comparison != comparisons.end() ? headline_scores(scene, *comparison->second) : "–"}});
    }
  }
  const std::string count = count_text(rows.size());
  return fill_template(page_file("points.html"), {{"scenes", count_text(scenes.size())},
                                                  {"shown", count_text(kScenesInFull)},
                                                  {"reference", scenes.front().reference},
                                                  {"count", count},
                                                  {"rows", std::move(rows)}});
}

Html undrawn_section(const StoreContents& contents) {
  const std::vector<UndrawnPoints> all = undrawn_points(contents);
  if (all.empty()) return {};
  std::vector<TemplateValues> rows;
  for (const UndrawnPoints& one : all) {
    std::vector<TemplateValues> some;
    for (const std::string& name : one.some) some.push_back({{"point", name}});
    if (one.count > one.some.size())
      some.push_back({{"point", fmt::format("{} more", count_text(one.count - one.some.size()))}});
    rows.push_back(
        {{"count", count_text(one.count)}, {"state", one.state}, {"reason", one.reason}, {"points", std::move(some)}});
  }
  return fill_template(page_file("undrawn.html"), {{"rows", std::move(rows)}});
}

}  // namespace crowdbench::reports
