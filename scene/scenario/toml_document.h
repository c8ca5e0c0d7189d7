// TOML, read into a plain tree: what scenarios and plans of sweeps are written in.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace crowdbench::scene {

struct TomlNode {
  enum class Type : uint8_t { boolean, integer, number, text, list, table, time };
  struct Entry;

  Type type = Type::table;
  size_t line = 1;  // of the text, where the value stands
  // The one that `type` says; the others are empty.
  bool boolean = false;
  int64_t integer = 0;
  double number = 0;
  std::string text;
  std::vector<TomlNode> list;
  std::vector<Entry> table;  // in the order of the text

  bool is_boolean() const { return type == Type::boolean; }
  bool is_integer() const { return type == Type::integer; }
  bool is_number() const { return type == Type::number || type == Type::integer; }
  bool is_text() const { return type == Type::text; }
  bool is_list() const { return type == Type::list; }
  bool is_table() const { return type == Type::table; }
  double as_number() const { return is_integer() ? static_cast<double>(integer) : number; }
  const TomlNode* find(const std::string& name) const;  // in its table; nullptr
  const char* type_name() const;                        // "a truth value", "a list", ... for people
  std::string place(const std::string& where) const;    // "where:LINE", for errors
};
// A key and its value.
struct TomlNode::Entry {
  std::string first;
  TomlNode second;
};

// The document's table. Throws Error with file and line; hostile text (deep nesting, more than 256 KiB, lines above
// 8 KiB, invalid UTF-8, control characters) is refused likewise. where: the file, for errors.
TomlNode parse_toml(const std::string& text, const std::string& where);

}  // namespace crowdbench::scene
