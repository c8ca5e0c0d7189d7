#include "bench/stage/scenario_display.h"

#include <fmt/format.h>

#include <map>
#include <string_view>

#include "core/error.h"
#include "core/json.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {
namespace {

// The keys of [display] that are given, under ColorVideoVDP's names, as metrics/display.h reads them.
Json display_keys(const scene::DisplaySettings& settings) {
  Json given = Json::object();
  scene::Scenario holder;
  holder.display = settings;
  const Json all = scene::table_json(holder, "display");
  for (const scene::Key& key : scene::scenario_keys())
    if (key.table == "display" && !std::holds_alternative<std::monostate>(key.get(holder, 0)))
      given[key.name] = all.at(key.name);
  return given;
}

}  // namespace

metrics::ChosenDisplay display_of_scenario(const scene::Scenario& scenario, const std::filesystem::path& folder,
                                           const scene::KeyPlaces& given) {
  const scene::DisplaySettings& settings = scenario.display;
  if (settings == scene::DisplaySettings{}) return {};
  std::map<std::string, std::string> places;
  std::string first;
  for (const auto& [key, place] : given) {
    constexpr std::string_view kTable = "display.";
    if (!key.starts_with(kTable)) continue;
    places[key.substr(kTable.size())] = fmt::format("{}: `{}`", place, key);
    if (first.empty()) first = place + ": `display`";
  }
  if (!settings.model)
    return {metrics::parse_displays(display_keys(settings).dump(), first, "scenario", places).front(), true};
  scene::DisplaySettings alone;
  alone.model = settings.model;
  if (settings != alone)
    throw Error(places["model"], "a model and keys of a display of its own are both given", "keep one of them");
  const bool file = settings.model->find(".json") != std::string::npos;
  return {metrics::display_of(file ? (folder / *settings.model).string() : *settings.model, places["model"]), true};
}

}  // namespace crowdbench::bench
