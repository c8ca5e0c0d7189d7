#include "reports/page/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/error.h"
#include "reports/charts/charts.h"
#include "reports/page/libraries.h"
#include "reports/page/points_section.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

class ReportPage : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_libraries()) GTEST_SKIP() << "npm packages of the chart library absent at configure time";
    page_ = report_page(made_up_contents(), {"made-up.sqlite", made_up_scores()});
    if (const char* path = std::getenv("CROWDBENCH_KEEP_PAGE")) std::ofstream(path) << page_;
  }
  // The page without the contents of its scripts and styles.
  std::string markup() const {
    std::string text;
    size_t at = 0;
    for (size_t open = page_.find("<script"); open != std::string::npos; open = page_.find("<script", at)) {
      const size_t end = page_.find('>', open);
      text += page_.substr(at, end + 1 - at);
      at = page_.find("</script>", end);
    }
    return text + page_.substr(at);
  }
  std::string page_;
};

TEST_F(ReportPage, HasNoHeadingOfPicturesWithoutPictures) {
  const std::string heading = "<h2>The same crowd, the same view</h2>";
  EXPECT_NE(page_.find(heading), std::string::npos);
  EXPECT_NE(page_.find("<h3>flat: 100 agents, "), std::string::npos) << "each says which representation it is of";
  StoreContents contents = made_up_contents();
  contents.pictures.clear();
  EXPECT_EQ(report_page(contents, {"made-up.sqlite", made_up_scores()}).find(heading), std::string::npos);
}

TEST_F(ReportPage, LoadsNothingFromOutside) {
  const std::string text = markup();
  const std::regex attribute(R"rx((src|href|srcset|poster|data|action|content)\s*=\s*"([^"]*)")rx");
  size_t pictures = 0;
  for (auto match = std::sregex_iterator(text.begin(), text.end(), attribute); match != std::sregex_iterator();
       ++match) {
    const std::string value = (*match)[2];
    EXPECT_EQ(value.find("http"), std::string::npos) << value;
    EXPECT_EQ(value.find("//"), std::string::npos) << value.substr(0, 80);
    if ((*match)[1] == "src") {
      EXPECT_TRUE(value.starts_with("data:image/png;base64,")) << value.substr(0, 80);
      ++pictures;
    }
  }
  EXPECT_EQ(pictures, 3U);
  EXPECT_EQ(text.find("<link"), std::string::npos);
  EXPECT_EQ(text.find("@import"), std::string::npos);
  EXPECT_EQ(text.find("url("), std::string::npos);
  EXPECT_NE(text.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(page_.find("sourceMappingURL"), std::string::npos);
}

TEST_F(ReportPage, ScriptTagsAreBalancedWhateverTheDataSay) {
  // Every "<script" opens one that "</script>" closes, and the scenario's hostile name opened none.
  size_t opened = 0;
  size_t closed = 0;
  for (size_t at = page_.find("<script"); at != std::string::npos; at = page_.find("<script", at + 1)) ++opened;
  for (size_t at = page_.find("</script"); at != std::string::npos; at = page_.find("</script", at + 1)) ++closed;
  EXPECT_EQ(opened, closed);
  const size_t charts = 2 + 1 + 2 + 2 + 2 + 2;  // time at two occupancies, speed, two scores; models, fronts, frames
  EXPECT_EQ(opened, charts + 3 + 1);            // three libraries and the page's own
  EXPECT_EQ(page_.find("<script>alert"), std::string::npos);
  EXPECT_NE(page_.find("plaza &lt;/script&gt;&lt;script&gt;alert(1)"), std::string::npos);
  EXPECT_NE(page_.find("# made up &amp; &lt;b&gt;bold&lt;/b&gt;"), std::string::npos);
  EXPECT_NE(page_.find("A CPU @ &quot;3&quot; GHz"), std::string::npos);
}

TEST_F(ReportPage, EveryChartIsJsonWithItsDataInside) {
  const std::string open = "<script type=\"application/json\"";
  size_t charts = 0;
  for (size_t at = page_.find(open); at != std::string::npos; at = page_.find(open, at + 1), ++charts) {
    const size_t begin = page_.find('>', at) + 1;
    const std::string text = page_.substr(begin, page_.find("</script>", begin) - begin);
    EXPECT_EQ(text.find('<'), std::string::npos);
    const nlohmann::json spec = nlohmann::json::parse(text);
    EXPECT_EQ(spec.at("$schema"), "https://vega.github.io/schema/vega-lite/v6.json");
    EXPECT_FALSE(spec.at("data").at("values").empty());
    EXPECT_EQ(text.find("\"url\""), std::string::npos);
  }
  EXPECT_EQ(charts, 11U);
}

TEST(ReportPageModel, ShowsFrontsWhereTooFewPointsWereTimedForAModel) {
  StoreContents contents = made_up_contents();
  std::erase_if(contents.measurements, [](const MeasurementRow& row) { return row.key.agents != 1000; });
  const std::string page = report_page(contents, {"made-up.sqlite", made_up_scores()});
  EXPECT_NE(page.find("a model takes 5 at least"), std::string::npos);
  EXPECT_NE(page.find("<h2>Time, bytes and error: 1,000 agents"), std::string::npos);
}

TEST_F(ReportPage, BeginsWithWhichOneFromWhereOn) {
  const size_t lead = page_.find("<h2>Which one, from where on</h2>");
  ASSERT_NE(lead, std::string::npos);
  EXPECT_LT(lead, page_.find("<h2>The same crowd, the same view</h2>"));
  EXPECT_NE(page_.find("is not in this file"), std::string::npos) << "nothing was scored against distance";

  StoreContents contents = made_up_contents();
  CurveRow curve;
  curve.id = 5;
  curve.run = 1;
  curve.representation = "flat";
  curve.reference = "mesh";
  curve.character = "mannequin";
  curve.score = "ssim";
  curve.against = "distance_m";
  curve.display = "a screen";
  curve.agents = 90;
  curve.bins = {{0, 5, 10, 7, 0.8, 0.75, 0.85, 90, 90}};
  contents.curves = {curve};
  ThresholdRow threshold;
  threshold.run = 1;
  threshold.curve = 5;
  threshold.value = 0.9;
  threshold.status = "reached";
  threshold.at = 12.5;
  threshold.low = 11;
  contents.thresholds = {threshold};
  const std::string page = report_page(contents, {"made-up.sqlite", made_up_scores()});
  const size_t row = page.find("SSIM 0.9");
  ASSERT_NE(row, std::string::npos);
  EXPECT_NE(page.find("from 12.5 m on (95 %: 11 to farther than any)", row), std::string::npos);
  EXPECT_NE(page.find("of mesh’s time (", row), std::string::npos) << "its cost, of the largest crowd";
  EXPECT_EQ(page.find("is not in this file"), std::string::npos);
}

TEST_F(ReportPage, ShowsTheRawFramesWhereTheRowsHoldThem) {
  const size_t frames = page_.find("<h2>The frames themselves</h2>");
  ASSERT_NE(frames, std::string::npos);
  EXPECT_NE(page_.find("\"ms\":2.002", frames), std::string::npos) << "flat's second frame of 1,000 agents";
  StoreContents contents = made_up_contents();
  for (MeasurementRow& row : contents.measurements) row.samples.clear();
  EXPECT_EQ(report_page(contents, {"made-up.sqlite", made_up_scores()}).find("The frames themselves"),
            std::string::npos);
}

TEST_F(ReportPage, SaysWhatAStrangerMustKnow) {
  EXPECT_NE(page_.find("Drawn by a software rasteriser"), std::string::npos);
  EXPECT_NE(page_.find("flat is 50.0 times as fast as mesh"), std::string::npos);
  EXPECT_NE(page_.find("at 250 agents a frame took 1.2 s, over the budget of 1 s"), std::string::npos);
  EXPECT_NE(page_.find("1 agents cover 62 % at most, 90 % were asked for"), std::string::npos);
  EXPECT_NE(page_.find("170.7 MiB"), std::string::npos);  // 178956970 bytes of textures
  EXPECT_NE(page_.find("∞"), std::string::npos);          // the PSNR of equal pictures
  EXPECT_EQ(page_.find("fps</th>"), std::string::npos);   // no frame rate from a software rasteriser
}

TEST_F(ReportPage, AGpuRunHasNoBannerAndHasFrameRates) {
  StoreContents contents = made_up_contents();
  contents.runs[0].software = false;
  const std::string page = report_page(contents, {"made-up.sqlite", made_up_scores()});
  EXPECT_EQ(page.find("Drawn by a software rasteriser"), std::string::npos);
  EXPECT_NE(page.find("1 % low, fps"), std::string::npos);
}

TEST_F(ReportPage, TheSameRowsGiveTheSameBytes) {
  EXPECT_EQ(page_, report_page(made_up_contents(), {"made-up.sqlite", made_up_scores()}));
}

// Each floor is explained by what its representation says of it, once; unknown ones are left out.
TEST_F(ReportPage, FloorsAreExplainedAsTheyAreGiven) {
  const std::string told = report_page(
      made_up_contents(), {"made-up.sqlite", made_up_scores(), {{"mesh", "one <pose>"}, {"absent", "nothing"}}});
  EXPECT_NE(told.find("That of mesh is one &lt;pose&gt;."), std::string::npos);
  EXPECT_EQ(told.find("That of absent"), std::string::npos);
  EXPECT_EQ(page_.find("That of"), std::string::npos);
  EXPECT_NE(page_.find("the same draw with the work removed"), std::string::npos);
}

// What `quality --causes --db` and `popping --db` leave, without any time.
TEST_F(ReportPage, SaysWhatDominatesAndHowSwitchesLookWithoutATimedRow) {
  const StoreContents whole = made_up_contents();
  StoreContents contents;
  contents.runs = whole.runs;
  for (const ComparisonRow& row : whole.comparisons)
    if (row.kind == "agent") contents.comparisons.push_back(row);
  CauseRangeRow range;
  range.run = 1;
  range.representation = "flat";
  range.reference = "mesh";
  range.character = "mannequin";
  range.unit = "view";
  range.below = 60;
  range.units = 6;
  range.total = 1000;
  range.dominant = "view";
  range.words = "below 60 pixels: the stored view (62 % of the squared error)";
  range.shares = {{"view", "the stored view", 0.62}, {"texture", "the <texture>", 0.38}};
  contents.cause_ranges = {range, range};
  contents.cause_ranges[1].from = 60;
  contents.cause_ranges[1].below = std::nullopt;
  contents.cause_ranges[1].words = "from 60 pixels on: no error";
  PopRow pop;
  pop.run = 1;
  pop.representation = "hybrid(mesh,flat)";
  pop.character = "mannequin";
  pop.from = "mesh";
  pop.to = "flat";
  pop.agent = 3;
  pop.tick = 8;
  pop.frames = 1;
  pop.distance = 20.25;
  pop.pixels = 100;
  pop.scores = {{"pop_flip", 0.25}};
  contents.pops = {pop, pop, pop};
  contents.pops[1].tick = 9;
  contents.pops[1].scores[0].value = 0.5;
  contents.pops[2].pixels = 0;
  contents.pops[2].scores[0].value = std::nullopt;
  ScoreDoc doc{"pop_flip", "FLIP of the switch", "", "", false, 3, 0, true, false, false};
  const std::string page = report_page(contents, {"made-up.sqlite", made_up_scores(), {}, {doc}});
  for (const char* text :
       {"flat against mesh, views of one agent of mannequin: the error is dominated by: below 60 pixels: the stored "
        "view "
        "(62 % of the squared error); from 60 pixels on: no error.",
        "hybrid(mesh,flat): 3 switches of 1 agent, 2 of them seen. The most visible: agent 3 at tick 9, 20.2 m away, "
        "from mesh to flat: FLIP of the switch 0.500, 0 is equal.",
        "Single agents: mannequin", "<td>62 %</td>", "the &lt;texture&gt;", "60 and more", "Switches: mannequin"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(page.find("How it was measured"), std::string::npos);
  EXPECT_LT(page.find("<td class=\"l\">9</td>"), page.find("<td class=\"l\">8</td>")) << "the most visible first";
}

TEST_F(ReportPage, AnEmptyFileIsRefused) { EXPECT_THROW(report_page({}, {"empty.sqlite"}), Error); }

TEST(ReportCharts, TheCurvesHoldTheMediansInMilliseconds) {
  const StoreContents contents = made_up_contents();
  const auto scenes = scenes_of(contents);
  const auto spec = nlohmann::json::parse(time_chart(scenes[0], 0.15));
  const auto& values = spec.at("data").at("values");
  ASSERT_EQ(values.size(), 10U);
  EXPECT_EQ(values[4].at("representation"), "mesh");
  EXPECT_EQ(values[4].at("agents"), 1000);
  EXPECT_DOUBLE_EQ(values[4].at("ms").get<double>(), 100.0);
  EXPECT_DOUBLE_EQ(values[4].at("low").get<double>(), 95.0);
  // At 90 % the mesh's last point was never timed, nor both of one agent.
  EXPECT_EQ(nlohmann::json::parse(time_chart(scenes[0], 0.9)).at("data").at("values").size(), 7U);
  EXPECT_TRUE(time_chart(scenes[0], 0.5).empty());
  EXPECT_TRUE(score_chart(scenes[0], made_up_scores()[3]).empty());
}

TEST(ReportCharts, TheScoresHaveALegendThatNoLayerContradicts) {
  const StoreContents contents = made_up_contents();
  const auto spec = nlohmann::json::parse(score_chart(scenes_of(contents)[0], made_up_scores()[0]));
  size_t coloured = 0;
  for (const auto& layer : spec.at("layer")) {
    if (!layer.at("encoding").contains("color")) continue;
    EXPECT_TRUE(layer.at("encoding").at("color").at("legend").is_object()) << layer.dump();
    ++coloured;
  }
  EXPECT_EQ(coloured, 2U);
}

TEST(ReportCharts, ColoursDiffer) {
  const auto colours = representation_colours(8);
  for (size_t i = 0; i < colours.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_NE(colours[i], colours[j]);
  EXPECT_EQ(representation_colours(20).size(), 20U);
}

// The made-up scene so many times, each of another scenario and run, as a sweep's conditions are.
StoreContents made_up_scenes(size_t scenes) {
  const StoreContents one = made_up_contents();
  StoreContents all;
  for (size_t s = 0; s < scenes; ++s) {
    const auto run = static_cast<int64_t>(s + 1);
    RunRow of = one.runs[0];
    of.id = run;
    of.scenario_hash += std::to_string(s);
    all.runs.push_back(of);
    for (MeasurementRow row : one.measurements) {
      row.id += 1000 * run;
      row.run = run;
      all.measurements.push_back(row);
    }
    for (RatioRow row : one.ratios) {
      row.run = run;
      all.ratios.push_back(row);
    }
    for (ComparisonRow row : one.comparisons) {
      row.id += 1000 * run;
      row.run = run;
      all.comparisons.push_back(row);
    }
  }
  return all;
}

size_t count_of(const std::string& text, const std::string& word) {
  size_t count = 0;
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

// CROWDBENCH_REPORT_POINTS=10000 makes it of so many and says how long it took; CROWDBENCH_KEEP_PAGE keeps the page.
TEST_F(ReportPage, OfManyScenesTellsTheFirstInFullAndEveryPointOnce) {
  const char* const asked = std::getenv("CROWDBENCH_REPORT_POINTS");
  const size_t each = made_up_contents().measurements.size();
  const size_t scenes = asked != nullptr ? std::max(1, std::atoi(asked)) / each : 2 * kScenesInFull;
  const StoreContents contents = made_up_scenes(scenes);
  const auto begun = std::chrono::steady_clock::now();
  page_ = report_page(contents, {"made-up.sqlite", made_up_scores()});
  if (asked != nullptr)
    std::cout << scenes * each << " points of " << scenes
              << " scenes: " << std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count()
              << " s, " << page_.size() / 1024 << " KiB\n";
  if (const char* path = std::getenv("CROWDBENCH_KEEP_PAGE")) std::ofstream(path) << page_;
  const std::string text = markup();
  const size_t table = text.find("<table id=\"points\">");
  ASSERT_NE(table, std::string::npos);
  EXPECT_EQ(count_of(text.substr(table, text.find("</table>", table) - table), "<tr>"), 1 + scenes * each);
  EXPECT_EQ(count_of(text.substr(0, table), "640 × 480 pixels, scenario"), kScenesInFull);
  EXPECT_EQ(count_of(text, "<h3>Run "), kScenesInFull);
  EXPECT_NE(text.find(std::to_string(scenes - kScenesInFull) +
                      " more runs are in the file, all of the same program, driver and machine"),
            std::string::npos);
  page_ = report_page(made_up_scenes(kScenesInFull), {"made-up.sqlite", made_up_scores()});
  EXPECT_EQ(markup().find("Every point"), std::string::npos) << "few enough for a section each";
}

TEST_F(ReportPage, TheTitleIsOfWhatWasAskedFor) {
  StoreContents contents = made_up_contents();
  for (const MeasurementRow& row : std::vector<MeasurementRow>(contents.measurements))
    if (row.key.representation == "flat") {
      contents.measurements.push_back(row);
      contents.measurements.back().key.representation = "mesh:triangles=500";
    }
  const auto title = [&] {
    const std::string page = report_page(contents, {"made-up.sqlite", made_up_scores()});
    const size_t at = page.find("<title>");
    return page.substr(at + 7, page.find("</title>") - at - 7);
  };
  EXPECT_EQ(title(), "A crowd drawn as mesh and as flat: cost and difference") << "the level was added";
  contents.runs[0].arguments = "bench --representation flat --representation mesh:triangles=500";
  EXPECT_EQ(title(), "A crowd drawn as mesh and as flat, mesh:triangles=500: cost and difference");
}

}  // namespace
}  // namespace crowdbench::reports
