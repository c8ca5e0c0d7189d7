// The pilot of studies/README.md, command by command as it is printed, from a plan to a report with simulated answers.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "core/files.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> printed_pilot() {
  const std::string guide = read_text(fs::path(CROWDBENCH_SOURCE_DIR) / "studies/README.md");
  const size_t from = guide.find("## A pilot, from a clone");
  const std::string section = guide.substr(from, guide.find("\n## ", from + 1) - from);
  std::vector<std::string> out;
  const std::regex line("\n    ([^\n]+)");
  for (auto it = std::sregex_iterator(section.begin(), section.end(), line); it != std::sregex_iterator(); ++it)
    out.push_back((*it)[1]);
  return out;
}

// How many of the power's simulated studies end without an interval is what the guide says of them.
void expect_guide_says_how_many_are_open(const std::string& said) {
  std::smatch found;
  ASSERT_TRUE(std::regex_search(said, found, std::regex("(\\d+ of 50 studies) end without an interval \\((\\d+ %)")))
      << said;
  const std::string guide = read_text(fs::path(CROWDBENCH_SOURCE_DIR) / "studies/README.md");
  EXPECT_NE(guide.find(found.str(1) + "\nend so (" + found.str(2) + ")"), std::string::npos) << found.str();
}

TEST(StudyGuideGlSlow, ThePilotRunsAsItIsPrinted) {
  CROWDBENCH_SKIP_SANITIZED("ExportGl and SimulatedStudyTest");
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::ScratchFolder folder;
  fs::create_directories(folder / "studies/plans");
  fs::copy(fs::path(CROWDBENCH_SOURCE_DIR) / "studies/plans/pilot.toml", folder / "studies/plans");
  const std::string start =
      "cd '" + folder.path().string() + "' && cb='" + (program_directory() / "crowdbench").string() + "' && ";
  size_t served = 0;
  size_t run = 0;
  for (const std::string& line : printed_pilot()) {
    if (line == "./run build" || line.starts_with("cb=")) continue;  // it is built; another folder
    if (line.find(" serve ") != std::string::npos) {
      // In place of those who take part.
      const auto taken = support::run_shell(start + "cp rehearsal.sqlite pilot-out/answers.sqlite");
      served += taken.status == 0 ? 1 : 0;
      continue;
    }
    const support::Outcome outcome = support::run_shell(start + line + " 2>&1");
    ASSERT_EQ(outcome.status, 0) << line << "\n" << outcome.text;
    if (line.find("study power") != std::string::npos) expect_guide_says_how_many_are_open(outcome.text);
    ++run;
  }
  EXPECT_EQ(served, 1U);
  EXPECT_GE(run, 8U);
  for (const char* report : {"rehearsal/report.html", "pilot-report/report.html"})
    EXPECT_TRUE(fs::exists(folder / report)) << report;
  const nlohmann::json found = nlohmann::json::parse(read_text(folder / "rehearsal/analysis.json"));
  const nlohmann::json& interval = found.at("tasks").at(0).at("curves").at(0).at("threshold_profile");
  EXPECT_LE(interval.at(0).get<double>(), 150) << "what the guide promises";
  EXPECT_GE(interval.at(1).get<double>(), 150);
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "pilot-report/analysis.json")).at("rows"), 256);
}

}  // namespace
}  // namespace crowdbench::studies
