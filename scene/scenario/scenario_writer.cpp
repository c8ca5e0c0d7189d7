// What is written from the table of keys: TOML text, the JSON Schema and the Markdown table.
#include "scene/scenario/scenario_writer.h"

#include <fmt/format.h>

#include "core/json.h"
#include "scene/scenario/scenario_keys.h"

namespace crowdbench::scene {
namespace {

std::string header(const KeyTable& table) {
  return table.list ? fmt::format("[[{}]]", table.name) : fmt::format("[{}]", table.name);
}

size_t entries(const Scenario& scenario, const std::string& table) {
  if (table == "character") return scenario.characters.size();
  // One view at time 0 is a plain [camera].
  const bool path = scenario.camera.keys.size() > 1 || scenario.camera.keys.front().time != 0;
  if (table == "camera.key") return path ? scenario.camera.keys.size() : 0;
  if (table == "camera") return path ? 0 : 1;
  return 1;
}

// JSON numbers that are whole print as integers, which is what a reader of the schema expects of a range.
Json number(double value) {
  if (value >= 0 && value < 9.2e18 && value == static_cast<double>(static_cast<uint64_t>(value)))
    return static_cast<uint64_t>(value);
  if (value > -9e15 && value < 0 && value == static_cast<double>(static_cast<int64_t>(value)))
    return static_cast<int64_t>(value);
  return value;
}

Json json_value(const Key& key, const KeyValue& value) {
  struct Writer {
    const Key& key;
    Json operator()(std::monostate) const { return key.absent; }
    Json operator()(bool v) const { return v; }
    Json operator()(int64_t v) const {
      return key.type == KeyType::choice ? Json(key.words[static_cast<size_t>(v)]) : Json(v);
    }
    Json operator()(uint64_t v) const { return v; }
    Json operator()(double v) const { return v; }
    Json operator()(const std::string& v) const { return v; }
    Json operator()(const glm::dvec3& v) const { return {v.x, v.y, v.z}; }
    Json operator()(const std::array<int64_t, 2>& v) const { return {v[0], v[1]}; }
    Json operator()(const std::vector<std::string>& v) const { return v; }
  };
  return std::visit(Writer{key}, value);
}

Json value_schema(const Key& key) {
  Json bounded = {{"type", "number"}, {"minimum", number(key.low)}, {"maximum", number(key.high)}};
  switch (key.type) {
    case KeyType::flag: return {{"type", "boolean"}};
    case KeyType::integer: return {{"type", "integer"}, {"minimum", number(key.low)}, {"maximum", number(key.high)}};
    case KeyType::seed:
      return {{"anyOf", {{{"type", "integer"}, {"minimum", 0}}, {{"type", "string"}, {"pattern", "^[0-9]{1,20}$"}}}}};
    case KeyType::number: return bounded;
    case KeyType::text: return {{"type", "string"}, {"minLength", 1}};
    case KeyType::choice: return {{"type", "string"}, {"enum", key.words}};
    case KeyType::colour: return {{"type", "string"}, {"pattern", "^#[0-9a-fA-F]{6}$"}};
    case KeyType::vector: return {{"type", "array"}, {"items", bounded}, {"minItems", 3}, {"maxItems", 3}};
    case KeyType::size:
      bounded["type"] = "integer";
      return {{"type", "array"}, {"items", bounded}, {"minItems", 2}, {"maxItems", 2}};
    case KeyType::texts:
      return {{"type", "array"}, {"items", {{"type", "string"}, {"minLength", 1}}}, {"maxItems", 256}};
  }
  return {};
}

const char* type_text(KeyType type) {
  switch (type) {
    case KeyType::flag: return "true or false";
    case KeyType::integer:
    case KeyType::seed: return "integer";
    case KeyType::number: return "number";
    case KeyType::text: return "text";
    case KeyType::choice: return "word";
    case KeyType::colour: return "colour";
    case KeyType::vector: return "three numbers";
    case KeyType::size: return "two integers";
    case KeyType::texts: return "list of texts";
  }
  return "";
}

std::string range_text(const Key& key) {
  std::string text;
  switch (key.type) {
    case KeyType::integer:
    case KeyType::number: text = fmt::format("{} to {}", key.low, key.high); break;
    case KeyType::seed: text = "0 to 18446744073709551615"; break;
    case KeyType::size:
    case KeyType::vector: text = fmt::format("each {} to {}", key.low, key.high); break;
    case KeyType::colour: text = "'#000000' to '#ffffff'"; break;
    case KeyType::choice:
      for (const std::string& word : key.words) text += (text.empty() ? "`\"" : ", `\"") + word + "\"`";
      break;
    default: break;
  }
  if (!key.absent.empty()) text += fmt::format(" or `\"{}\"`", key.absent);
  return text;
}

Json table_schema(const KeyTable& table) {
  const Scenario defaults;
  Json properties = Json::object();
  for (const Key& key : scenario_keys()) {
    if (key.table != table.name) continue;
    Json schema = value_schema(key);
    if (!key.absent.empty()) schema = {{"anyOf", {schema, {{"const", key.absent}}}}};
    std::string description = key.meaning;
    if (!key.unit.empty()) description += fmt::format(" [{}]", key.unit);
    schema["description"] = description;
    schema["default"] = json_value(key, key.get(defaults, 0));
    properties[key.name] = schema;
  }
  Json object = {{"type", "object"}, {"description", table.meaning}, {"additionalProperties", false}};
  object["properties"] = properties;
  if (!table.short_for.empty()) return {{"anyOf", {object, properties[table.short_for]}}};
  if (!table.list) return object;
  const size_t most = table.name == "character" ? kScenarioCharacters : kScenarioCameraKeys;
  return {{"type", "array"}, {"minItems", 1}, {"maxItems", most}, {"items", object}};
}

}  // namespace

std::string to_toml(const Scenario& scenario) {
  std::string text;
  for (const KeyTable& table : scenario_tables()) {
    for (size_t i = 0; i < entries(scenario, table.name); ++i) {
      if (!table.name.empty()) text += fmt::format("\n{}\n", header(table));
      for (const Key& key : scenario_keys())
        if (key.table == table.name) text += fmt::format("{} = {}\n", key.name, toml_value(key, key.get(scenario, i)));
    }
  }
  return text;
}

Json table_json(const Scenario& scenario, const std::string& table) {
  Json object = Json::object();
  for (const Key& key : scenario_keys())
    if (key.table == table) object[key.name] = json_value(key, key.get(scenario, 0));
  return object;
}

std::string scenario_schema() {
  Json schema = table_schema(scenario_tables().front());
  Json all = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "crowdbench scenario"}};
  all.update(schema);
  for (const KeyTable& table : scenario_tables()) {
    if (table.name.empty()) continue;
    Json* parent = &all["properties"];
    std::string name = table.name;
    if (const size_t dot = name.find('.'); dot != std::string::npos) {
      parent = &(*parent)[name.substr(0, dot)]["properties"];
      name = name.substr(dot + 1);
    }
    (*parent)[name] = table_schema(table);
  }
  return all.dump(2) + "\n";
}

std::string scenario_markdown() {
  const Scenario defaults;
  std::string text;
  for (const KeyTable& table : scenario_tables()) {
    const std::string title = table.name.empty() ? "Top level" : fmt::format("`{}`", header(table));
    text +=
        fmt::format("{}### {}\n{}.\n\n| key | type | default | unit | range | meaning |\n|---|---|---|---|---|---|\n",
                    text.empty() ? "" : "\n", title, table.meaning);
    for (const Key& key : scenario_keys()) {
      if (key.table != table.name) continue;
      text += fmt::format("| `{}` | {} | `{}` | {} | {} | {} |\n", key.name, type_text(key.type),
                          toml_value(key, key.get(defaults, 0)), key.unit, range_text(key), key.meaning);
    }
  }
  return text;
}

}  // namespace crowdbench::scene
