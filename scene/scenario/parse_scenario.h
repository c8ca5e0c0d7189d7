// Scenario files, read.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// Where each key that a file gives stands, "plaza.toml:7" by "crowd.agents": for faults that only those find who use
// the value. The keys of lists have their index: "character[1].clips".
using KeyPlaces = std::map<std::string, std::string>;
std::string key_place(const std::string& table, const std::string& key, size_t index = 0);

// Parses a scenario. Unknown keys name the nearest known one; every fault names file and line. Throws Error; hostile
// text (deep nesting, more than 256 KiB, invalid UTF-8) is refused the same way.
Scenario parse_scenario(const std::string& toml, const std::string& where, KeyPlaces* places = nullptr);
Scenario load_scenario(const std::filesystem::path& path, KeyPlaces* places = nullptr);

}  // namespace crowdbench::scene
