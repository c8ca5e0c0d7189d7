// Pages that commands write, in a real browser, headless: wide and narrow, light and dark (tools/page_check.mjs), and
// their numbers beside the JSON of the same run.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/command_line.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using nlohmann::json;

class PagesBrowserSlow : public ::testing::Test {
 protected:
  void SetUp() override {
    CROWDBENCH_SKIP_SANITIZED("TunePageTest and CommandsGl: browsers execute nothing of ours");
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    for (const char* program : {"node", "chromium"})
      if (support::run_shell(std::string("command -v ") + program + " >/dev/null").status != 0)
        GTEST_SKIP() << program << " is not installed";
    if (!fs::exists(fs::path(CROWDBENCH_SOURCE_DIR) / "node_modules/puppeteer-core"))
      GTEST_SKIP() << "puppeteer-core is not installed (npm ci)";
  }
  // What the check says of a page, in which nothing is wrong.
  json checked(const fs::path& page) const {
    const support::Outcome outcome =
        support::run_shell("node " + shell_quoted((fs::path(CROWDBENCH_SOURCE_DIR) / "tools/page_check.mjs").string()) +
                           " " + shell_quoted(page.string()) + " 2>&1");
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    json said = json::parse(outcome.text, nullptr, false);
    EXPECT_TRUE(said.is_object()) << outcome.text;
    return said;
  }
  support::ScratchFolder folder_;
};

TEST_F(PagesBrowserSlow, OfATuningShowsTheNumbersOfItsJsonWideAndNarrowLightAndDark) {
  // A threshold that the impostor keeps at one height of four, by 0.8 at least.
  const support::Outcome outcome = support::run_driver(
      "cd " + shell_quoted(folder_.path().string()) + " && CROWDBENCH_CACHE_DIR=cache",
      "tune --character mannequin:triangles=2200 --representation mesh:triangles=100,flat:views=sphere-8x3,texels=32,"
      "frames=2 --agents 40 --size 320x240 --heights 4 --moments 1 --views 2 --rounds 4 --threshold mae=28 "
      "--pop-threshold mae=255 --promise-seeds 3 --prove 2 --prove-figures 4 --check-views --page page.html --json",
      false);
  const json found = json::parse(outcome.text, nullptr, false);
  ASSERT_TRUE(found.is_object()) << outcome.status << outcome.text;
  const json said = checked(folder_ / "page.html");
  ASSERT_EQ(said.at("views").size(), 4U);
  for (const json& view : said.at("views")) EXPECT_EQ(view.at("drawn"), 2) << "errors and costs";

  const json& tables = said.at("tables");
  const auto number = [](const json& value, int digits) { return fmt::format("{:.{}f}", value.get<double>(), digits); };
  const json& switches = found.at("switches");
  ASSERT_FALSE(switches.empty());
  const json& rows = tables.at("switches");
  const json& engines = tables.at("engines");
  ASSERT_EQ(rows.size(), switches.size() + 1);
  for (size_t i = 0; i < switches.size(); ++i) {
    const json& one = switches[i];
    EXPECT_EQ(rows[i + 1][0], one.at("to"));
    EXPECT_EQ(rows[i + 1][2], number(one.at("height_px"), 1));
    EXPECT_EQ(rows[i + 1][4], number(one.at("next_taller_px"), 1));
    EXPECT_EQ(rows[i + 1][5], number(one.at("depth_m"), 1));
    if (one.at("decided").get<bool>()) {
      EXPECT_EQ(rows[i + 1][3],
                number(one.at("interval_px").at("low"), 1) + " to " + number(one.at("interval_px").at("high"), 1));
    }
    EXPECT_EQ(engines[i + 1][3], number(one.at("unreal_screen_size"), 4));
    EXPECT_EQ(engines[i + 1][4], number(one.at("godot_visibility_range_m"), 2));
  }
  const json& seeds = tables.at("seeds");
  ASSERT_EQ(seeds.size(), 1U + 3 + 2);
  EXPECT_EQ(seeds[1][2], number(found.at("promise").at("seeds")[0].at("reference_over_plan"), 3));
  EXPECT_EQ(seeds[4][5], number(found.at("proof").at("speed").at("seeds")[0].at("plan_ms"), 2));
  EXPECT_EQ(tables.at("lenses").size(), found.at("lenses").size() + 1);
}

}  // namespace
}  // namespace crowdbench::bench
