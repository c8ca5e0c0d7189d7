#include "core/command_line.h"

#include <filesystem>

namespace crowdbench {
namespace {

std::string& said() {
  static std::string line;
  return line;
}

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("-_./:,=+@%^").find(c) != std::string_view::npos;
}

}  // namespace

std::string shell_quoted(std::string_view text) {
  bool plain = !text.empty();
  std::string quoted = "'";
  for (const char c : text) {
    plain = plain && is_plain(c);
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  }
  return plain ? std::string(text) : quoted + "'";
}

std::string shell_quoted(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    line += shell_quoted(word);
  }
  return line;
}

void set_command_line(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  if (!words.empty()) words.front() = std::filesystem::path(words.front()).filename().string();
  said() = shell_quoted(words);
}

const std::string& command_line() { return said(); }

}  // namespace crowdbench
