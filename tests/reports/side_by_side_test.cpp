// Several files in one report, sweeps over crowd sizes as one scene, rules of `tune` by themselves.
#include "reports/model/side_by_side.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/cost_charts.h"
#include "reports/charts/side_chart.h"
#include "reports/exports/cost_export.h"
#include "reports/exports/exports.h"
#include "reports/exports/side_markdown.h"
#include "reports/model/shown.h"
#include "reports/model/tuning_text.h"
#include "reports/page/libraries.h"
#include "reports/page/report_page.h"
#include "reports/page/side_section.h"
#include "reports/page/tuning_section.h"
#include "store/joined.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

// The made-up rows as a sweep makes them: each crowd and occupancy with a run and a scenario of its own.
StoreContents swept() {
  StoreContents all = made_up_contents();
  const RunRow base = all.runs.front();
  all.runs.clear();
  std::map<std::pair<uint32_t, double>, int64_t> runs;
  const auto run_of = [&](uint32_t agents, double occupancy) {
    const auto [found, fresh] = runs.try_emplace({agents, occupancy}, static_cast<int64_t>(runs.size()) + 1);
    if (fresh) {
      RunRow run = base;
      run.id = found->second;
      run.scenario =
          fmt::format("seed = 1\noccupancy = {}\n\n[crowd]\nagents = {}\nspacing = 1.2\n", occupancy, agents);
      run.scenario_hash = fmt::format("hash{}", run.id);
      all.runs.push_back(run);
    }
    return found->second;
  };
  for (MeasurementRow& row : all.measurements) row.run = run_of(row.key.agents, row.key.requested_occupancy);
  for (RatioRow& row : all.ratios) row.run = run_of(row.of.agents, row.of.requested_occupancy);
  all.comparisons.clear();
  all.pictures.clear();
  return all;
}

TEST(SweptScene, CrowdsAndOccupanciesAreOneSceneWithCurvesModelAndMap) {
  const StoreContents contents = swept();
  ASSERT_GT(contents.runs.size(), 9U);
  const std::vector<Scene> scenes = scenes_of(contents, made_up_scores());
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].agents.size(), 5U);
  EXPECT_EQ(scenes[0].occupancies.size(), 2U);
  EXPECT_NE(scenes[0].ratio("speed", "flat", 100, 0.9, "cpu"), nullptr);
  const std::string markdown = report_markdown(contents, "swept.sqlite", made_up_scores());
  EXPECT_NE(markdown.find("## Which is the cheaper one"), std::string::npos);
  EXPECT_NE(cost_markdown(scenes[0]).find("## Break-even"), std::string::npos);
  if (!has_libraries()) GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  const std::string page = report_page(contents, {"swept.sqlite", made_up_scores()});
  for (const char* part : {"Where they break even", "What makes it cost that", "Time, bytes and error"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(SweptScene, WhatElseDiffersStaysApart) {
  EXPECT_EQ(without_crowd_size("seed = 1\noccupancy = 0.5\n\n[crowd]\nagents = 4\nspacing = 2\n[other]\nagents = 3\n"),
            "seed = 1\n\n[crowd]\nspacing = 2\n[other]\nagents = 3\n");
  StoreContents contents = swept();
  contents.runs[0].scenario += "[camera]\nfov_y_deg = 50\n";
  EXPECT_EQ(scenes_of(contents).size(), 2U);
  contents = swept();
  contents.runs[0].cpu_model = "another";
  EXPECT_EQ(scenes_of(contents).size(), 2U) << "times of two machines make no curve";
}

// Of samples each crowd has an occupancy of its own: no curve over agents, but every point.
TEST(SweptScene, SamplesAreDrawnAsPoints) {
  StoreContents contents = swept();
  std::map<uint32_t, double> own;
  for (MeasurementRow& row : contents.measurements) row.key.requested_occupancy = 0;
  std::vector<MeasurementRow> rows;
  for (const MeasurementRow& row : contents.measurements)
    for (int i = 0; i < 2; ++i) {
      rows.push_back(row);
      rows.back().id = static_cast<int64_t>(rows.size());
      rows.back().key.agents += static_cast<uint32_t>(1000 * i);
      rows.back().key.requested_occupancy = 0.001 * rows.back().key.agents / 3;
    }
  contents.measurements = rows;
  contents.ratios.clear();
  const std::vector<Scene> scenes = scenes_of(contents);
  ASSERT_EQ(scenes.size(), 1U);
  ASSERT_GT(scenes[0].occupancies.size(), kMostCurves);
  EXPECT_TRUE(shown_occupancies(scenes[0]).empty());
  EXPECT_FALSE(scatter_chart(scenes[0]).empty());
}

TEST(SweptScene, OfVeryManyCrowdsCurvesKeepBothEnds) {
  StoreContents contents = made_up_contents();
  const MeasurementRow row = contents.measurements.front();
  for (uint32_t agents = 2000; agents < 2500; ++agents) {
    contents.measurements.push_back(row);
    contents.measurements.back().id = 10'000 + agents;
    contents.measurements.back().key.agents = agents;
  }
  const std::vector<uint32_t> shown = shown_agents(scenes_of(contents)[0]);
  EXPECT_EQ(shown.size(), kMostOnACurve);
  EXPECT_EQ(shown.front(), 1U);
  EXPECT_EQ(shown.back(), 2499U);
}

TEST(SideBySide, OfOneFileIsNothing) {
  const StoreContents contents = made_up_contents();
  const SideBySide sides = side_by_side(scenes_of(contents));
  EXPECT_TRUE(sides.files.empty());
  int last_chart = 0;
  EXPECT_EQ(side_markdown(sides), "");
  EXPECT_TRUE(side_section(sides, last_chart).text.empty());
}

TEST(SideBySide, PairsPointsByWhatTheyShow) {
  StoreContents later = made_up_contents();
  later.runs[0].revision = "another";
  for (RatioRow& row : later.ratios) row.ratio *= 1.25;
  std::erase_if(later.measurements, [](const MeasurementRow& row) { return row.key.agents == 10; });
  std::erase_if(later.ratios, [](const RatioRow& row) { return row.of.agents == 10; });
  const StoreContents both = joined({{"before.sqlite", made_up_contents()}, {"after.sqlite", later}});
  const std::vector<Scene> scenes = scenes_of(both, made_up_scores());
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[1].source, "after.sqlite");
  const SideBySide sides = side_by_side(scenes);
  EXPECT_EQ(sides.files, (std::vector<std::string>{"before.sqlite", "after.sqlite"}));
  ASSERT_EQ(sides.groups.size(), 1U);
  ASSERT_FALSE(sides.groups[0].rows.empty());
  for (const SideRow& row : sides.groups[0].rows) {
    EXPECT_EQ(row.representation, "flat");
    EXPECT_NE(row.agents, 10U) << "one file alone has it";
    ASSERT_NE(row.cells[0].ratio, nullptr);
    EXPECT_NEAR(row.cells[1].ratio->ratio, 1.25 * row.cells[0].ratio->ratio, 1e-9);
  }
  const auto chart = nlohmann::json::parse(side_chart(sides, sides.groups[0], "flat", 0.15));
  EXPECT_EQ(chart.at("data").at("values").size() % 2, 0U);
  EXPECT_EQ(side_chart(sides, sides.groups[0], "flat", 0.5), "");
  const std::string markdown = report_markdown(both, "both", made_up_scores());
  EXPECT_NE(markdown.find("before.sqlite: times as fast as mesh"), std::string::npos) << markdown.substr(0, 500);
  EXPECT_NE(markdown.find(", of after.sqlite"), std::string::npos);
  if (!has_libraries()) GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  const std::string page = report_page(both, {"before.sqlite, after.sqlite", made_up_scores()});
  EXPECT_NE(page.find("The files beside each other"), std::string::npos);
  EXPECT_NE(page.find("<dt>file</dt><dd>after.sqlite</dd>"), std::string::npos);
}

TEST(SideBySide, SaysWhereNothingMeets) {
  StoreContents other = made_up_contents();
  other.runs[0].scenario_hash = "another";
  const StoreContents both = joined({{"a", made_up_contents()}, {"b", other}});
  const SideBySide sides = side_by_side(scenes_of(both));
  EXPECT_TRUE(sides.groups.empty());
  EXPECT_NE(side_markdown(sides).find("No two of them have a point"), std::string::npos);
}

TuningRow a_rule() {
  TuningRow row;
  row.run = 1;
  row.character = "Fox";
  row.score = "ssim";
  row.threshold = 0.85;
  row.pop_score = "ssim";
  row.pop_threshold = 0.7;
  row.representation = "hybrid(mesh,flat,height=53)";
  row.agents = 78;
  row.saving = 1.5;
  row.saving_low = 1.4;
  row.saving_high = 1.6;
  row.promised = 1.2;
  row.promised_low = 1.1;
  row.promised_high = 1.3;
  row.display = "a screen";
  row.switches = {{0, "mesh", "flat", 53.18, 50, 56, 0.97, true, 12.52, 2.5, {}, 0.02, 0.85}};
  return row;
}

TEST(TunedRule, IsToldByTheReportOfAFileThatHoldsNothingElse) {
  StoreContents contents;
  contents.runs.push_back(made_up_run());
  contents.tunings = {a_rule()};
  const std::vector<std::string> told = tuning_sentences(contents.tunings[0], made_up_scores());
  ASSERT_EQ(told.size(), 4U);
  EXPECT_EQ(told[0], "From the eye to 12.5 m draw mesh; from 12.5 m on (figures of 53.2 pixels and less) flat.");
  EXPECT_EQ(
      told[1],
      "The cheapest with SSIM 0.850 or more for the figures that each draws; a change may show SSIM 0.700 or more.");
  EXPECT_EQ(
      told[3],
      "Promised of a whole frame of another seed: 1.2 times as fast as the reference (95 %: 1.1 to 1.3); not tried "
      "on unseen crowds and figures.");
  EXPECT_EQ(certainty_text(contents.tunings[0].switches[0]), "50.0 to 56.0 px in 97 % of the resamples");
  EXPECT_NE(tuning_section(contents, made_up_scores()).text.find("53.2"), std::string::npos);
  const std::string markdown = report_markdown(contents, "tuned.sqlite", made_up_scores());
  EXPECT_NE(markdown.find("# The tuned rule: Fox"), std::string::npos);
  EXPECT_NE(markdown.find("| flat | mesh | 53.2 | 12.5 |"), std::string::npos) << markdown;
  if (!has_libraries()) GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  const std::string page = report_page(contents, {"tuned.sqlite", made_up_scores()});
  EXPECT_NE(page.find("<h1>Which representation from which distance on</h1>"), std::string::npos);
  EXPECT_NE(page.find("The tuned rule: Fox"), std::string::npos);
}

TEST(TunedRule, ThatThereIsNotSaysWhy) {
  TuningRow row = a_rule();
  row.representation.reset();
  row.switches.clear();
  row.reason = "no candidate keeps it";
  row.proof_holds = false;
  const std::vector<std::string> told = tuning_sentences(row, {});
  EXPECT_EQ(told[0], "There is no rule: no candidate keeps it.");
  EXPECT_NE(told.back().find("it did NOT hold"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::reports
