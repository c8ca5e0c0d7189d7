// A table of a TOML document that is no scenario (a plan of a sweep or of a study), read key by key. Every fault names
// file, line, value and range, an unknown key the nearest known one.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "scene/scenario/toml_document.h"

namespace crowdbench::scene {

class TomlTable {
 public:
  // table: must outlive the reader. name: of the table, empty for the document. known: its keys; any other throws
  // Error. where: the file, for errors.
  TomlTable(const TomlNode& table, std::string name, std::string where, std::vector<std::string> known);

  const TomlNode* find(const char* key) const { return table_.find(key); }
  // Where the key stands, or the table where it does not have it.
  std::string place(const char* key) const;
  [[noreturn]] void fail(const TomlNode& node, const std::string& wrong, const std::string& advice) const;

  // Each leaves `out` as it is where the key is not given. Throw Error where the value is not what is meant.
  void text(const char* key, std::string& out) const;  // 1 to 1000 bytes
  void flag(const char* key, bool& out) const;
  void number(const char* key, double low, double high, double& out) const;
  void number(const char* key, double low, double high, std::optional<double>& out) const;
  template <typename T>
  void whole(const char* key, int64_t low, int64_t high, T& out) const {
    if (const TomlNode* const node = find(key)) out = static_cast<T>(whole_number(key, *node, low, high));
  }
  void texts(const char* key, std::vector<std::string>& out) const;
  // One of the words; T is an enumeration whose values are their positions.
  template <typename T>
  void choice(const char* key, const std::vector<std::string>& words, T& out) const {
    if (const TomlNode* const node = find(key)) out = static_cast<T>(position(key, *node, words));
  }
  // The tables of [[key]].
  std::vector<const TomlNode*> tables(const char* key) const;

 private:
  int64_t whole_number(const char* key, const TomlNode& node, int64_t low, int64_t high) const;
  size_t position(const char* key, const TomlNode& node, const std::vector<std::string>& words) const;

  const TomlNode& table_;
  std::string name_;
  std::string where_;
};

}  // namespace crowdbench::scene
