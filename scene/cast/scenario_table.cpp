#include "scene/cast/scenario_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/open_character.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_changes.h"

namespace crowdbench::scene {
namespace {

// What a base file names is seen from its own folder; here from the plan's.
void move_paths(Scenario& scenario, const std::filesystem::path& base_folder) {
  if (base_folder.empty()) return;
  const auto moved = [&](std::string& name) {
    if (!is_built_in(name) && std::filesystem::path(name).is_relative())
      name = (base_folder / name).lexically_normal().string();
  };
  for (CharacterEntry& character : scenario.characters) {
    moved(character.source);
    for (std::string& file : character.animations) moved(file);
  }
  if (scenario.display.model && scenario.display.model->find(".json") != std::string::npos)
    moved(*scenario.display.model);
}

}  // namespace

void change_by_table(Scenario& scenario, const TomlNode& table, const std::string& where,
                     const std::filesystem::path& folder, KeyPlaces* places, const std::string& not_ours) {
  TomlNode rest = table;
  const TomlNode* const base = table.find("base");
  if (base != nullptr) {
    if (!base->is_text() || base->text.empty())
      throw Error(base->place(where), fmt::format("`base` is {}", base->type_name()), "name a scenario file");
    const std::filesystem::path file = folder / base->text;
    std::error_code failed;
    if (!std::filesystem::is_regular_file(file, failed))
      throw Error(base->place(where), fmt::format("`base`: there is no file '{}'", printable(file.string())),
                  "its path is seen from the plan's folder");
    TomlNode document = parse_toml(read_text(file, kScenarioBytes), file.string());
    document.line = 1;
    change_scenario(scenario, document, file.string(), places);
    move_paths(scenario, std::filesystem::path(base->text).parent_path());
    std::erase_if(rest.table, [](const TomlNode::Entry& entry) { return entry.first == "base"; });
  }
  change_scenario(scenario, rest, where, places, not_ours);
}

}  // namespace crowdbench::scene
