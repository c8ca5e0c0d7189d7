// The scenario parser: toml11 behind a scan that refuses what would overflow its stack or confuse its lexer, then the
// table of keys. The only file that includes toml11.
#include "scene/scenario/scenario_toml.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <toml.hpp>

#include "core/error.h"
#include "core/files.h"
#include "scene/scenario/scenario_keys.h"

namespace crowdbench::scene {
namespace {

using Toml = toml::basic_value<toml::discard_comments, std::map, std::vector>;

constexpr int kDepth = 16;           // open brackets at once, outside of texts
constexpr int kDotsPerLine = 256;    // dotted keys nest without brackets
constexpr size_t kLineBytes = 8192;  // its time grows with the square of a line's length
constexpr size_t kTextBytes = 1024;  // fits a line even when every byte is written as an escape
constexpr size_t kTextCount = 256;

std::string at_line(const std::string& where, size_t line) { return fmt::format("{}:{}", where, line); }

size_t line_of(const Toml& value) { return std::max<size_t>(1, value.location().line()); }

// Length of the UTF-8 sequence at `at`, 0 when it is not one (overlong, surrogate, beyond U+10FFFF, cut off).
size_t utf8_length(const std::string& text, size_t at) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  const unsigned second = byte(at + 1);
  if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) || (first == 0xf0 && second < 0x90) ||
      (first == 0xf4 && second > 0x8f))
    return 0;
  return length;
}

// Refuses, with its line, what toml11 must not see: it recurses once a bracket and once a dot, and takes any byte.
void scan(const std::string& text, const std::string& where) {
  if (text.size() > kScenarioBytes)
    throw Error(where, fmt::format("is {} bytes, more than the limit of {}", text.size(), kScenarioBytes),
                "a scenario is a short text; is this the right file?");
  enum class In : uint8_t { plain, comment, basic, literal, basic_block, literal_block };
  In in = In::plain;
  int depth = 0;
  int dots = 0;
  size_t line = 1;
  size_t line_start = 0;
  for (size_t i = 0; i < text.size();) {
    const size_t length = utf8_length(text, i);
    const char c = text[i];
    const auto byte = static_cast<unsigned char>(c);
    if (length == 0) throw Error(at_line(where, line), "is not valid UTF-8", "save the file as UTF-8");
    const bool line_end = c == '\n' || (c == '\r' && i + 1 < text.size() && text[i + 1] == '\n');
    if ((byte < 0x20 && c != '\t' && !line_end) || byte == 0x7f)
      throw Error(at_line(where, line),
                  fmt::format("holds the control character 0x{:02x}", static_cast<unsigned>(byte)),
                  "remove it, or write it as \\u00XX inside double quotes");
    const bool triple = (c == '"' || c == '\'') && text.compare(i, 3, std::string(3, c)) == 0;
    size_t step = length;
    switch (in) {
      case In::plain:
        if (c == '#')
          in = In::comment;
        else if (triple) {
          in = c == '"' ? In::basic_block : In::literal_block;
          step = 3;
        } else if (c == '"')
          in = In::basic;
        else if (c == '\'')
          in = In::literal;
        else if (c == '[' || c == '{')
          ++depth;
        else if (c == ']' || c == '}')
          depth = std::max(0, depth - 1);
        else if (c == '.')
          ++dots;
        break;
      case In::basic:
        if (c == '\\') step = 2;
        if (c == '"' || line_end) in = In::plain;
        break;
      case In::literal:
        if (c == '\'' || line_end) in = In::plain;
        break;
      case In::basic_block:
        if (c == '\\') step = 2;
        if (c == '"' && triple) {
          in = In::plain;
          step = 3;
        }
        break;
      case In::literal_block:
        if (c == '\'' && triple) {
          in = In::plain;
          step = 3;
        }
        break;
      case In::comment: break;
    }
    if (depth > kDepth)
      throw Error(at_line(where, line), fmt::format("brackets nest deeper than {}", kDepth),
                  "no scenario key needs more than two");
    if (dots > kDotsPerLine)
      throw Error(at_line(where, line), fmt::format("has more than {} dots", kDotsPerLine), "break the line up");
    if (i - line_start > kLineBytes)
      throw Error(at_line(where, line), fmt::format("is longer than {} bytes", kLineBytes), "break the line up");
    if (c == '\\' && step == 2 && i + 1 < text.size()) {
      // The escaped byte may end a line or begin a longer character: both are looked at in their turn.
      if (text[i + 1] != '"' && text[i + 1] != '\\') step = 1;
    }
    if (c == '\n') {
      ++line;
      dots = 0;
      line_start = i;
      if (in == In::comment) in = In::plain;
    }
    i += step;
  }
}

// toml11 says "[error] toml::parse_x: what went wrong" and then several lines of source: the middle is what we want.
std::string first_line(const std::string& message) {
  std::string line = message.substr(0, message.find('\n'));
  if (const size_t at = line.rfind("toml::"); at != std::string::npos) {
    const size_t colon = line.find(": ", at);
    if (colon != std::string::npos) line = line.substr(colon + 2);
  }
  return line.empty() ? "is not TOML" : line;
}

Toml parse_toml(const std::string& text, const std::string& where) {
  std::istringstream stream(text);
  try {
    return toml::parse<toml::discard_comments, std::map, std::vector>(stream, where);
  } catch (const toml::exception& error) {
    const size_t lines = 1 + static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
    throw Error(at_line(where, std::clamp<size_t>(error.location().line(), 1, lines)), first_line(error.what()),
                "see https://toml.io for the syntax");
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {  // its lexer lets std::out_of_range and std::runtime_error through
    throw Error(where, first_line(error.what()), "see https://toml.io for the syntax");
  }
}

const char* type_name(const Toml& value) {
  switch (value.type()) {
    case toml::value_t::boolean: return "a truth value";
    case toml::value_t::integer: return "an integer";
    case toml::value_t::floating: return "a number";
    case toml::value_t::string: return "a text";
    case toml::value_t::array: return "a list";
    case toml::value_t::table: return "a table";
    default: return "a date or time";
  }
}

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

  KeyValue read(const Toml& value) const {
    if (!key_.absent.empty() && value.is_string() && value.as_string().str == key_.absent) return {};
    switch (key_.type) {
      case KeyType::flag:
        if (!value.is_boolean()) wrong_type(value, "true or false");
        return value.as_boolean();
      case KeyType::integer: return integer(value);
      case KeyType::seed: return seed(value);
      case KeyType::number: return number(value);
      case KeyType::text: return text(value);
      case KeyType::choice: {
        if (!value.is_string()) wrong_type(value, one_of());
        const std::string& word = value.as_string().str;
        for (size_t i = 0; i < key_.words.size(); ++i)
          if (key_.words[i] == word) return static_cast<int64_t>(i);
        const std::string near = nearest_name(word, key_.words);
        fail(value, fmt::format("is `{}`, not {}", printable(word, 64), one_of()),
             near.empty() ? "choose one of them" : fmt::format("did you mean `{}`?", near));
      }
      case KeyType::colour: {
        if (!value.is_string()) wrong_type(value, "a colour like '#808080'");
        const std::string& hex = value.as_string().str;
        if (hex.size() != 7 || hex[0] != '#' || hex.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
          fail(value, fmt::format("is `{}`, not a colour", printable(hex, 64)), "write it like '#808080'");
        return hex;
      }
      case KeyType::vector: {
        if (!value.is_array() || value.as_array().size() != 3) wrong_type(value, "three numbers like [0.0, 1.6, 5.0]");
        glm::dvec3 vector;
        for (int i = 0; i < 3; ++i) vector[i] = number(value.as_array()[static_cast<size_t>(i)]);
        return vector;
      }
      case KeyType::size: {
        if (!value.is_array() || value.as_array().size() != 2) wrong_type(value, "two integers like [1920, 1080]");
        std::array<int64_t, 2> size{};
        for (size_t i = 0; i < 2; ++i) size.at(i) = integer(value.as_array()[i]);
        return size;
      }
      case KeyType::texts: {
        if (!value.is_array()) wrong_type(value, "a list of texts");
        if (value.as_array().size() > kTextCount)
          fail(value, fmt::format("has {} entries, more than {}", value.as_array().size(), kTextCount), "shorten it");
        std::vector<std::string> texts;
        for (const Toml& entry : value.as_array()) texts.push_back(text(entry));
        return texts;
      }
    }
    return {};
  }

  [[noreturn]] void fail(const Toml& value, const std::string& wrong, const std::string& advice) const {
    throw Error(at_line(where_, line_of(value)), fmt::format("`{}` {}", full_name(key_.table, key_.name), wrong),
                advice);
  }

 private:
  std::string one_of() const {
    std::string out = "one of ";
    for (size_t i = 0; i < key_.words.size(); ++i) out += (i ? ", " : "") + key_.words[i];
    return out;
  }

  [[noreturn]] void wrong_type(const Toml& value, const std::string& wanted) const {
    fail(value, fmt::format("is {}", type_name(value)),
         fmt::format("give {}{}", wanted, key_.absent.empty() ? "" : fmt::format(" or \"{}\"", key_.absent)));
  }

  void check_range(const Toml& value, double number, const std::string& shown) const {
    if (number >= key_.low && number <= key_.high) return;
    fail(
        value, fmt::format("is {}", shown),
        fmt::format("it must lie between {} and {}{}{}", key_.low, key_.high, key_.unit.empty() ? "" : " ", key_.unit));
  }

  int64_t integer(const Toml& value) const {
    if (!value.is_integer()) wrong_type(value, "an integer");
    const int64_t number = value.as_integer();
    check_range(value, static_cast<double>(number), fmt::format("{}", number));
    return number;
  }

  double number(const Toml& value) const {
    if (!value.is_floating() && !value.is_integer()) wrong_type(value, "a number");
    const double found = value.is_integer() ? static_cast<double>(value.as_integer()) : value.as_floating();
    check_range(value, found, fmt::format("{}", found));
    return found;
  }

  uint64_t seed(const Toml& value) const {
    const char* advice = "give an integer from 0 to 18446744073709551615, in quotes above 9223372036854775807";
    if (value.is_integer() && value.as_integer() >= 0) return static_cast<uint64_t>(value.as_integer());
    if (value.is_string()) {
      const std::string& digits = value.as_string().str;
      uint64_t number = 0;
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
      if (!digits.empty() && error == std::errc() && end == digits.data() + digits.size()) return number;
      fail(value, fmt::format("is `{}`", printable(digits, 64)), advice);
    }
    if (value.is_integer()) fail(value, fmt::format("is {}", value.as_integer()), advice);
    fail(value, fmt::format("is {}", type_name(value)), advice);
  }

  std::string text(const Toml& value) const {
    if (!value.is_string()) wrong_type(value, key_.type == KeyType::texts ? "a list of texts" : "a text");
    const std::string& found = value.as_string().str;
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
  Parser(std::string where, KeyPlaces* places) : where_(std::move(where)), places_(places) {}

  Scenario run(const std::string& text) {
    scan(text, where_);
    const Toml document = parse_toml(text, where_);
    if (!document.is_table()) throw Error(where_, "is not a table of keys", "see `crowdbench schema --markdown`");
    table("", document, 0);
    check(document);
    return std::move(scenario_);
  }

 private:
  void table(const std::string& name, const Toml& value, size_t index) {
    for (const auto& [key_name, entry] : value.as_table()) {
      const std::string full = full_name(name, key_name);
      if (const KeyTable* inner = find_table(full)) {
        open(*inner, entry);
        continue;
      }
      const Key* key = nullptr;
      std::vector<std::string> known;
      for (const Key& candidate : scenario_keys()) {
        if (candidate.table != name) continue;
        known.push_back(candidate.name);
        if (candidate.name == key_name) key = &candidate;
      }
      if (key == nullptr) unknown(name, key_name, entry, std::move(known));
      take(*key, entry, index);
    }
  }

  void take(const Key& key, const Toml& value, size_t index) {
    key.set(scenario_, index, Reader(where_, key).read(value));
    if (places_ != nullptr) (*places_)[key_place(key.table, key.name, index)] = at_line(where_, line_of(value));
  }

  void open(const KeyTable& inner, const Toml& entry) {
    if (!inner.short_for.empty() && entry.is_string()) {
      for (const Key& key : scenario_keys())
        if (key.table == inner.name && key.name == inner.short_for) take(key, entry, 0);
      return;
    }
    if (!inner.list) {
      if (!entry.is_table())
        throw Error(at_line(where_, line_of(entry)), fmt::format("`{}` is {}", inner.name, type_name(entry)),
                    fmt::format("write it as a table: [{}]", inner.name));
      return table(inner.name, entry, 0);
    }
    const std::string advice = fmt::format("write each as a table of its own: [[{}]]", inner.name);
    if (!entry.is_array())
      throw Error(at_line(where_, line_of(entry)), fmt::format("`{}` is {}", inner.name, type_name(entry)), advice);
    const auto& list = entry.as_array();
    const bool characters = inner.name == "character";
    const size_t limit = characters ? kScenarioCharacters : kScenarioCameraKeys;
    if (list.empty() || list.size() > limit)
      throw Error(at_line(where_, line_of(entry)), fmt::format("`{}` has {} entries", inner.name, list.size()),
                  fmt::format("give 1 to {}", limit));
    if (characters)
      scenario_.characters.assign(list.size(), CharacterEntry{});
    else
      scenario_.camera.keys.assign(list.size(), Scenario{}.camera.keys.front());
    for (size_t i = 0; i < list.size(); ++i) {
      if (!list[i].is_table())
        throw Error(at_line(where_, line_of(list[i])), fmt::format("`{}` holds {}", inner.name, type_name(list[i])),
                    advice);
      table(inner.name, list[i], i);
    }
  }

  [[noreturn]] void unknown(const std::string& table, const std::string& name, const Toml& value,
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
    throw Error(at_line(where_, line_of(value)),
                fmt::format("unknown key `{}`", printable(full_name(table, name), 100)), advice);
  }

  // What no single key can know.
  void check(const Toml& document) const {
    const auto& top = document.as_table();
    const auto place = [&](const char* name) { return at_line(where_, top.count(name) ? line_of(top.at(name)) : 1); };
    if (top.count("camera")) {
      const auto& camera = top.at("camera").as_table();
      if (camera.count("key") && camera.size() > 1)
        throw Error(place("camera"), "`camera` has keys of its own and a path of [[camera.key]]", "keep one of them");
    }
    const std::vector<CameraKey>& keys = scenario_.camera.keys;
    for (size_t i = 0; i < keys.size(); ++i) {
      const Camera& camera = keys[i].camera;
      const std::string which = keys.size() > 1 ? fmt::format("camera key {}", i + 1) : "camera";
      if (camera.eye == camera.target)
        throw Error(place("camera"), which + " looks at its own place", "move `eye` or `target`");
      if (glm::length(camera.up) == 0)
        throw Error(place("camera"), which + " has an `up` of length 0", "try [0, 1, 0]");
      if (camera.far != 0 && camera.far <= camera.near)
        throw Error(place("camera"), fmt::format("{} has far {} before near {}", which, camera.far, camera.near),
                    "give a larger `far`, or 0 for infinity");
      if (i > 0 && keys[i].time <= keys[i - 1].time)
        throw Error(place("camera"), fmt::format("{} at {} s does not follow the one before", which, keys[i].time),
                    "order the keys by time");
    }
    if (glm::length(scenario_.light.direction) == 0)
      throw Error(place("light"), "`light.direction` has length 0", "try [0.4, 0.8, 0.45]");
    const Antialiasing& antialiasing = scenario_.antialiasing;
    if (std::popcount(static_cast<unsigned>(antialiasing.samples)) != 1)
      throw Error(place("samples"), fmt::format("`samples` is {}", antialiasing.samples), "choose 1, 2, 4 or 8");
    if (antialiasing.supersample % 2 == 0)
      throw Error(place("supersample"), fmt::format("`supersample` is {}", antialiasing.supersample),
                  "choose 1, 3, 5, 7 or 9");
    const CrowdSettings& crowd = scenario_.crowd;
    if (crowd.stage_far < crowd.stage_near)
      throw Error(place("crowd"), "`crowd.stage_far` is before `crowd.stage_near`", "exchange them");
    if (crowd.motion == MotionKind::lanes && crowd.stage != Stage::plaza)
      throw Error(place("crowd"), "`motion = \"lanes\"` needs `stage = \"plaza\"`", "choose another motion or stage");
  }

  std::string where_;
  KeyPlaces* places_;
  Scenario scenario_;
};

}  // namespace

std::string key_place(const std::string& table, const std::string& key, size_t index) {
  const KeyTable* const owner = find_table(table);
  return owner != nullptr && owner->list ? fmt::format("{}[{}].{}", table, index, key) : full_name(table, key);
}

Scenario parse_scenario(const std::string& toml, const std::string& where, KeyPlaces* places) {
  return Parser(where, places).run(toml);
}

Scenario load_scenario(const std::filesystem::path& path, KeyPlaces* places) {
  return parse_scenario(read_text(path, kScenarioBytes), path.string(), places);
}

}  // namespace crowdbench::scene
