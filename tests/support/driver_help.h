// What the driver's --help says, as data.
#pragma once

#include <cstdint>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/driver.h"

namespace crowdbench::support {

struct OptionHelp {
  bool takes_value = false;
  std::string text;
};
struct CommandHelp {
  size_t arguments = 0;                       // that are not options, at most; SIZE_MAX where the last is repeated
  std::map<std::string, OptionHelp> options;  // by name, without the dashes
};

// The commands that `crowdbench --help` lists, in its order; in place of one that has commands of its own, those:
// "study analyze". of: such a one.
inline std::vector<std::string> driver_commands(const std::string& of = "") {
  const std::string help = run_driver("", of + " --help").text;
  const size_t from = help.find("\nSubcommands:");
  std::vector<std::string> names;
  if (from == std::string::npos) return names;
  const std::regex row("\n  ([a-z-]+)  +[A-Z]");
  for (auto it = std::sregex_iterator(help.begin() + static_cast<std::ptrdiff_t>(from), help.end(), row);
       it != std::sregex_iterator(); ++it) {
    const std::string name = (of.empty() ? "" : of + " ") + (*it)[1].str();
    const std::vector<std::string> own = name == "study" ? driver_commands(name) : std::vector<std::string>{};
    if (own.empty()) names.push_back(name);
    names.insert(names.end(), own.begin(), own.end());
  }
  return names;
}

inline CommandHelp driver_help(const std::string& command) {
  const std::string help = run_driver("", command + " --help").text;
  CommandHelp out;
  const std::regex option("\n  (?:-.,)?--([a-z-]+)( [^ ]+( \\.\\.\\.)?)?\\s+([^\n]*)");
  for (auto it = std::sregex_iterator(help.begin(), help.end(), option); it != std::sregex_iterator(); ++it) {
    const std::string value = (*it)[2];  // or, of a flag, what it goes with
    const bool flag = value.empty() || value.starts_with(" Excludes:") || value.starts_with(" Needs:");
    out.options[(*it)[1]] = {!flag, (*it)[4]};
  }
  const size_t from = help.find("\nPositionals:");
  if (from == std::string::npos) return out;
  const std::string positionals = help.substr(from, help.find("\n\n", from + 1) - from);
  if (positionals.find(" ...") != std::string::npos) {
    out.arguments = SIZE_MAX;
    return out;
  }
  const std::regex argument("\n  [A-Z]+ ");
  out.arguments = static_cast<size_t>(
      std::distance(std::sregex_iterator(positionals.begin(), positionals.end(), argument), std::sregex_iterator()));
  return out;
}

}  // namespace crowdbench::support
