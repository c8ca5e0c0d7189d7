// Scenarios within other documents: a plan of a sweep holds one, and changes it key by key.
#pragma once
#include <functional>
#include <string>

#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/toml_document.h"

namespace crowdbench::scene {

// Puts the keys of a table, which are those of a scenario, into one; check_scenario() is left to the caller. not_ours:
// the name of an entry to pass over. Throws Error naming file and line.
void change_scenario(Scenario& scenario, const TomlNode& changes, const std::string& where, KeyPlaces* places = nullptr,
                     const std::string& not_ours = {});
// One value as its key's type. Throws Error naming file, line, key and what is taken.
KeyValue read_key(const Key& key, const TomlNode& value, const std::string& where);
// What no single key can know. place: where a key or table of the top level was given. Throws Error.
void check_scenario(const Scenario& scenario, const std::function<std::string(const char* key)>& place);

}  // namespace crowdbench::scene
