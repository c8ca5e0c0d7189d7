#include "scene/scenario/toml_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace crowdbench::scene {

TomlTable::TomlTable(const TomlNode& table, std::string name, std::string where, std::vector<std::string> known)
    : table_(table), name_(std::move(name)), where_(std::move(where)) {
  if (!table.is_table()) fail(table, fmt::format("`{}` is {}", name_, table.type_name()), "write it as a table");
  for (const auto& [key, node] : table.table)
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const std::string near = nearest_name(key, known);
      fail(node, fmt::format("unknown key `{}`{}", printable(key, 60), name_.empty() ? "" : " of " + name_),
           near.empty() ? fmt::format("it has {}", fmt::join(known, ", ")) : fmt::format("did you mean `{}`?", near));
    }
}

std::string TomlTable::place(const char* key) const {
  const TomlNode* const node = find(key);
  return (node == nullptr ? table_ : *node).place(where_);
}

void TomlTable::fail(const TomlNode& node, const std::string& wrong, const std::string& advice) const {
  throw Error(node.place(where_), wrong, advice);
}

void TomlTable::text(const char* key, std::string& out) const {
  const TomlNode* const node = find(key);
  if (node == nullptr) return;
  if (!node->is_text() || node->text.empty() || node->text.size() > 1000)
    fail(*node, fmt::format("`{}` is not a text of 1 to 1000 bytes", key), "write it in quotes");
  out = node->text;
}

void TomlTable::flag(const char* key, bool& out) const {
  const TomlNode* const node = find(key);
  if (node == nullptr) return;
  if (!node->is_boolean()) fail(*node, fmt::format("`{}` is {}", key, node->type_name()), "give true or false");
  out = node->boolean;
}

void TomlTable::number(const char* key, double low, double high, double& out) const {
  const TomlNode* const node = find(key);
  if (node == nullptr) return;
  if (!node->is_number() || !(node->as_number() >= low && node->as_number() <= high))
    fail(*node, fmt::format("`{}` is not a number from {} to {}", key, low, high), "change it");
  out = node->as_number();
}

void TomlTable::number(const char* key, double low, double high, std::optional<double>& out) const {
  if (find(key) == nullptr) return;
  double value = low;
  number(key, low, high, value);
  out = value;
}

void TomlTable::texts(const char* key, std::vector<std::string>& out) const {
  const TomlNode* const node = find(key);
  if (node == nullptr) return;
  if (!node->is_list()) fail(*node, fmt::format("`{}` is {}", key, node->type_name()), "give a list of texts");
  out.clear();
  for (const TomlNode& entry : node->list) {
    if (!entry.is_text() || entry.text.empty() || entry.text.size() > 1000)
      fail(entry, fmt::format("`{}` holds what is not a text of 1 to 1000 bytes", key), "write it in quotes");
    out.push_back(entry.text);
  }
}

std::vector<const TomlNode*> TomlTable::tables(const char* key) const {
  std::vector<const TomlNode*> out;
  const TomlNode* const list = find(key);
  if (list == nullptr) return out;
  const std::string full = name_.empty() ? key : name_ + "." + key;
  if (!list->is_list()) fail(*list, fmt::format("`{}` is {}", full, list->type_name()), "write [[" + full + "]]");
  for (const TomlNode& entry : list->list) {
    if (!entry.is_table()) fail(entry, fmt::format("`{}` holds {}", full, entry.type_name()), "write [[" + full + "]]");
    out.push_back(&entry);
  }
  return out;
}

int64_t TomlTable::whole_number(const char* key, const TomlNode& node, int64_t low, int64_t high) const {
  if (!node.is_integer() || node.integer < low || node.integer > high)
    fail(node, fmt::format("`{}` is not a whole number from {} to {}", key, low, high), "change it");
  return node.integer;
}

size_t TomlTable::position(const char* key, const TomlNode& node, const std::vector<std::string>& words) const {
  const auto found = std::find(words.begin(), words.end(), node.text);
  if (node.is_text() && found != words.end()) return static_cast<size_t>(found - words.begin());
  const std::string near = node.is_text() ? nearest_name(node.text, words) : std::string();
  fail(node,
       node.is_text() ? fmt::format("`{}` is '{}'", key, printable(node.text, 60))
                      : fmt::format("`{}` is {}", key, node.type_name()),
       near.empty() ? fmt::format("choose \"{}\"", fmt::join(words, "\" or \""))
                    : fmt::format("did you mean \"{}\"?", near));
}

}  // namespace crowdbench::scene
