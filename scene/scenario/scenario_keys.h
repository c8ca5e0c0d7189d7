// The one table of scenario keys that the parser, to_toml, the JSON Schema and the Markdown table are made from.
#pragma once
#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <variant>
#include <vector>

#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

enum class KeyType : uint8_t {
  flag,     // bool
  integer,  // int64_t
  seed,     // uint64_t: a TOML integer, or decimal digits in quotes above 2^63 - 1
  number,   // double; integers are taken too
  text,     // std::string, 1 to 1024 bytes
  choice,   // one of `words`, kept as its position in int64_t
  colour,   // '#rrggbb' as std::string
  vector,   // three numbers, glm::dvec3
  size,     // two integers, [width, height], std::array<int64_t, 2>
  texts     // a list of at most 256 texts
};

// std::monostate is the word in `Key::absent`.
using KeyValue = std::variant<std::monostate, bool, int64_t, uint64_t, double, std::string, glm::dvec3,
                              std::array<int64_t, 2>, std::vector<std::string>>;

struct Key {
  std::string table;  // "", "crowd", "camera", "camera.key", "character", "light", "display"
  std::string name;
  KeyType type = KeyType::number;
  std::string unit;  // empty where there is none
  double low = 0;    // range of integers, numbers and of each number of a vector or size, inclusive
  double high = 0;
  std::vector<std::string> words;  // of a choice
  std::string absent;              // a word that stands for "none of these" ("as_is"); empty where there is none
  std::string meaning;
  // `index`: which character or camera key; 0 elsewhere.
  std::function<KeyValue(const Scenario&, size_t index)> get;
  std::function<void(Scenario&, size_t index, const KeyValue&)> set;
};

struct KeyTable {
  std::string name;   // "" for the top level
  bool list = false;  // [[name]]
  std::string meaning;
  std::string short_for;  // the key that a text in the table's place is: display = "standard_fhd"; empty: none
};

// In the order in which they are written and documented.
const std::vector<KeyTable>& scenario_tables();
const std::vector<Key>& scenario_keys();

// A value as TOML text. Numbers are the shortest that read back as the same double.
std::string toml_value(const Key& key, const KeyValue& value);

inline constexpr size_t kScenarioBytes = size_t{256} << 10;  // more text than this is refused
inline constexpr size_t kScenarioCharacters = 256;
inline constexpr size_t kScenarioCameraKeys = 1000;

}  // namespace crowdbench::scene
