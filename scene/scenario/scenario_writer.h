// A scenario as TOML, and what describes scenario files to people and editors; all from the table of keys.
#pragma once
#include <string>

#include "core/json.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// The TOML text that parses to the same scenario, every key written.
std::string to_toml(const Scenario& scenario);
// One table of it ("crowd", "camera": the first view, ...) as a JSON object, every key written, in the units of the
// TOML.
Json table_json(const Scenario& scenario, const std::string& table);
// JSON Schema (draft 2020-12) of the scenario, made from the same table of keys as the parser.
std::string scenario_schema();
// The same table as Markdown, one row a key: name, type, default, unit, range, meaning.
std::string scenario_markdown();

}  // namespace crowdbench::scene
