// The scenario parser: a TOML document (toml_document.h) held against the table of keys.
#include "scene/scenario/parse_scenario.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/files.h"
#include "scene/scenario/scenario_changes.h"

namespace crowdbench::scene {
namespace {

constexpr size_t kTextBytes = 1024;  // fits a line even when every byte is written as an escape
constexpr size_t kTextCount = 256;

std::string full_name(const std::string& table, const std::string& name) {
  return table.empty() ? name : table + "." + name;
}

const KeyTable* find_table(const std::string& name) {
  for (const KeyTable& table : scenario_tables())
    if (!table.name.empty() && table.name == name) return &table;
  return nullptr;
}

// Reads one value as its key's type; every fault names line, key, what was found and what is taken.
class Reader {
 public:
  Reader(std::string where, const Key& key) : where_(std::move(where)), key_(key) {}

  KeyValue read(const TomlNode& value) const {
    if (!key_.absent.empty() && value.is_text() && value.text == key_.absent) return {};
    switch (key_.type) {
      case KeyType::flag:
        if (!value.is_boolean()) wrong_type(value, "true or false");
        return value.boolean;
      case KeyType::integer: return integer(value);
      case KeyType::seed: return seed(value);
      case KeyType::number: return number(value);
      case KeyType::text: return text(value);
      case KeyType::choice: {
        if (!value.is_text()) wrong_type(value, one_of());
        const std::string& word = value.text;
        for (size_t i = 0; i < key_.words.size(); ++i)
          if (key_.words[i] == word) return static_cast<int64_t>(i);
        const std::string near = nearest_name(word, key_.words);
        fail(value, fmt::format("is `{}`, not {}", printable(word, 64), one_of()),
             near.empty() ? "choose one of them" : fmt::format("did you mean `{}`?", near));
      }
      case KeyType::colour: {
        if (!value.is_text()) wrong_type(value, "a colour like '#808080'");
        const std::string& hex = value.text;
        if (hex.size() != 7 || hex[0] != '#' || hex.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
          fail(value, fmt::format("is `{}`, not a colour", printable(hex, 64)), "write it like '#808080'");
        return hex;
      }
      case KeyType::vector: {
        if (!value.is_list() || value.list.size() != 3) wrong_type(value, "three numbers like [0.0, 1.6, 5.0]");
        glm::dvec3 vector;
        for (int i = 0; i < 3; ++i) vector[i] = number(value.list[static_cast<size_t>(i)]);
        return vector;
      }
      case KeyType::size: {
        if (!value.is_list() || value.list.size() != 2) wrong_type(value, "two integers like [1920, 1080]");
        std::array<int64_t, 2> size{};
        for (size_t i = 0; i < 2; ++i) size.at(i) = integer(value.list[i]);
        return size;
      }
      case KeyType::texts: {
        if (!value.is_list()) wrong_type(value, "a list of texts");
        if (value.list.size() > kTextCount)
          fail(value, fmt::format("has {} entries, more than {}", value.list.size(), kTextCount), "shorten it");
        std::vector<std::string> texts;
        for (const TomlNode& entry : value.list) texts.push_back(text(entry));
        return texts;
      }
    }
    return {};
  }

  [[noreturn]] void fail(const TomlNode& value, const std::string& wrong, const std::string& advice) const {
    throw Error(value.place(where_), fmt::format("`{}` {}", full_name(key_.table, key_.name), wrong), advice);
  }

 private:
  std::string one_of() const {
    std::string out = "one of ";
    for (size_t i = 0; i < key_.words.size(); ++i) out += (i ? ", " : "") + key_.words[i];
    return out;
  }

  [[noreturn]] void wrong_type(const TomlNode& value, const std::string& wanted) const {
    fail(value, fmt::format("is {}", value.type_name()),
         fmt::format("give {}{}", wanted, key_.absent.empty() ? "" : fmt::format(" or \"{}\"", key_.absent)));
  }

  void check_range(const TomlNode& value, double number, const std::string& shown) const {
    if (number >= key_.low && number <= key_.high) return;
    fail(
        value, fmt::format("is {}", shown),
        fmt::format("it must lie between {} and {}{}{}", key_.low, key_.high, key_.unit.empty() ? "" : " ", key_.unit));
  }

  int64_t integer(const TomlNode& value) const {
    if (!value.is_integer()) wrong_type(value, "an integer");
    const int64_t number = value.integer;
    check_range(value, static_cast<double>(number), fmt::format("{}", number));
    return number;
  }

  double number(const TomlNode& value) const {
    if (!value.is_number()) wrong_type(value, "a number");
    const double found = value.as_number();
    check_range(value, found, fmt::format("{}", found));
    return found;
  }

  uint64_t seed(const TomlNode& value) const {
    const char* advice = "give an integer from 0 to 18446744073709551615, in quotes above 9223372036854775807";
    if (value.is_integer() && value.integer >= 0) return static_cast<uint64_t>(value.integer);
    if (value.is_text()) {
      const std::string& digits = value.text;
      uint64_t number = 0;
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
      if (!digits.empty() && error == std::errc() && end == digits.data() + digits.size()) return number;
      fail(value, fmt::format("is `{}`", printable(digits, 64)), advice);
    }
    if (value.is_integer()) fail(value, fmt::format("is {}", value.integer), advice);
    fail(value, fmt::format("is {}", value.type_name()), advice);
  }

  std::string text(const TomlNode& value) const {
    if (!value.is_text()) wrong_type(value, key_.type == KeyType::texts ? "a list of texts" : "a text");
    const std::string& found = value.text;
    if (found.empty() || found.size() > kTextBytes)
      fail(value, fmt::format("has a text of {} bytes", found.size()), fmt::format("give 1 to {}", kTextBytes));
    if (found.find('\0') != std::string::npos) fail(value, "has a text with a zero byte", "remove it");
    return found;
  }

  std::string where_;
  const Key& key_;
};

class Parser {
 public:
  Parser(std::string where, Scenario& scenario, KeyPlaces* places)
      : where_(std::move(where)), scenario_(scenario), places_(places) {}

  void run(const TomlNode& document, const std::string& not_ours) {
    for (const auto& entry : document.table)
      if (entry.first != not_ours) take_entry("", entry, 0);
    const TomlNode* const camera = document.find("camera");
    if (camera != nullptr && camera->find("key") != nullptr && camera->table.size() > 1)
      throw Error(camera->place(where_), "`camera` has keys of its own and a path of [[camera.key]]",
                  "keep one of them");
  }

 private:
  void table(const std::string& name, const TomlNode& value, size_t index) {
    for (const TomlNode::Entry& entry : value.table) take_entry(name, entry, index);
  }

  void take_entry(const std::string& table, const TomlNode::Entry& entry, size_t index) {
    const auto& [name, value] = entry;
    if (const KeyTable* inner = find_table(full_name(table, name))) return open(*inner, value);
    const Key* key = nullptr;
    std::vector<std::string> known;
    for (const Key& candidate : scenario_keys()) {
      if (candidate.table != table) continue;
      known.push_back(candidate.name);
      if (candidate.name == name) key = &candidate;
    }
    if (key == nullptr) unknown(table, name, value, std::move(known));
    take(*key, value, index);
  }

  void take(const Key& key, const TomlNode& value, size_t index) {
    key.set(scenario_, index, Reader(where_, key).read(value));
    if (places_ != nullptr) (*places_)[key_place(key.table, key.name, index)] = value.place(where_);
  }

  void open(const KeyTable& inner, const TomlNode& entry) {
    if (!inner.short_for.empty() && entry.is_text()) {
      for (const Key& key : scenario_keys())
        if (key.table == inner.name && key.name == inner.short_for) take(key, entry, 0);
      return;
    }
    if (!inner.list) {
      if (!entry.is_table())
        throw Error(entry.place(where_), fmt::format("`{}` is {}", inner.name, entry.type_name()),
                    fmt::format("write it as a table: [{}]", inner.name));
      return table(inner.name, entry, 0);
    }
    const std::string advice = fmt::format("write each as a table of its own: [[{}]]", inner.name);
    if (!entry.is_list())
      throw Error(entry.place(where_), fmt::format("`{}` is {}", inner.name, entry.type_name()), advice);
    const auto& list = entry.list;
    const bool characters = inner.name == "character";
    const size_t limit = characters ? kScenarioCharacters : kScenarioCameraKeys;
    if (list.empty() || list.size() > limit)
      throw Error(entry.place(where_), fmt::format("`{}` has {} entries", inner.name, list.size()),
                  fmt::format("give 1 to {}", limit));
    if (characters)
      scenario_.characters.assign(list.size(), CharacterEntry{});
    else
      scenario_.camera.keys.assign(list.size(), Scenario{}.camera.keys.front());
    for (size_t i = 0; i < list.size(); ++i) {
      if (!list[i].is_table())
        throw Error(list[i].place(where_), fmt::format("`{}` holds {}", inner.name, list[i].type_name()), advice);
      table(inner.name, list[i], i);
    }
  }

  [[noreturn]] void unknown(const std::string& table, const std::string& name, const TomlNode& value,
                            std::vector<std::string> known) const {
    for (const KeyTable& inner : scenario_tables()) {
      const size_t dot = inner.name.rfind('.');
      const std::string parent = dot == std::string::npos ? "" : inner.name.substr(0, dot);
      if (!inner.name.empty() && parent == table)
        known.push_back(dot == std::string::npos ? inner.name : inner.name.substr(dot + 1));
    }
    std::string near = nearest_name(name, known);
    std::string advice = near.empty() ? "see `crowdbench schema --markdown`" : fmt::format("did you mean `{}`?", near);
    // A key that exists in another table is more often misplaced than misspelt.
    for (const Key& key : scenario_keys())
      if (key.name == name) advice = fmt::format("did you mean `{}`?", full_name(key.table, key.name));
    throw Error(value.place(where_), fmt::format("unknown key `{}`", printable(full_name(table, name), 100)), advice);
  }

  std::string where_;
  Scenario& scenario_;
  KeyPlaces* places_;
};

}  // namespace

std::string key_place(const std::string& table, const std::string& key, size_t index) {
  const KeyTable* const owner = find_table(table);
  return owner != nullptr && owner->list ? fmt::format("{}[{}].{}", table, index, key) : full_name(table, key);
}

void check_scenario(const Scenario& scenario, const std::function<std::string(const char* key)>& place) {
  const std::vector<CameraKey>& keys = scenario.camera.keys;
  for (size_t i = 0; i < keys.size(); ++i) {
    const Camera& camera = keys[i].camera;
    const std::string which = keys.size() > 1 ? fmt::format("camera key {}", i + 1) : "camera";
    if (camera.eye == camera.target)
      throw Error(place("camera"), which + " looks at its own place", "move `eye` or `target`");
    if (glm::length(camera.up) == 0) throw Error(place("camera"), which + " has an `up` of length 0", "try [0, 1, 0]");
    if (camera.far != 0 && camera.far <= camera.near)
      throw Error(place("camera"), fmt::format("{} has far {} before near {}", which, camera.far, camera.near),
                  "give a larger `far`, or 0 for infinity");
    if (i > 0 && keys[i].time <= keys[i - 1].time)
      throw Error(place("camera"), fmt::format("{} at {} s does not follow the one before", which, keys[i].time),
                  "order the keys by time");
  }
  if (glm::length(scenario.light.direction) == 0)
    throw Error(place("light"), "`light.direction` has length 0", "try [0.4, 0.8, 0.45]");
  const Antialiasing& antialiasing = scenario.antialiasing;
  if (std::popcount(static_cast<unsigned>(antialiasing.samples)) != 1)
    throw Error(place("samples"), fmt::format("`samples` is {}", antialiasing.samples), "choose 1, 2, 4 or 8");
  if (antialiasing.supersample % 2 == 0)
    throw Error(place("supersample"), fmt::format("`supersample` is {}", antialiasing.supersample),
                "choose 1, 3, 5, 7 or 9");
  const CrowdSettings& crowd = scenario.crowd;
  if (crowd.stage_far < crowd.stage_near)
    throw Error(place("crowd"), "`crowd.stage_far` is before `crowd.stage_near`", "exchange them");
  if (crowd.motion == MotionKind::lanes && crowd.stage != Stage::plaza)
    throw Error(place("crowd"), "`motion = \"lanes\"` needs `stage = \"plaza\"`", "choose another motion or stage");
}

KeyValue read_key(const Key& key, const TomlNode& value, const std::string& where) {
  return Reader(where, key).read(value);
}

void change_scenario(Scenario& scenario, const TomlNode& changes, const std::string& where, KeyPlaces* places,
                     const std::string& not_ours) {
  Parser(where, scenario, places).run(changes, not_ours);
}

Scenario parse_scenario(const std::string& toml, const std::string& where, KeyPlaces* places) {
  Scenario scenario;
  TomlNode document = parse_toml(toml, where);
  document.line = 1;
  change_scenario(scenario, document, where, places);
  check_scenario(scenario, [&](const char* name) {
    const TomlNode* const given = document.find(name);
    return (given != nullptr ? *given : document).place(where);
  });
  return scenario;
}

Scenario load_scenario(const std::filesystem::path& path, KeyPlaces* places) {
  return parse_scenario(read_text(path, kScenarioBytes), path.string(), places);
}

}  // namespace crowdbench::scene
