// The page of a study's answers: whole, harmless whatever names say, and the same bytes from the same answers.
#include "reports/page/study_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "reports/charts/study_chart.h"
#include "reports/model/study_model.h"
#include "reports/page/libraries.h"

namespace crowdbench::reports {
namespace {

using nlohmann::json;

StudyPageModel model() {
  StudyTask task;
  task.name = "which <b>looks</b> better";
  task.verdicts = {"d = 10 m: 40 % cannot tell, 29 % chose the first, 31 % the second."};
  task.shares = {{"d = 10 m", 29, 40, 31}, {"</script><script>alert(1)", 0, 0, 0}};
  task.curves = {{"mesh & flat",
                  {{1, 0.5, 0.3, 0.7}, {2, 0.9, 0.8, 0.95}},
                  {{1, 0.5, {}, {}}, {1.5, 0.7, {}, {}}, {2, 0.9, {}, {}}},
                  1.6,
                  1.2,
                  {},
                  0.75}};
  task.axis = "height_px (pixels)";
  task.ranking = {{"mesh", 0.5, 0.1, 0.9, "+0.50 JOD"}, {"flat", -0.5, {}, {}, "-0.50 JOD"}};
  StudyTable table{{"condition", "share"}, 1, {{"near", "0.5"}}};
  task.sections = {{"Shares of answers", "lead", "note", {"one", "two"}, table, StudyChart::shares},
                   {"Thresholds", "", "", {}, {}, StudyChart::curves},
                   {"Ranking", "", "", {}, {}, StudyChart::ranking},
                   {"Scores", "", "", {}, {}, StudyChart::prediction}};
  return {"What people answered",     "answers.csv", false, "Not the planned analysis",
          {"p.toml was not frozen."}, {"100 rows."}, {task}};
}

TEST(StudyCharts, HoldAnswersCurvesAndOpenEnds) {
  const StudyTask task = model().tasks[0];
  const json shares = json::parse(study_shares_chart(task)).at("data").at("values");
  ASSERT_EQ(shares.size(), 6U);
  EXPECT_EQ(shares[1].at("share"), 40);
  EXPECT_EQ(shares[3].at("share"), 0) << "nobody answered";
  const json curves = json::parse(study_curves_chart(task));
  EXPECT_EQ(curves.at("layer").size(), 5U);
  EXPECT_EQ(curves.at("layer")[0].at("encoding").at("x").at("axis").at("title"), "height_px (pixels)");
  EXPECT_EQ(curves.at("layer")[1].at("data").at("values").size(), 3U);
  EXPECT_TRUE(curves.at("layer")[2].at("data").at("values")[0].at("high").is_null());
  EXPECT_EQ(json::parse(study_rows_chart(task.ranking, "JOD")).at("data").at("values").size(), 2U);
  EXPECT_EQ(study_rows_chart(task.prediction, "AUC"), "");
}

// Names that differ at their ends alone are told apart: they are broken into lines, and none is cut.
TEST(StudyCharts, NamesAreNeverCut) {
  StudyTask task;
  const std::vector<std::string> names = {"mesh:triangles=200 over mesh:triangles=40",
                                          "mesh:triangles=200 over mesh:triangles=80", std::string(60, 'a') + "b",
                                          std::string(11, '-') + "\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9"};
  for (const std::string& name : names) task.shares.push_back({name, 1, 0, 1});
  const json chart = json::parse(study_shares_chart(task));
  const json& axis = chart.at("encoding").at("y").at("axis");
  EXPECT_EQ(axis.at("labelLimit"), 0);
  EXPECT_EQ(axis.at("labelExpr"), "split(datum.label, '\\n')");
  const json& values = chart.at("data").at("values");
  ASSERT_EQ(values.size(), 12U);
  EXPECT_EQ(values[0].at("name"), "mesh:triangles=200 over\nmesh:triangles=40");
  EXPECT_EQ(values[3].at("name"), "mesh:triangles=200 over\nmesh:triangles=80");
  EXPECT_EQ(values[6].at("name"),
            std::string(24, 'a') + "\n" + std::string(24, 'a') + "\n" + std::string(12, 'a') + "b");
  EXPECT_EQ(values[9].at("name"), std::string(11, '-') + "\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9\n\u00e9\u00e9");
  EXPECT_LE(axis.at("minExtent").get<int>(), 190);
  EXPECT_GE(chart.at("height").get<int>(), 4 * 3 * 13) << "three lines a row";
}

TEST(StudyPage, IsWholeAndHarmless) {
  try {
    chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  const std::string page = study_page(model());
  if (const char* path = std::getenv("CROWDBENCH_KEEP_PAGE")) std::ofstream(path) << page;
  EXPECT_EQ(page, study_page(model()));
  for (const char* there : {"<div class=\"banner\">Not the planned analysis", "p.toml was not frozen.", "100 rows.",
                            "which &lt;b&gt;looks&lt;/b&gt; better", "29 % chose the first", "<li>two</li>",
                            "<td class=\"l\" data-of=\"condition\">near</td>", "<p class=\"note\">note</p>",
                            "What this cannot tell", "from answers.csv"})
    EXPECT_NE(page.find(there), std::string::npos) << there;
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  size_t charts = 0;
  for (size_t at = page.find("data-plot="); at != std::string::npos; at = page.find("data-plot=", at + 1)) ++charts;
  EXPECT_EQ(charts, 3U) << "a chart without data has no place";
  StudyPageModel planned = model();
  planned.planned = true;
  EXPECT_EQ(study_page(planned).find("<div class=\"banner\""), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::reports
