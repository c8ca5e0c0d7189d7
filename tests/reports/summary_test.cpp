#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "reports/model/answer.h"
#include "reports/model/crossovers.h"
#include "reports/model/equal_levels.h"
#include "reports/model/findings.h"
#include "reports/model/number_text.h"
#include "reports/model/scene.h"
#include "reports/model/scores.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

TEST(Summary, OneSceneInOrderTheReferenceFirst) {
  StoreContents contents = made_up_contents();
  std::swap(contents.measurements[0], contents.measurements[1]);  // flat first
  const auto scenes = scenes_of(contents);
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].representations, (std::vector<std::string>{"mesh", "flat"}));
  EXPECT_EQ(scenes[0].agents, (std::vector<uint32_t>{1, 10, 100, 250, 1000}));
  EXPECT_EQ(scenes[0].occupancies, (std::vector<double>{0.15, 0.9}));
  EXPECT_EQ(scenes[0].agent_comparisons.size(), 9U);
  EXPECT_EQ(scenes[0].crowd_comparisons.size(), 1U);
  EXPECT_EQ(scenes[0].pictures.size(), 3U);
}

TEST(Summary, ARowMeasuredAgainReplacesTheOlder) {
  StoreContents contents = made_up_contents();
  MeasurementRow again = contents.measurements[0];
  again.id = 999;
  again.cpu_ns->median = 42;
  const size_t before = scenes_of(contents)[0].rows.size();
  contents.measurements.push_back(again);
  const auto scenes = scenes_of(contents);
  EXPECT_EQ(scenes[0].rows.size(), before);
  EXPECT_EQ(scenes[0].find("mesh", 1, 0.15)->cpu_ns->median, 42);
}

TEST(Summary, AnotherMachineOrCharacterIsAnotherScene) {
  StoreContents contents = made_up_contents();
  RunRow run = contents.runs[0];
  run.id = 2;
  run.gl_renderer = "a GPU";
  contents.runs.push_back(run);
  MeasurementRow row = contents.measurements[0];
  row.run = 2;
  contents.measurements.push_back(row);
  row.run = 1;
  row.key.character = "robot";
  contents.measurements.push_back(row);
  EXPECT_EQ(scenes_of(contents).size(), 3U);
}

// The scene of made-up rows at 15 %, its ratios as given: by agents the ratio, its interval a factor of 0.97 and 1.04.
std::vector<CrossoverLine> lines_with(StoreContents& contents, const std::map<uint32_t, double>& ratios) {
  std::erase_if(contents.measurements, [&](const MeasurementRow& row) {
    return !ratios.contains(row.key.agents) || row.key.requested_occupancy > 0.5;
  });
  for (RatioRow& row : contents.ratios)
    if (row.kind == "speed" && ratios.contains(row.of.agents)) {
      row.ratio = ratios.at(row.of.agents);
      row.low = 0.97 * row.ratio;
      row.high = 1.04 * row.ratio;
    }
  return crossovers_of(scenes_of(contents)[0], "cpu");
}

// A ratio of agents / 10: the ends of its interval pass 1 where it is 1 / 1.04 and 1 / 0.97.
TEST(Crossovers, ByHandFromThePairedRatios) {
  StoreContents contents = made_up_contents();
  const auto lines = lines_with(contents, {{1, 0.1}, {100, 10}});
  ASSERT_EQ(lines.size(), 1U);
  ASSERT_TRUE(lines[0].agents.has_value());
  EXPECT_NEAR(*lines[0].agents, 10, 1e-9);
  EXPECT_NEAR(lines[0].agents_low, 10 / 1.04, 1e-9);
  EXPECT_NEAR(lines[0].agents_high, 10 / 0.97, 1e-9);
  EXPECT_NEAR(lines[0].time_ns, 1e6, 1e-3) << "0.1 ms an agent";
  EXPECT_EQ(lines[0].cheaper_below, "mesh");
  EXPECT_EQ(lines[0].cheaper_beyond, "flat");
}

// Intervals that hold 1 everywhere: medians on either side of 1 are no crossing.
TEST(Crossovers, WhatTheIntervalsDoNotCarryIsNotSaid) {
  StoreContents contents = made_up_contents();
  const auto lines = lines_with(contents, {{100, 0.99}, {250, 1.01}, {1000, 0.98}});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_FALSE(lines[0].agents.has_value());
  EXPECT_EQ(lines[0].cheaper_beyond, "");
  EXPECT_EQ(crossover_text(lines[0]), "not distinguishable from 100 to 1,000 agents");
}

TEST(Crossovers, AStretchThatIsNotDistinguishableIsTheIntervalInAgents) {
  StoreContents contents = made_up_contents();
  const auto lines = lines_with(contents, {{1, 2}, {10, 1.01}, {100, 0.99}, {1000, 0.5}});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].cheaper_beyond, "mesh");
  EXPECT_LT(lines[0].agents_low, 10);
  EXPECT_GT(lines[0].agents_high, 100);
  EXPECT_NEAR(*lines[0].agents, std::sqrt(1000), 1) << "half way between 1.01 and 0.99";
}

TEST(Crossovers, WithoutOneItIsSaidWhoIsCheaperAndWhere) {
  StoreContents contents = made_up_contents();
  EXPECT_EQ(crossover_text(lines_with(contents, {{1, 5}, {10, 5}, {100, 5}, {1000, 5}})[0]),
            "flat is the cheaper one from 1 to 1,000 agents");
  contents = made_up_contents();
  EXPECT_EQ(crossover_text(lines_with(contents, {{1, 1}, {10, 0.5}, {100, 0.5}, {1000, 1}})[0]),
            "mesh is the cheaper one from 10 to 100 agents; elsewhere from 1 to 1,000 agents they are not "
            "distinguishable");
}

TEST(Summary, ScoresByHeightByHand) {
  const StoreContents contents = made_up_contents();
  const auto scenes = scenes_of(contents);
  const auto scores = scores_by_height(scenes[0], "silhouette_iou");
  ASSERT_EQ(scores.size(), 3U);
  EXPECT_EQ(scores[1].height_px, 64.0);
  EXPECT_EQ(scores[1].views, 3U);
  EXPECT_NEAR(scores[1].mean, 0.99 - 0.06 - 0.045, 1e-12);
  EXPECT_NEAR(scores[1].least, 0.93 - 0.09, 1e-12);
  EXPECT_NEAR(scores[1].greatest, 0.93, 1e-12);
  EXPECT_TRUE(scores_by_height(scenes[0], "psnr").empty());  // absent everywhere: no figure is made up
}

TEST(Summary, DescribedScoresComeInOrderAndUnknownOnesLast) {
  StoreContents contents = made_up_contents();
  contents.comparisons[0].scores.push_back({"ssim.least", 0.25, ""});
  contents.comparisons[0].scores.push_back({"aardvark", 7, ""});
  const auto scenes = scenes_of(contents, made_up_scores());
  std::vector<std::string> names;
  for (const ScoreDoc& doc : scenes[0].scores) names.push_back(doc.name);
  EXPECT_EQ(names, (std::vector<std::string>{"silhouette_iou", "ssim", "ssim.least", "ssim_union", "psnr", "mae",
                                             "aardvark", "boundary_px_mean"}));
  EXPECT_EQ(scenes[0].scores[2].title, "SSIM, least") << "a pooled figure of a described score";
  EXPECT_FALSE(scenes[0].scores[2].headline);
  EXPECT_EQ(scenes[0].scores[6].title, "aardvark");

  const AgentScoreTable table = agent_score_table(scenes[0]);
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[1].height_px, 64);
  EXPECT_EQ(table.rows[1].views, 3U);
  ASSERT_EQ(table.columns.size(), 6U) << "PSNR is absent everywhere, MAE of single agents too";
  ASSERT_TRUE(table.rows[1].cells[0]);
  EXPECT_EQ(table.rows[1].cells[0]->mean, "0.885");
  EXPECT_EQ(table.rows[1].cells[0]->worst, "0.840");
  EXPECT_FALSE(table.rows[1].cells[2]) << "one view of another height has it";
  EXPECT_EQ(headline_scores(scenes[0], *scenes[0].crowd_comparisons[0]), "SSIM 0.950");
}

TEST(Scores, AreWrittenByTheirDescription) {
  const std::vector<ScoreDoc> docs = made_up_scores();
  EXPECT_EQ(heading(docs[4]), "Mean absolute error, code values");
  EXPECT_EQ(heading(docs[1]), "SSIM");
  EXPECT_EQ(score_text(docs[4], 1.239), "1.24");
  EXPECT_EQ(score_text(docs[3], INFINITY), "∞");
  EXPECT_EQ(best_text(docs[3]), ", ∞ is equal");
  EXPECT_EQ(best_text(doc_of(docs, "unheard")), "");
  EXPECT_EQ(worst_of(docs[4], {"flat", 64, 2, 1, 3, 5}), 3);
  EXPECT_EQ(worst_of(docs[0], {"flat", 64, 2, 1, 3, 5}), 1);
}

TEST(Summary, TheAnswerNamesTheSpeedItsIntervalTheCrossingAndTheOverlap) {
  const StoreContents contents = made_up_contents();
  const auto scenes = scenes_of(contents, made_up_scores());
  const auto sentences = answer(scenes[0]);
  ASSERT_EQ(sentences.size(), 3U);  // two occupancies and the difference
  EXPECT_EQ(sentences[0],
            "With 1,000 agents covering 15 % of a 640 × 480 picture, flat is 50.0 times as fast as mesh of 5,000 "
            "triangles (95 % interval "
            "48.5 to 52.0, 24 interleaved pairs). No level of detail of mesh was timed beside it. Against mesh: from "
            "about 10 agents on (95 % interval 10 to 10), flat is the cheaper one.");
  EXPECT_TRUE(sentences[1].starts_with("With 250 agents covering 90 %")) << sentences[1];
  EXPECT_EQ(
      sentences[2],
      "Seen 64 pixels tall in 3 views, flat has against mesh, on average, silhouette IoU 0.885 (0.840 in the worst "
      "view, 1 is equal); SSIM 0.835 (0.790 in the worst view, 1 is equal).");
  const auto glance = tiles(scenes[0]);
  ASSERT_EQ(glance.size(), 4U);
  EXPECT_EQ(glance[0].figure, "50.0×");
  EXPECT_EQ(glance[0].meaning,
            "the speed of flat over that of mesh of 5,000 triangles, with 1,000 agents at 15 % occupancy");
  EXPECT_EQ(glance[1].figure, "10 agents");
  EXPECT_EQ(glance[2].figure, "0.885");
  EXPECT_EQ(glance[2].meaning, "silhouette IoU, 64 pixels tall (mean of 3 views, 1 is equal)");
  EXPECT_EQ(glance[3].figure, "170.7 MiB");
}

// Every row of a level of `triangles`: the times of flat, four times as fast as the mesh.
void add_level(StoreContents& contents, uint64_t triangles) {
  const std::string name = "mesh:triangles=" + std::to_string(triangles);
  for (const MeasurementRow& row : std::vector<MeasurementRow>(contents.measurements)) {
    if (row.key.representation != "flat") continue;
    contents.measurements.push_back(row);
    contents.measurements.back().key.representation = name;
    contents.measurements.back().triangles_per_agent = triangles;
  }
  for (const RatioRow& row : std::vector<RatioRow>(contents.ratios)) {
    if (row.of.representation != "flat" || row.kind != "speed") continue;
    contents.ratios.push_back(row);
    contents.ratios.back().of.representation = name;
    contents.ratios.back().ratio = 4;
    contents.ratios.back().low = 3.9;
    contents.ratios.back().high = 4.1;
  }
}

TEST(Summary, ASpeedStandsBesideALevelOfDetail) {
  StoreContents contents = made_up_contents();
  contents.runs[0].arguments = "bench --representation flat,mesh:triangles=500";
  add_level(contents, 500);
  const auto scenes = scenes_of(contents, made_up_scores());
  EXPECT_EQ(subjects_of(scenes[0]), (std::vector<std::string>{"flat", "mesh:triangles=500"}));
  const auto sentences = answer(scenes[0]);
  EXPECT_NE(sentences[0].find("flat is 50.0 times as fast as mesh"), std::string::npos);
  EXPECT_NE(sentences[0].find("It is 12.5 times as fast as mesh:triangles=500, a level of detail of mesh."),
            std::string::npos)
      << sentences[0];
  EXPECT_NE(tiles(scenes[0])[0].meaning.find("12.5× that of mesh:triangles=500"), std::string::npos);
  size_t own = 0;
  for (const std::string& sentence : sentences)
    if (sentence.find("mesh:triangles=500 is") != std::string::npos) {
      ++own;
      EXPECT_EQ(sentence.find("level of detail"), std::string::npos) << "the level itself: " << sentence;
    }
  EXPECT_GT(own, 0U);
}

// Levels that nobody named are there to set others against: no answers of their own.
TEST(Summary, ALevelThatWasAddedIsARulerAndNoAnswer) {
  StoreContents contents = made_up_contents();
  contents.runs[0].arguments = "bench made-up.toml --representation mesh:triangles=5000";  // another than is added
  add_level(contents, 500);
  add_level(contents, 2000);
  const auto scenes = scenes_of(contents, made_up_scores());
  EXPECT_TRUE(is_ruler(scenes[0], "mesh:triangles=500"));
  EXPECT_FALSE(is_ruler(scenes[0], "mesh"));
  EXPECT_FALSE(is_ruler(scenes[0], "flat"));
  EXPECT_EQ(subjects_of(scenes[0]), std::vector<std::string>{"flat"});
  for (const std::string& sentence : answer(scenes[0]))
    EXPECT_EQ(sentence.find("mesh:triangles="), std::string::npos) << sentence;
  EXPECT_NE(answer(scenes[0])[0].find("As cheap would be a level of fewer than 500 triangles"), std::string::npos)
      << answer(scenes[0])[0];
  EXPECT_NE(tiles(scenes[0])[0].meaning.find("; a level of fewer than 500 triangles would be as cheap"),
            std::string::npos)
      << tiles(scenes[0])[0].meaning;
  // A sweep draws what its plan lists; and where there are levels alone they are what it is about.
  contents.runs[0].command = "sweep";
  EXPECT_EQ(subjects_of(scenes_of(contents)[0]).size(), 3U);
  contents.runs[0].command = "bench";
  std::erase_if(contents.measurements, [](const MeasurementRow& row) { return row.key.representation == "flat"; });
  EXPECT_EQ(subjects_of(scenes_of(contents)[0]),
            (std::vector<std::string>{"mesh:triangles=500", "mesh:triangles=2000"}));
}

TEST(Summary, AReferenceFarAboveItsFloorVoidsTheFigures) {
  StoreContents contents = made_up_contents();
  EXPECT_FALSE(void_notice(scenes_of(contents)[0]).has_value());  // 1.12
  for (RatioRow& row : contents.ratios)
    if (row.kind == "floor" && row.of.representation == "flat") row.ratio = 3;  // another's floor voids nothing
  EXPECT_FALSE(void_notice(scenes_of(contents)[0]).has_value());
  for (RatioRow& row : contents.ratios)
    if (row.kind == "floor" && row.of.representation == "mesh" && row.of.agents == 100) row.ratio = 1.41;
  const auto scenes = scenes_of(contents);
  ASSERT_TRUE(void_notice(scenes[0]).has_value());
  EXPECT_NE(void_notice(scenes[0])->find("1.41 times its own floor"), std::string::npos);
  EXPECT_NE(tiles(scenes[0])[0].meaning.find("void"), std::string::npos);
}

TEST(Summary, NumbersForPeople) {
  EXPECT_EQ(count_text(0), "0");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(1000), "1,000");
  EXPECT_EQ(count_text(1234567), "1,234,567");
  EXPECT_EQ(time_text(1234), "1.2 µs");
  EXPECT_EQ(time_text(1.234e6), "1.23 ms");
  EXPECT_EQ(time_text(12.34e6), "12.3 ms");
  EXPECT_EQ(time_text(1234e6), "1234 ms");
  EXPECT_EQ(time_text(12340e6), "12.3 s");
  EXPECT_EQ(bytes_text(1023), "1023 B");
  EXPECT_EQ(bytes_text(1536), "1.5 KiB");
  EXPECT_EQ(bytes_text(uint64_t{3} << 30), "3.00 GiB");
  EXPECT_EQ(percent_text(0.15), "15 %");
  EXPECT_EQ(percent_text(0.123), "12.3 %");
  EXPECT_EQ(factor_text(1.234), "1.23");
  EXPECT_EQ(factor_text(12.34), "12.3");
  EXPECT_EQ(factor_text(123.4), "123");
}

// ---- causes and switches

CauseRangeRow made_up_range(double from, std::optional<double> below, const std::string& words) {
  CauseRangeRow row;
  row.run = 1;
  row.representation = "flat";
  row.reference = "mesh";
  row.character = "mannequin";
  row.unit = "view";
  row.from = from;
  row.below = below;
  row.words = words;
  return row;
}

TEST(Findings, CausesAreOneSentenceARepresentation) {
  StoreContents contents;
  contents.cause_ranges = {made_up_range(0, 60, "below 60 pixels: the view"), made_up_range(60, {}, "more: unclear"),
                           made_up_range(0, {}, "of another run")};
  contents.cause_ranges[2].run = 2;
  EXPECT_EQ(cause_sentences(contents, 1),
            (std::vector<std::string>{"flat against mesh, views of one agent of mannequin: the error is dominated by: "
                                      "below 60 pixels: the view; more: unclear."}));
  EXPECT_TRUE(cause_sentences(contents, 3).empty());
}

TEST(Findings, TheTableHasAColumnForEachCauseOfAnyRange) {
  StoreContents contents;
  contents.cause_ranges = {made_up_range(0, 60, ""), made_up_range(60, {}, "")};
  contents.cause_ranges[0].shares = {{"view", "the view", 0.624}, {"pose", "the pose", -0.004}};
  contents.cause_ranges[0].residue = 0.38;
  contents.cause_ranges[1].shares = {{"texture", "the texture", 1}};
  const CauseTable table = cause_table(contents, 1);
  EXPECT_EQ(table.titles, (std::vector<std::string>{"the view", "the pose", "the texture", "no cause"}));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0].shares, (std::vector<std::string>{"62 %", "0 %", "–", "38 %"}));
  EXPECT_EQ(table.rows[1].shares, (std::vector<std::string>{"–", "–", "100 %", "0 %"}));
  EXPECT_EQ(table.rows[1].range, &contents.cause_ranges[1]);
  EXPECT_TRUE(cause_table(contents, 2).titles.empty());
  EXPECT_EQ(height_range_text(made_up_range(0, 15, "")), "below 15");
  EXPECT_EQ(height_range_text(made_up_range(60, 120, "")), "60 to 120");
  EXPECT_EQ(height_range_text(made_up_range(480, {}, "")), "480 and more");
}

PopRow made_up_switch(uint32_t agent, uint64_t pixels, std::optional<double> value) {
  PopRow row;
  row.run = 1;
  row.representation = "hybrid";
  row.from = "mesh";
  row.to = "flat";
  row.agent = agent;
  row.tick = 4;
  row.distance = 12.25;
  row.pixels = pixels;
  row.display = "a display";
  row.scores = {{"s", value}};
  return row;
}

TEST(Findings, TheWorstSwitchThatIsSeenComesFirst) {
  StoreContents contents;
  contents.pops = {made_up_switch(3, 50, 0.75), made_up_switch(3, 0, 0.0), made_up_switch(8, 9, 0.5),
                   made_up_switch(9, 9, std::nullopt)};
  ScoreDoc doc;
  doc.name = "s";
  doc.title = "likeness";
  doc.digits = 2;
  doc.headline = true;
  EXPECT_EQ(score_of(contents.pops[2], "s"), 0.5);
  EXPECT_EQ(score_of(contents.pops[2], "t"), std::nullopt);
  const std::vector<PopList> lists = pop_lists(contents, 1, {doc}, 2);
  ASSERT_EQ(lists.size(), 1U);
  EXPECT_EQ(lists[0].switches, 4U);
  EXPECT_EQ(lists[0].seen, 3U);
  EXPECT_EQ(lists[0].display, "a display");
  EXPECT_EQ(lists[0].worst, (std::vector<const PopRow*>{&contents.pops[2], &contents.pops[0]}));
  EXPECT_EQ(pop_sentences(contents, 1, {doc}),
            std::vector<std::string>{"hybrid: 4 switches of 3 agents, 3 of them seen. The most visible: agent 8 at "
                                     "tick 4, 12.2 m away, from mesh to flat: likeness 0.50."});
  contents.pops = {made_up_switch(3, 0, std::nullopt)};
  EXPECT_EQ(pop_sentences(contents, 1, {doc}),
            std::vector<std::string>{"hybrid: 1 switch of 1 agent, 0 of them seen."});
  EXPECT_TRUE(pop_sentences(contents, 2, {doc}).empty());
}

}  // namespace
}  // namespace crowdbench::reports
