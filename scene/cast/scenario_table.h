// A scenario within another document: keys of a scenario on top of a scenario file.
#pragma once
#include <filesystem>
#include <string>

#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/toml_document.h"

namespace crowdbench::scene {

// Puts a table with `base` and keys of a scenario into one; the paths of a base are seen from `folder` afterwards.
// not_ours: an entry that is not a key. Throws Error.
void change_by_table(Scenario& scenario, const TomlNode& table, const std::string& where,
                     const std::filesystem::path& folder, KeyPlaces* places = nullptr,
                     const std::string& not_ours = {});

}  // namespace crowdbench::scene
