#include "reports/model/sweep_settings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

namespace crowdbench::reports {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;  // by axis, in the plan's order

// A file's text may be anything.
Values values_of(const SweepPointRow& row) {
  Values out;
  const auto settings = nlohmann::ordered_json::parse(row.settings, nullptr, false);
  if (!settings.is_object()) return out;
  for (const auto& [axis, value] : settings.items())
    if (value.is_string() && axis != "representation") out.emplace_back(axis, value.get<std::string>());
  return out;
}

std::string text_of(const Values& values) {
  std::string out;
  for (const auto& [axis, value] : values) out += (out.empty() ? "" : ", ") + axis + " = " + value;
  return out;
}

}  // namespace

std::string settings_text(const SweepPointRow& row) { return text_of(values_of(row)); }

std::string settings_of_scene(const StoreContents& contents, const Scene& scene) {
  std::set<int64_t> measured;
  for (const MeasurementRow* row : scene.rows) measured.insert(row->id);
  Values common;
  bool first = true;
  for (const SweepPointRow& row : contents.sweep_points) {
    if (!row.measurement || !measured.contains(*row.measurement)) continue;
    const Values values = values_of(row);
    if (first) common = values;
    first = false;
    std::erase_if(common,
                  [&](const auto& one) { return std::find(values.begin(), values.end(), one) == values.end(); });
  }
  return text_of(common);
}

std::vector<UndrawnPoints> undrawn_points(const StoreContents& contents) {
  std::vector<UndrawnPoints> out;
  for (const SweepPointRow& row : contents.sweep_points) {
    if (row.state == "done" || row.role == "aa") continue;
    auto place = std::find_if(out.begin(), out.end(), [&](const UndrawnPoints& one) {
      return one.state == row.state && one.reason == row.reason;
    });
    if (place == out.end()) place = out.insert(out.end(), {row.state, row.reason, 0, {}});
    const std::string settings = settings_text(row);
    if (place->count++ < kUndrawnNamed)
      place->some.push_back(row.representation + (settings.empty() ? "" : ", " + settings));
  }
  return out;
}

}  // namespace crowdbench::reports
