#include "reports/page/tune_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_io.h"
#include "reports/charts/tune_chart.h"
#include "reports/model/tune_model.h"
#include "reports/page/libraries.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

TuneGraph made_up_graph() {
  TuneGraph graph;
  graph.doc = made_up_scores()[4];
  graph.threshold = 10;
  TuneCurve near{"near", {}, {}};
  TuneCurve far{"<far>", {}, {}};
  const double depths[] = {2, 8, 32};
  for (size_t i = 0; i < 3; ++i) {
    const double height = 160 / depths[i];
    near.points.push_back({height, depths[i], 0.0, 0.0, 0.0, true, i < 2});
    far.points.push_back({height, depths[i], 12.0 - 2 * static_cast<double>(i), 11.0 - 2 * static_cast<double>(i),
                          i == 0 ? INFINITY : 13.0 - 2 * static_cast<double>(i), i == 2, i == 2});
  }
  near.costs = {{80, 2, 4000, 3900, 4100}, {5, 32, 3000, {}, {}}};
  far.costs = {{80, 2, 1000, 900, 1100}};
  graph.curves = {near, far};
  graph.marks = {{"<far>", 32, false, "from 32 m"}, {"<far>", 16, true, "one texel"}, {"<far>", 900, true, "beyond"}};
  return graph;
}

TEST(TuneChart, HasErrorsWithBandsThresholdAndLinesWhereItChanges) {
  const json spec = json::parse(tune_error_chart(made_up_graph()));
  const json& values = spec.at("data").at("values");
  ASSERT_EQ(values.size(), 6U);
  EXPECT_EQ(values[4].at("value"), 10);
  EXPECT_EQ(values[4].at("low"), 9);
  EXPECT_EQ(values[4].at("where"), "8.0 m, 20.0 px tall");
  EXPECT_EQ(values[4].at("text"), "10.00, 95 %: 9.00 to 11.00; not allowed");
  EXPECT_TRUE(values[3].at("high").is_null()) << "a band without an end is a gap";
  EXPECT_FALSE(values[4].at("chosen").get<bool>());
  EXPECT_TRUE(values[5].at("chosen").get<bool>());
  const json& layers = spec.at("layer");
  ASSERT_EQ(layers.size(), 6U) << "bands, lines, points, threshold, switches, rules of thumb";
  EXPECT_EQ(layers[3].at("data").at("values"), json::parse(R"([{"value": 10}])"));
  EXPECT_EQ(layers[4].at("data").at("values").size(), 1U);
  EXPECT_EQ(layers[5].at("data").at("values").size(), 1U) << "what is beyond the heights would stretch the axis";
  EXPECT_TRUE(layers[5].at("mark").contains("strokeDash"));
  TuneGraph budget = made_up_graph();
  budget.bounded = false;
  EXPECT_EQ(json::parse(tune_error_chart(budget)).at("layer").size(), 5U) << "a budget has no threshold";
  for (TuneCurve& curve : budget.curves)
    for (TunePoint& point : curve.points) point.tail = std::nullopt;
  EXPECT_EQ(tune_error_chart(budget), "");
}

TEST(TuneChart, HasCostsAsTheyWereTimed) {
  const json spec = json::parse(tune_cost_chart(made_up_graph()));
  const json& values = spec.at("data").at("values");
  ASSERT_EQ(values.size(), 3U);
  EXPECT_EQ(values[0].at("value"), 4);
  EXPECT_EQ(values[0].at("text"), "4 µs, 95 %: 3.9 to 4.1");
  EXPECT_TRUE(values[1].at("low").is_null());
  EXPECT_NE(values[1].at("text").get<std::string>().find("within the noise"), std::string::npos);
  TuneGraph untimed = made_up_graph();
  for (TuneCurve& curve : untimed.curves) curve.costs.clear();
  EXPECT_EQ(tune_cost_chart(untimed), "");
}

TunePage made_up_page() {
  TunePage page;
  page.title = "Which <one>";
  page.under = "a walker";
  page.broken = {"it does NOT hold"};
  page.answer = {"From the eye to 32 m draw near; from there on <far>."};
  page.software = true;
  page.switches = {
      {"near", "<far>", "5.0", "4.0 to 6.0", "8.0", "32.0", "27 to 40", "0.50", "2.0 %", "error 3", "sure"}};
  page.draws_as = "hybrid(near,far)";
  const TunePagePicture picture{"what differs", 8, 8, encode_png(Image8(8, 8, 3))};
  page.pictures = {{"near to far", {picture, picture, picture}}};
  page.picture_scale = "dark is equal";
  page.picture_bar = picture;
  TunePageCharacter character;
  character.name = "a walker";
  character.measured = "4 views";
  character.alone = {"By itself: the same."};
  character.graph = made_up_graph();
  character.rows = {{"80.0", "2.0", "1", "0.00", "4.00", "12.00", "1.00"},
                    {"5.0", "32.0", "10", "0.00", "3.00", "8.00", "0.90"}};
  character.chosen = {0, 1};
  character.notes = {"relief is left out: too large"};
  page.characters = {character};
  page.rules = {{"<far>", "one texel a pixel", "5.0", "32.0", "10.0", "16.0", "error 11", "not enough (10)", "0.95"}};
  page.engines = {{"<far>", "32.00", "1.23", "0.0456", "32.00", "–"}};
  page.engine_notes = {"of a walker"};
  page.lens_verdict = "one rule holds";
  page.lens_lines = {"<far> at 5 pixels"};
  page.lenses = {{"720", "30", "<far>", "5.0", "8.1", "8.0", "1 of 24", "keeps the promise"}};
  page.proof_lines = {"promised: 2 times"};
  page.seeds = {{"17", "proof", "2.01", "1.9 to 2.1", "4.00", "2.00"}};
  page.facts = {{"seed", "1"}};
  return page;
}

class TunePageTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      chart_libraries();
    } catch (const Error&) {
      GTEST_SKIP() << "npm packages of the chart library absent at configure time";
    }
  }
  // Without the chart library's own texts.
  static std::string shown(const TunePage& page) {
    std::string html = tune_page(page);
    if (const char* path = std::getenv("CROWDBENCH_KEEP_PAGE")) std::ofstream(path) << html;
    return html.substr(0, html.find("<footer"));
  }
};

TEST_F(TunePageTest, TellsWhatDoesNotHoldThenTheAnswerThenWhatItIsFrom) {
  const std::string html = shown(made_up_page());
  size_t last = 0;
  for (const char* text : {"it does NOT hold",
                           "From the eye to 32 m draw near; from there on &lt;far&gt;.",
                           "Drawn by a software rasteriser",
                           "<td class=\"l\">&lt;far&gt;</td><td class=\"l\">near</td><td>5.0</td><td>4.0 to "
                           "6.0</td><td>8.0</td><td>32.0</td>",
                           "<code>hybrid(near,far)</code>",
                           "near to far",
                           "data:image/png",
                           "Error and cost by distance: a walker",
                           "By itself: the same.",
                           "Mean absolute error, code values: the worst 5 % of the figures",
                           "Time of one more agent",
                           "<td><b>8.00</b></td>",
                           "relief is left out",
                           "not enough (10)",
                           "<td>0.0456</td>",
                           "one rule holds.",
                           "keeps the promise",
                           "promised: 2 times",
                           "<td>17</td>",
                           "<dt>seed</dt><dd>1</dd>"}) {
    const size_t at = html.find(text, last);
    ASSERT_NE(at, std::string::npos) << text << " is not there, or before what it should follow";
    last = at;
  }
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
}

TEST_F(TunePageTest, LeavesOutWhatWasNotAskedFor) {
  TunePage page = made_up_page();
  page.broken.clear();
  page.software = false;
  page.switches.clear();
  page.pictures.clear();
  page.rules.clear();
  page.engines.clear();
  page.lens_verdict.clear();
  page.proof_lines.clear();
  page.draws_as.clear();
  const std::string html = shown(page);
  for (const char* text : {"banner\"", "The switches", "What a change shows", "Rules of thumb beside", "In engines",
                           "The same rule in other", "What is promised", "Draws as"})
    EXPECT_EQ(html.find(text), std::string::npos) << text;
}

}  // namespace
}  // namespace crowdbench::reports
