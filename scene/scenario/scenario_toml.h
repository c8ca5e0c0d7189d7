// Scenario files, read.
#pragma once
#include <filesystem>
#include <string>

#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// Parses a scenario. Unknown keys name the nearest known one; every fault names file and line. Throws Error; hostile
// text (deep nesting, more than 256 KiB, invalid UTF-8) is refused the same way.
Scenario parse_scenario(const std::string& toml, const std::string& where);
Scenario load_scenario(const std::filesystem::path& path);

}  // namespace crowdbench::scene
