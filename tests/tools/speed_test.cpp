// What scores cost: the program that says so runs, on tiny pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>

#include "core/command_line.h"
#include "core/files.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {

class BenchMetrics : public ::testing::Test {
 protected:
  void SetUp() override {
    CROWDBENCH_SKIP_SANITIZED("the scores' own tests: what is measured with is a release build");
    if (!std::filesystem::exists(program_directory() / "bench_metrics")) GTEST_SKIP() << "bench_metrics is not built";
  }
  support::Outcome run(const std::string& arguments) const {
    return support::run_shell(shell_quoted((program_directory() / "bench_metrics").string()) + " --tiny " + arguments +
                              " 2>&1");
  }
  support::ScratchFolder folder_;
};

TEST_F(BenchMetrics, PrintsScoresAndWritesThePageOfTheDuels) {
  const std::string page = (folder_ / "page.md").string();
  const support::Outcome outcome = run("--rounds 2 --markdown " + shell_quoted(page));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("240 x 135 pixels, 2 rounds"), std::string::npos) << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex("\nall of code values, together +0\\.[0-9]{3}")))
      << outcome.text;
  const std::string written = read_text(page);
  EXPECT_NE(written.find("| work | beside | ours, s | theirs, s | theirs / ours (95 %) |"), std::string::npos)
      << written;
  EXPECT_FALSE(std::regex_search(written, std::regex("nan|inf[^o]"))) << written;
  // Where a library is measured, both sides find nearly the same: the same work.
  const std::regex flip("\\| FLIP[^|]*\\|[^|]*\\|[^|]*\\|[^|]*\\|[^|]*\\|[^|]*\\| ([0-9.]+) \\| ([0-9.]+) \\|");
  std::smatch found;
  if (std::regex_search(written, found, flip)) {
    EXPECT_NEAR(std::stod(found[1]), std::stod(found[2]), 2e-4) << written;
  }
}

TEST_F(BenchMetrics, RefusesWhatItCannotTake) {
  for (const char* wrong : {"--frobnicate", "--rounds 0", "--rounds", "one.png", "none.png none.png"}) {
    const support::Outcome outcome = run(wrong);
    EXPECT_EQ(outcome.status, 2) << wrong;
    EXPECT_EQ(outcome.text.find("bench_metrics: "), 0U) << outcome.text;
    EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
  }
}

}  // namespace
}  // namespace crowdbench
