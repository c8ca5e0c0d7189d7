// What the documentation and the help print is there: command lines that the driver takes, commands of ./run, files.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

#include "core/files.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/driver_help.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

// The words of one simple command, as a shell splits them: up to its end, or where its comment begins.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::string word;
  bool inside = false;
  char quote = 0;
  for (const char c : text + " ") {
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '\'' || c == '"') {
      quote = c;
      inside = true;
    } else if (c == ';' || c == '|' || c == '&' || c == '>' || c == ' ' || c == '\n' || (c == '#' && !inside)) {
      if (inside) words.push_back(word);
      word.clear();
      inside = false;
      if (c != ' ' && c != '\n') break;
    } else {
      word += c;
      inside = true;
    }
  }
  return words;
}

struct Printed {
  std::string place;  // FILE:LINE
  std::vector<std::string> words;
};

// What follows PROGRAM in the code of a Markdown file: its indented lines, and what stands between backticks.
std::vector<Printed> printed_commands(const fs::path& file, const std::vector<std::string>& programs) {
  std::vector<std::pair<int, std::string>> codes;
  std::istringstream lines(read_text(file));
  std::string line;
  std::string open;  // the inline code that the lines before have begun
  bool inside = false;
  int number = 0;
  while (std::getline(lines, line)) {
    ++number;
    if (!inside && line.starts_with("    ")) {
      codes.emplace_back(number, line);
      continue;
    }
    if (line.empty()) inside = false;
    for (const char c : line + "\n") {
      if (c == '`') {
        if (inside) codes.emplace_back(number, open);
        inside = !inside;
        open.clear();
      } else if (inside) {
        open += c;
      }
    }
  }
  std::vector<Printed> out;
  for (const auto& [where, code] : codes)
    for (const std::string& program : programs)
      for (size_t at = code.find(program + " "); at != std::string::npos; at = code.find(program + " ", at + 1)) {
        if (at > 0 && code[at - 1] != ' ') continue;
        out.push_back(
            {file.filename().string() + ":" + std::to_string(where), words_of(code.substr(at + program.size() + 1))});
      }
  return out;
}

std::vector<fs::path> documentation() {
  std::vector<fs::path> files;
  const fs::path top = CROWDBENCH_SOURCE_DIR;
  for (const char* name : {"README.md", "CONTRIBUTING.md", "CHANGELOG.md"}) files.push_back(top / name);
  for (const char* room : {"docs", "renderers", "studies", "metrics", "reports", "bench"})
    for (const auto& entry : fs::recursive_directory_iterator(top / room))
      if (entry.path().extension() == ".md") files.push_back(entry.path());
  return files;
}

// Empty where the driver takes these words; else what it would not take.
std::string fault_of(const std::vector<std::string>& words) {
  static std::map<std::string, support::CommandHelp> known;
  if (known.empty())
    for (const std::string& command : support::driver_commands()) known[command] = support::driver_help(command);
  if (words.empty() || words[0] == "--help" || words[0] == "--version") return "";
  auto command = known.find(words[0]);
  size_t first = 1;
  if (command == known.end() && words.size() > 1) {
    command = known.find(words[0] + " " + words[1]);
    first = 2;
  }
  if (command == known.end()) return "there is no command '" + words[0] + "'";
  size_t arguments = 0;
  for (size_t i = first; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "...") continue;
    if (!word.starts_with("-")) {
      ++arguments;
      continue;
    }
    const std::string name = word == "-r" ? "representation" : word.substr(2, word.find('=') - 2);
    const auto option = command->second.options.find(name);
    if (option == command->second.options.end()) return words[0] + " has no option '" + word + "'";
    if (option->second.takes_value && word.find('=') == std::string::npos && ++i == words.size())
      return words[0] + " " + word + ": its value is missing";
  }
  if (arguments > command->second.arguments) return words[0] + " takes fewer arguments";
  return "";
}

TEST(Documentation, PrintsCommandLinesThatTheDriverTakes) {
  CROWDBENCH_SKIP_SANITIZED("Manners.OneThingHasOneNameAndOneWordingInAllCommands");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  // The reader of command lines itself.
  EXPECT_EQ(words_of("a 'b c' d=\"e f\"  # g"), (std::vector<std::string>{"a", "b c", "d=e f"}));
  EXPECT_EQ(words_of("a --b c#d && e"), (std::vector<std::string>{"a", "--b", "c#d"}));
  EXPECT_EQ(fault_of({"render", "s.toml", "--agents", "5", "--out", "x.png"}), "");
  EXPECT_EQ(fault_of({"rendr"}), "there is no command 'rendr'");
  EXPECT_EQ(fault_of({"bake", "polypostor", "--audit"}), "bake takes fewer arguments");
  EXPECT_EQ(fault_of({"bake", "--frobnicate"}), "bake has no option '--frobnicate'");
  EXPECT_EQ(fault_of({"render", "--agents"}), "render --agents: its value is missing");

  size_t lines = 0;
  for (const fs::path& file : documentation())
    for (const Printed& printed : printed_commands(file, {"crowdbench", "$cb"})) {
      ++lines;
      EXPECT_EQ(fault_of(printed.words), "") << printed.place;
    }
  EXPECT_GT(lines, 50U) << "the documentation prints command lines";
}

TEST(Documentation, PrintsExamplesInHelpThatTheDriverTakes) {
  CROWDBENCH_SKIP_SANITIZED("Manners.OneThingHasOneNameAndOneWordingInAllCommands");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const std::vector<std::string> commands = support::driver_commands();
  EXPECT_GT(commands.size(), 20U);
  for (const std::string& command : commands) {
    // A line that ends with a backslash goes on.
    const std::string help =
        std::regex_replace(support::run_driver("", command + " --help").text, std::regex(" *\\\\\n +"), " ");
    const size_t from = help.find("Example");
    ASSERT_NE(from, std::string::npos) << command << " --help has an example";
    size_t examples = 0;
    std::istringstream lines(help.substr(from));
    std::string line;
    while (std::getline(lines, line)) {
      if (!line.starts_with("  crowdbench ")) continue;
      ++examples;
      // An example may be followed by what it is for, apart by spaces.
      const std::vector<std::string> words = words_of(line.substr(13, line.find("   ", 13) - 13));
      EXPECT_EQ(fault_of(words), "") << line;
      EXPECT_EQ(words.at(0) + (command.find(' ') == std::string::npos ? "" : " " + words.at(1)), command);
    }
    EXPECT_GT(examples, 0U) << command;
  }
}

TEST(Documentation, NamesCommandsOfRunThatThereAre) {
  const support::Outcome usage = support::run_shell("'" CROWDBENCH_SOURCE_DIR "/run' help");
  EXPECT_EQ(usage.status, 0);
  size_t lines = 0;
  for (const fs::path& file : documentation())
    for (const Printed& printed : printed_commands(file, {"./run"})) {
      ASSERT_FALSE(printed.words.empty()) << printed.place;
      ++lines;
      EXPECT_NE(usage.text.find("\n  " + printed.words[0] + " "), std::string::npos)
          << printed.place << ": ./run " << printed.words[0];
    }
  EXPECT_GT(lines, 5U);
}

// Of the project's own files, what is named is there. NAME, stars and dollars stand for others.
TEST(Documentation, NamesFilesThatThereAre) {
  CROWDBENCH_SKIP_SANITIZED("nothing: it reads documents");
  const fs::path top = CROWDBENCH_SOURCE_DIR;
  std::vector<fs::path> files = documentation();
  files.push_back(top / "run");
  for (const char* folder : {"tools", "bench/scenarios", "cmake"})
    for (const auto& entry : fs::directory_iterator(top / folder)) files.push_back(entry.path());
  const std::regex path(
      "(^|[^A-Za-z0-9_/.-])((core|store|scene|renderers|metrics|studies|reports|bench|tests|tools|docs|cmake)/"
      "[A-Za-z0-9_./*$\\{\\}<-]+)");
  size_t names = 0;
  for (const fs::path& file : files) {
    const std::string text = read_text(file);
    for (auto it = std::sregex_iterator(text.begin(), text.end(), path); it != std::sregex_iterator(); ++it) {
      std::string name = (*it)[2];
      while (name.ends_with(".") || name.ends_with("/")) name.pop_back();
      if (name.find_first_of("*${}<") != std::string::npos || name.find("NAME") != std::string::npos) continue;
      ++names;
      EXPECT_TRUE(fs::exists(top / name) || fs::exists(file.parent_path() / name))
          << file.lexically_relative(top) << " names " << name;
    }
  }
  EXPECT_GT(names, 30U);
}

}  // namespace
}  // namespace crowdbench::bench
