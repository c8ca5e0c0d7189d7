// ./run itself, where that costs nothing: what it lists, refuses, and would install.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/files.h"
#include "test_paths.h"
#include "tests/support/driver.h"

namespace crowdbench {
namespace {

using support::Outcome;

Outcome run(const std::string& arguments) {
  return support::run_shell("'" CROWDBENCH_SOURCE_DIR "/run' " + arguments + " 2>&1");
}

// The packages of packages.txt by section.
std::map<std::string, std::vector<std::string>> sections() {
  std::map<std::string, std::vector<std::string>> out;
  std::istringstream lines(read_text(CROWDBENCH_SOURCE_DIR "/packages.txt"));
  std::string line;
  std::string section;
  while (std::getline(lines, line)) {
    if (line.empty() || line[0] == '#') continue;
    if (line[0] == '[')
      section = line.substr(1, line.size() - 2);
    else
      out[section].push_back(line.substr(0, line.find(' ')));
  }
  return out;
}

TEST(RunScript, ListsTheCommandsThatItHas) {
  const std::string script = read_text(CROWDBENCH_SOURCE_DIR "/run");
  const Outcome help = run("help");
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(run("").text, help.text);
  std::set<std::string> listed;
  const std::regex row("\n  ([a-z-]+) ");
  for (auto it = std::sregex_iterator(help.text.begin(), help.text.end(), row); it != std::sregex_iterator(); ++it)
    listed.insert((*it)[1]);
  std::set<std::string> there;
  const std::regex branch("\n  ([a-z-]+)\\)");
  for (auto it = std::sregex_iterator(script.begin(), script.end(), branch); it != std::sregex_iterator(); ++it)
    there.insert((*it)[1]);
  EXPECT_EQ(listed, there);
  EXPECT_TRUE(listed.contains("gpu-check"));
  const Outcome unknown = run("frobnicate");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.text.find("run: unknown command frobnicate\n"), std::string::npos) << unknown.text;
}

TEST(RunScript, InstallsEverySectionOfPackagesByACommand) {
  const std::string script = read_text(CROWDBENCH_SOURCE_DIR "/run");
  std::set<std::string> installed;
  const std::regex call("\\bsetup(( [a-z]+)+)\n");
  for (auto it = std::sregex_iterator(script.begin(), script.end(), call); it != std::sregex_iterator(); ++it) {
    std::istringstream words((*it)[1]);
    std::string word;
    while (words >> word) installed.insert(word);
  }
  std::set<std::string> stated;
  for (const auto& [section, packages] : sections()) stated.insert(section);
  EXPECT_EQ(installed, stated);
}

TEST(RunScript, ListsThePackagesOfEachSectionOrOfAll) {
  std::string all;
  for (const auto& [section, packages] : sections()) {
    std::string expected;
    for (const std::string& package : packages) expected += package + "\n";
    const Outcome outcome = run("packages " + section);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.text, expected) << section;
    EXPECT_FALSE(packages.empty()) << section;
  }
  size_t packages = 0;
  for (const char c : run("packages").text) packages += c == '\n' ? 1 : 0;
  size_t stated = 0;
  std::set<std::string> names;
  for (const auto& [section, some] : sections()) {
    stated += some.size();
    names.insert(some.begin(), some.end());
  }
  EXPECT_EQ(packages, stated);
  EXPECT_EQ(names.size(), stated) << "each in one section";
}

TEST(RunScript, RefusesASectionThatPackagesDoesNotHave) {
  for (const char* arguments : {"packages frobnicate", "packages build frobnicate"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_NE(outcome.text.find("packages.txt has no section 'frobnicate'; it has build tests"), std::string::npos)
        << outcome.text;
  }
}

}  // namespace
}  // namespace crowdbench
