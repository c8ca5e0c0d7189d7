// Histories of made-up runs: order, change points and their revisions, chart and page.
#include "reports/model/history.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/history_chart.h"
#include "reports/page/history_page.h"
#include "reports/page/libraries.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

// Thirty files, one a day, the times of the last ten 8 % longer; given newest first.
std::vector<StoreContents> thirty_days() {
  std::vector<StoreContents> files;
  for (int day = 30; day >= 1; --day) {
    StoreContents file;
    file.runs = {made_up_run()};
    file.runs[0].started = fmt::format("2026-01-{:02}T00:00:00Z", day);
    file.runs[0].revision = fmt::format("rev{}", day);
    const double noise = 1 + 0.002 * ((day * 7) % 5 - 2);
    const double time = 0.25 * noise * (day > 20 ? 1.08 : 1);
    file.ratios = {{1,
                    1,
                    "speed",
                    {"flat", "mannequin", 250, 640, 480, 0.15},
                    "mesh",
                    "cpu",
                    1 / time,
                    0.99 / time,
                    1.01 / time,
                    24},
                   {2, 1, "speed", {"flat", "mannequin", 250, 640, 480, 0.15}, "mesh", "wall", 1, 1, 1, 24},
                   {3, 1, "floor", {"flat", "mannequin", 250, 640, 480, 0.15}, "floor=1", "cpu", 1, 1, 1, 24}};
    files.push_back(file);
  }
  return files;
}

TEST(History, FindsTheChangeAndItsRevisionWhateverTheOrderOfTheFiles) {
  const auto all = history_of(thirty_days(), {.min_magnitude = 0.02});
  ASSERT_EQ(all.size(), 1U) << "the headline's metric alone, and no floor";
  EXPECT_EQ(series_name(all[0]), "flat, mannequin, 250 agents, 15 %, 640 × 480");
  ASSERT_EQ(all[0].values.size(), 30U);
  EXPECT_EQ(all[0].values.front().revision, "rev1");
  EXPECT_NEAR(all[0].values.front().low, all[0].values.front().value / 1.01, 1e-12);
  ASSERT_EQ(all[0].changes.size(), 1U);
  EXPECT_EQ(all[0].changes[0].revision, "rev21");
  EXPECT_EQ(all[0].changes[0].revision_before, "rev20");
  EXPECT_EQ(all[0].changes[0].started, "2026-01-21T00:00:00Z");
  EXPECT_NEAR(all[0].changes[0].point.magnitude, 0.08, 0.005);
  EXPECT_TRUE(history_of(thirty_days(), {.min_magnitude = 0.2})[0].changes.empty());
}

TEST(History, DevicesAndScenariosAreSeriesOfTheirOwn) {
  auto files = thirty_days();
  files[3].runs[0].gl_renderer = "another";
  files[4].runs[0].scenario_hash = "another";
  const auto all = history_of(files, {});
  ASSERT_EQ(all.size(), 1U) << "a single value is no history";
  EXPECT_EQ(all[0].values.size(), 28U);
  EXPECT_TRUE(history_of({}, {}).empty());
}

TEST(History, ChartHasEveryRunEachLevelAndTheRevision) {
  const auto all = history_of(thirty_days(), {.min_magnitude = 0.02});
  const auto spec = nlohmann::json::parse(history_chart(all[0]));
  EXPECT_EQ(spec.at("data").at("values").size(), 30U);
  const auto& levels = spec.at("layer")[2].at("data").at("values");
  ASSERT_EQ(levels.size(), 2U);
  EXPECT_EQ(levels[0].at("to"), 20);
  EXPECT_EQ(levels[1].at("from"), 21);
  EXPECT_NEAR(levels[1].at("mean").get<double>(), 0.27, 0.001);
  EXPECT_EQ(spec.at("layer")[4].at("data").at("values")[0].at("label"), "rev21 +8.0 %");
}

TEST(History, PageListsTheChanges) {
  try {
    chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  const std::string page = history_page(history_of(thirty_days(), {.min_magnitude = 0.02}), "by a method");
  EXPECT_NE(page.find("rev21"), std::string::npos);
  EXPECT_NE(page.find("by a method"), std::string::npos);
  EXPECT_EQ(page.find("Nothing changed"), std::string::npos);
  EXPECT_NE(history_page(history_of(thirty_days(), {.min_magnitude = 0.5}), "").find("Nothing changed"),
            std::string::npos);
}

}  // namespace
}  // namespace crowdbench::reports
