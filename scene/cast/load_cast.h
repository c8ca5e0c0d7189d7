// Loads the characters of a scenario.
#pragma once
#include <filesystem>

#include "scene/cast/cast.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// Loads every character of the scenario; `folder` resolves relative paths. Throws Error, which names the line of a
// clip's name where `places` has it.
Cast load_cast(const Scenario& scenario, const std::filesystem::path& folder = {}, const KeyPlaces& places = {});

}  // namespace crowdbench::scene
