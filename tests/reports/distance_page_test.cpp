#include "reports/page/distance_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/distance_chart.h"
#include "reports/model/distance_series.h"
#include "reports/model/lead.h"
#include "reports/page/libraries.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ScoreDoc doc() {
  ScoreDoc out;
  out.name = "s";
  out.title = "sharpness";
  out.unit = "dB";
  out.digits = 1;
  return out;
}

DistanceGraph graph() {
  DistanceSeries a;
  a.representation = "<a>";
  a.bins = {{5, 20, 18, 22, 7}, {10, 30, 25, kInfinity, 6}, {15, kInfinity, 40, kInfinity, 6}};
  a.points = {{5, 21, 3}, {14, kInfinity, 4}};
  a.thresholds = {{25, "from 7.5 m on (95 %: 6 to 9)", "reached"}};
  DistanceSeries b;
  b.representation = "b";
  b.bins = {{5, 10, 9, 11, 7}};
  b.thresholds = {{25, "not reached", "not_reached"}};
  return {"distance", "m", false, {a, b}};
}

StoreContents one_curve() {
  StoreContents contents;
  CurveRow curve;
  curve.id = curve.run = 1;
  curve.representation = "flat";
  curve.character = "walker";
  curve.score = "s";
  curve.against = "distance_m";
  CurveBinRow bin;
  bin.x = 5;
  curve.bins = {bin};
  contents.curves = {curve};
  ThresholdRow row;
  row.id = row.run = row.curve = 1;
  row.status = "everywhere";
  contents.thresholds = {row};
  return contents;
}

TEST(Lead, TellsTheCostOfTheCurvesOwnCharacter) {
  const StoreContents contents = one_curve();
  RunRow run;
  run.headline = "cpu";
  RatioRow ratio;
  ratio.kind = "speed";
  ratio.of = {"flat", "robot", 100, 640, 480, 0.5};
  ratio.to = "mesh";
  ratio.metric = "cpu";
  ratio.ratio = ratio.low = ratio.high = 2;
  Scene scene;
  scene.run = &run;
  scene.character = "robot";
  scene.reference = "mesh";
  scene.occupancies = {0.5};
  scene.agents = {100};
  scene.take(ratio);
  const auto rows = [&] { return lead_of(contents, {scene}, {doc()}).rows; };
  ASSERT_EQ(rows().size(), 1U);
  EXPECT_EQ(rows()[0].character, "walker");
  EXPECT_EQ(rows()[0].cost, "not timed in this file");
  scene.character = "walker";
  EXPECT_EQ(rows()[0].cost, "0.5 of mesh’s time (0.5 to 0.5), 100 agents");
  RatioRow level = ratio;
  level.of.representation = "mesh:triangles=500";
  level.ratio = 3;
  scene.representations = {"mesh", "flat", "mesh:triangles=500"};
  scene.take(level);
  EXPECT_EQ(rows()[0].cost, "0.5 of mesh’s time (0.5 to 0.5), 100 agents; 1.5 of mesh:triangles=500’s");
}

TEST(Lead, TellsTunedRulesFirst) {
  StoreContents contents = one_curve();
  TuningRow tuning;
  tuning.character = "walker";
  tuning.score = "s";
  tuning.threshold = 8.5;
  tuning.switches = {{0, "mesh", "flat", 24.1, 22, 26, 0.97, true, 31.25, {}, {}, 0, {}},
                     {1, "flat", "relief", 10, {}, {}, 0.5, false, 75, {}, {}, 0, {}}};
  contents.tunings = {tuning};
  const Lead lead = lead_of(contents, {}, {doc()});
  ASSERT_EQ(lead.rows.size(), 3U);
  EXPECT_EQ(lead.rows[0].from, "from 31.2 m on, where figures are 24.1 px tall (95 %: 22.0 to 26.0 px)");
  EXPECT_EQ(lead.rows[0].score, "sharpness 8.5");
  EXPECT_EQ(lead.rows[1].representation, "relief");
  EXPECT_NE(lead.rows[1].from.find("(undecided)"), std::string::npos);
  EXPECT_NE(lead.basis.find("Rows of “tune”"), std::string::npos);
}

TEST(Lead, LeavesOutCurvesWithoutBins) {
  StoreContents contents = one_curve();
  contents.curves[0].bins.clear();
  EXPECT_TRUE(lead_of(contents, {}, {doc()}).rows.empty());
  EXPECT_TRUE(distance_scores(contents, 1, {doc()})[0].graphs[0].series[0].thresholds.empty());
}

TEST(DistanceChart, HoldsMediansBandsAgentsAndEachThresholdOnce) {
  const json spec = json::parse(distance_chart(doc(), graph()));
  const json& bins = spec.at("data").at("values");
  ASSERT_EQ(bins.size(), 4U);
  EXPECT_EQ(bins[0].at("low"), 18);
  EXPECT_EQ(bins[0].at("where"), "5 m");
  EXPECT_EQ(bins[0].at("text"), "20.0, 95 %: 18.0 to 22.0");
  EXPECT_TRUE(bins[1].at("high").is_null()) << "a band without an end is a gap";
  EXPECT_EQ(bins[1].at("value"), 30);
  EXPECT_TRUE(bins[2].at("value").is_null());
  const json& layers = spec.at("layer");
  EXPECT_EQ(layers[0].at("data").at("values"), json::parse(R"([{"representation": "<a>", "x": 5, "value": 21}])"));
  EXPECT_EQ(layers[3].at("data").at("values"), json::parse(R"([{"value": 25}])"));
  const json& colour = layers[2].at("encoding").at("color").at("scale");
  EXPECT_EQ(colour.at("domain"), json({"<a>", "b"}));
  EXPECT_NE(colour.at("range")[0], colour.at("range")[1]);
  EXPECT_FALSE(layers[2].at("encoding").at("x").at("scale").at("reverse").get<bool>());
  DistanceGraph by_height = graph();
  by_height.far_is_low = true;
  EXPECT_TRUE(json::parse(distance_chart(doc(), by_height))
                  .at("layer")[2]
                  .at("encoding")
                  .at("x")
                  .at("scale")
                  .at("reverse")
                  .get<bool>())
      << "near is on the left";
  DistanceGraph equal = graph();
  equal.series.pop_back();
  equal.series[0].bins = {{5, kInfinity, kInfinity, kInfinity, 7}};
  EXPECT_EQ(distance_chart(doc(), equal), "");
}

TEST(DistancePage, SaysWhatCountsAndWhereThresholdsAreReached) {
  try {
    chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  DistancePage page;
  page.scene = "9 agents";
  page.reference = "the <right> one";
  page.counts = "7 counted, 2 occluded";
  page.display = "somewhere";
  page.renderer = "a pencil";
  page.scores.push_back({doc(), {graph()}});
  const std::string html = distance_page(page);
  for (const char* text :
       {"9 agents, against the &lt;right&gt; one: 7 counted, 2 occluded.", "Sharpness, dB by distance",
        "<td class=\"wrap\">&lt;a&gt;</td><td class=\"wrap\">sharpness</td><td>25</td>", "from 7.5 m on (95 %: 6 to 9)",
        "not reached"})
    EXPECT_NE(html.find(text), std::string::npos) << text;
  page.scores[0].graphs[0].series[0].thresholds.clear();
  page.scores[0].graphs[0].series[1].thresholds.clear();
  EXPECT_EQ(distance_page(page).find("or better than"), std::string::npos);
  EXPECT_EQ(html.find("squared error"), std::string::npos);
  page.causes = {{"<a>", "below 60 pixels: the stored view"}};
  EXPECT_NE(distance_page(page).find("<li>&lt;a&gt;: below 60 pixels: the stored view</li>"), std::string::npos);
}

// ---- rows to series

CurveRow curve_row(int64_t id, const std::string& against) {
  CurveRow row;
  row.id = id;
  row.run = 1;
  row.representation = "flat";
  row.score = "s";
  row.against = against;
  row.agents = 12;
  row.bins = {{0, 1, 4, 2.5, 10, 9, 11, 6, 6}, {1, 4, 9, 6.25, 20, 18, 22, 6, 6}};
  return row;
}

TEST(DistanceSeries, AThresholdIsSaidByWhereItIsReached) {
  const CurveRow curve = curve_row(1, "distance_m");
  ThresholdRow row{0, 1, 1, 15, "reached", 4.25, 4, std::nullopt};
  EXPECT_EQ(threshold_text(row, curve), "from 4.25 m on (95 %: 4 to farther than any)");
  row.low = std::nullopt;
  row.high = 5;
  EXPECT_EQ(threshold_text(row, curve), "from 4.25 m on (95 %: nearer than any to 5)");
  row.status = "everywhere";
  EXPECT_EQ(threshold_text(row, curve), "already at the nearest, 2.5 m");
  row.status = "not_reached";
  EXPECT_EQ(threshold_text(row, curve), "not reached at the farthest, 6.25 m");
  EXPECT_EQ(threshold_text(row, curve_row(1, "pixels_per_texel")), "not reached at the farthest, 6.25 pixels a texel");
  row = {0, 1, 1, 15, "not_distinguishable", std::nullopt, std::nullopt, std::nullopt};
  EXPECT_EQ(
      threshold_text(row, curve),
      "not distinguishable with 12 agents; by the medians not reached (95 %: nearer than any to farther than any)");
}

TEST(DistanceSeries, CurvesOfOneRunByScoreAndAxisWithTheirAgents) {
  StoreContents contents;
  contents.curves = {curve_row(1, "distance_m"), curve_row(2, "height_px"), curve_row(3, "distance_m")};
  contents.curves[2].run = 2;
  contents.thresholds = {{0, 1, 1, 15, "everywhere", std::nullopt, std::nullopt, std::nullopt}};
  ComparisonRow agent;
  agent.run = 1;
  agent.kind = "agent_in_crowd";
  agent.representation = "flat";
  agent.state = "counted";
  agent.distance = 3.5;
  agent.agent = 7;
  agent.scores = {{"s", 12.5, ""}, {"other", 1.0, ""}};
  contents.comparisons = {agent, agent, agent};
  contents.comparisons[1].state = "occluded";
  contents.comparisons[2].scores[0].value = std::nullopt;
  const std::vector<DistanceScore> scores = distance_scores(contents, 1, {doc()});
  ASSERT_EQ(scores.size(), 1U);
  EXPECT_EQ(scores[0].doc.title, "sharpness");
  ASSERT_EQ(scores[0].graphs.size(), 2U) << "against pixels a texel there is no curve";
  EXPECT_EQ(scores[0].graphs[0].against, "distance from the eye");
  EXPECT_TRUE(scores[0].graphs[1].far_is_low) << "small figures are far away";
  const DistanceSeries& series = scores[0].graphs[0].series.at(0);
  ASSERT_EQ(series.points.size(), 1U) << "the agent that is seen and scored";
  EXPECT_EQ(series.points[0].x, 3.5);
  EXPECT_EQ(series.points[0].value, 12.5);
  EXPECT_EQ(series.points[0].agent, 7U);
  ASSERT_EQ(series.bins.size(), 2U);
  EXPECT_EQ(series.bins[1].value, 20);
  ASSERT_EQ(series.thresholds.size(), 1U);
  EXPECT_EQ(series.thresholds[0].place, "already at the nearest, 2.5 m");
  EXPECT_TRUE(scores[0].graphs[1].series.at(0).points.empty()) << "agents are drawn against distance alone";
  EXPECT_TRUE(distance_scores(contents, 3, {doc()}).empty());
  EXPECT_EQ(distance_axes().size(), 3U);
}

}  // namespace
}  // namespace crowdbench::reports
