#include "reports/model/sweep_settings.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/short_numbers.h"

namespace crowdbench::reports {

// A file's text may be anything.
SweepSettings::Values SweepSettings::values_of(const SweepPointRow& row) {
  Values out;
  const auto settings = nlohmann::ordered_json::parse(row.settings, nullptr, false);
  if (!settings.is_object()) return out;
  for (const auto& [axis, value] : settings.items())
    if (value.is_string() && axis != "representation") out.emplace_back(axis, value.get<std::string>());
  return out;
}

SweepSettings::SweepSettings(const StoreContents& contents) {
  std::map<std::string, std::set<std::string>> all;
  for (const SweepPointRow& row : contents.sweep_points) {
    Values values = values_of(row);
    for (const auto& [axis, value] : values) all[axis].insert(value);
    if (row.measurement) by_measurement_[*row.measurement] = std::move(values);
  }
  for (const auto& [axis, texts] : all) texts_[axis] = short_numbers(texts);
}

std::string SweepSettings::text_of(const Values& values) const {
  std::string out;
  for (const auto& [axis, value] : values) {
    const auto of = texts_.find(axis);
    const bool known = of != texts_.end() && of->second.contains(value);
    out += (out.empty() ? "" : ", ") + axis + " = " + (known ? of->second.at(value) : value);
  }
  return out;
}

std::string SweepSettings::of_point(const SweepPointRow& row) const { return text_of(values_of(row)); }

std::string SweepSettings::of_scene(const Scene& scene) const {
  Values common;
  bool first = true;
  for (const MeasurementRow* row : scene.rows) {
    const auto found = by_measurement_.find(row->id);
    if (found == by_measurement_.end()) continue;
    const Values& values = found->second;
    if (first) common = values;
    first = false;
    std::erase_if(common,
                  [&](const auto& one) { return std::find(values.begin(), values.end(), one) == values.end(); });
  }
  return text_of(common);
}

std::vector<UndrawnPoints> undrawn_points(const StoreContents& contents) {
  const SweepSettings all(contents);
  std::vector<UndrawnPoints> out;
  for (const SweepPointRow& row : contents.sweep_points) {
    if (row.state == "done" || row.role == "aa") continue;
    auto place = std::find_if(out.begin(), out.end(), [&](const UndrawnPoints& one) {
      return one.state == row.state && one.reason == row.reason;
    });
    if (place == out.end()) place = out.insert(out.end(), {row.state, row.reason, 0, {}});
    const std::string settings = all.of_point(row);
    if (place->count++ < kUndrawnNamed)
      place->some.push_back(row.representation + (settings.empty() ? "" : ", " + settings));
  }
  return out;
}

}  // namespace crowdbench::reports
