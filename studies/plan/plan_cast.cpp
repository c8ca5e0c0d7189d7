#include "studies/plan/plan_cast.h"

#include <fmt/format.h>

#include <set>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/load_cast.h"
#include "scene/cast/scenario_table.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/scenario_writer.h"
#include "scene/scenario/toml_document.h"

namespace crowdbench::studies {
namespace {

// Where a factor's level of that text stands; empty where there is no such factor.
std::string place_of_level(const scene::TomlNode& document, const std::string& where, const std::string& factor,
                           const std::string& text) {
  const scene::TomlNode* const factors = document.find("factors");
  const scene::TomlNode* const levels = factors == nullptr ? nullptr : factors->find(factor);
  if (levels == nullptr) return {};
  for (const scene::TomlNode& level : levels->list)
    if (level.is_text() && level.text == text) return level.place(where);
  return levels->place(where);
}

// Where the condition's characters and clips were named: by the scenario, or by the factor that replaces them.
scene::KeyPlaces places_of(const StudyPlan& plan, const StudyCondition& condition, const scene::TomlNode& document) {
  scene::KeyPlaces places;
  scene::Scenario scenario;
  if (const scene::TomlNode* const node = document.find("scenario"))
    scene::change_by_table(scenario, *node, plan.where, plan.folder, &places);
  for (size_t f = 0; f < plan.factors.size(); ++f) {
    const std::string& name = plan.factors[f].name;
    if (name != "character" && name != "clip") continue;
    const std::string place = place_of_level(document, plan.where, name, condition.levels[f].text);
    for (size_t c = 0; c < condition.scenario.characters.size(); ++c)
      places[scene::key_place("character", name == "clip" ? "clips" : "source", c)] = place;
  }
  return places;
}

void require_cast_of(const StudyPlan& plan, const StudyCondition& condition, const scene::TomlNode& document) {
  const scene::KeyPlaces places = places_of(plan, condition, document);
  try {
    scene::load_cast(condition.scenario, plan.folder, places);
  } catch (const Error& error) {
    for (const auto& [key, place] : places)
      if (error.where == place) throw;
    // What says no line itself is about a character: the built-in one has no file to be known by.
    const auto source = places.find(scene::key_place("character", "source"));
    throw Error(source == places.end() ? plan.where : source->second,
                fmt::format("{}: {}: {}", condition.name, error.where, error.wrong), error.advice);
  }
}

}  // namespace

void require_cast(const std::filesystem::path& file, const StudyPlan& plan) {
  const scene::TomlNode document = scene::parse_toml(read_text(file, scene::kScenarioBytes), plan.where);
  std::set<std::string> loaded;
  for (const StudyCondition& condition : plan.conditions) {
    scene::Scenario characters;
    characters.characters = condition.scenario.characters;
    characters.pose_rate = condition.scenario.pose_rate;
    if (loaded.insert(scene::to_toml(characters)).second) require_cast_of(plan, condition, document);
  }
}

}  // namespace crowdbench::studies
