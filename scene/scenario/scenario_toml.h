// Scenario files, read.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "scene/scenario/scenario.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/toml_document.h"

namespace crowdbench::scene {

// Where each key that a file gives stands, "plaza.toml:7" by "crowd.agents": for faults that only those find who use
// the value. The keys of lists have their index: "character[1].clips".
using KeyPlaces = std::map<std::string, std::string>;
std::string key_place(const std::string& table, const std::string& key, size_t index = 0);

// Parses a scenario. Unknown keys name the nearest known one; every fault names file and line. Throws Error; hostile
// text (deep nesting, more than 256 KiB, invalid UTF-8) is refused the same way.
Scenario parse_scenario(const std::string& toml, const std::string& where, KeyPlaces* places = nullptr);
Scenario load_scenario(const std::filesystem::path& path, KeyPlaces* places = nullptr);

// ---- for documents that hold a scenario among other things

// Puts the keys of a table, which are those of a scenario, into one. not_ours: the name of an entry to pass over.
// Throws Error naming file and line.
void change_scenario(Scenario& scenario, const TomlNode& changes, const std::string& where, KeyPlaces* places = nullptr,
                     const std::string& not_ours = {});
// One value as its key's type. Throws Error naming file, line, key and what is taken.
KeyValue read_key(const Key& key, const TomlNode& value, const std::string& where);
// What no single key can know. place: where a key or table of the top level was given. Throws Error.
void check_scenario(const Scenario& scenario, const std::function<std::string(const char* key)>& place);

}  // namespace crowdbench::scene
