// Levels of equal error and of equal cost, by hand.
#include "reports/model/equal_levels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "reports/model/answer.h"
#include "reports/page/libraries.h"
#include "reports/page/report_page.h"

namespace crowdbench::reports {
namespace {

using Where = LevelPlace::Where;

// At 100 agents and 15 %: the time over the mesh's, triangles and the error of everything; interval of speeds 2 % wide.
struct Given {
  const char* name;
  uint64_t triangles;
  double time;
  std::optional<double> error;
};
StoreContents contents_of(const std::vector<Given>& all, uint32_t agents = 100) {
  StoreContents out;
  RunRow run;
  run.id = 1;
  run.headline = "cpu";
  out.runs.push_back(run);
  int64_t id = 0;
  for (const Given& one : all) {
    MeasurementRow row;
    row.id = ++id;
    row.run = 1;
    row.key = {one.name, "mannequin", agents, 640, 480, 0.15};
    row.reference = "mesh";
    row.cpu_ns = row.frame_ns = TimeSummary{1e6 * one.time, 1e6, 1e6, 1e6, 1e6, 1e6};
    row.rounds = 20;
    row.triangles_per_agent = one.triangles;
    out.measurements.push_back(row);
    if (row.key.representation == "mesh") continue;
    const double speed = 1 / one.time;
    out.ratios.push_back({++id, 1, "speed", row.key, "mesh", "cpu", speed, speed * 0.99, speed * 1.01, 20});
    ComparisonRow scored;
    scored.id = ++id;
    scored.run = 1;
    scored.kind = "crowd";
    scored.representation = one.name;
    scored.reference = "mesh";
    scored.character = "mannequin";
    scored.agents = agents;
    scored.requested_occupancy = 0.15;
    scored.scores = {{"likeness", 0.5, ""}, {"wrongness", one.error, one.error ? "" : "made up"}};
    out.comparisons.push_back(scored);
  }
  return out;
}

// A likeness that all have, and an error, which is asked first.
std::vector<ScoreDoc> docs() {
  return {{"likeness", "likeness", "", "", true, 3, 1, true, false, false},
          {"wrongness", "wrongness", "", "", false, 3, 0, true, false, false}};
}

const std::vector<Given> kAll = {{"mesh", 4096, 1, std::nullopt},
                                 {"quick", 2, 0.1, 0.2},
                                 {"mesh:triangles=256", 256, 0.2, 0.3},
                                 {"good", 2, 0.7, 0.05},
                                 {"mesh:triangles=1024", 1024, 0.4, 0.1},
                                 {"bad", 2, 0.3, 0.5},
                                 {"slow", 2, 1.5, 0.0}};

class EqualLevelsTest : public ::testing::Test {
 protected:
  static LevelTable table_of(const StoreContents& contents) {
    const std::vector<Scene> scenes = scenes_of(contents, docs());
    const std::vector<LevelTable> tables = level_tables(scenes.at(0));
    EXPECT_EQ(tables.size(), 1U);
    return tables.at(0);
  }
};

TEST_F(EqualLevelsTest, AreFoundBetweenThoseThatWereTimed) {
  const LevelTable table = table_of(contents_of(kAll));
  EXPECT_EQ(table.score.name, "wrongness");
  EXPECT_EQ(table.agents, 100U);
  EXPECT_EQ(table.levels, 2U);
  ASSERT_EQ(table.rows.size(), 4U) << "levels are none of the rows";

  // Half-way between 0.1 and 0.3, and so between 2^10 and 2^8 triangles.
  const EqualLevels& quick = table.rows[0];
  EXPECT_EQ(quick.representation, "quick");
  EXPECT_EQ(quick.equal_error->where, Where::between);
  EXPECT_NEAR(quick.equal_error->triangles, 512, 1e-9);
  const double time = 0.2 + 0.2 * (512 - 256) / (1024 - 256);
  EXPECT_NEAR(quick.factor, time / 0.1, 1e-12);
  EXPECT_NEAR(quick.low, quick.factor * 0.99 / 1.01, 1e-12);
  EXPECT_NEAR(quick.high, quick.factor * 1.01 / 0.99, 1e-12);
  EXPECT_EQ(quick.equal_time.where, Where::beyond_coarsest);
  EXPECT_EQ(quick.equal_time.triangles, 256);
  EXPECT_NEAR(*quick.error_of_equal_time, 0.3, 1e-12) << "the coarsest one's, and it costs twice as much";

  // Between the whole mesh, which is not wrong at all, and the first level.
  const EqualLevels& good = table.rows[1];
  EXPECT_NEAR(good.equal_error->triangles, 2048, 1e-9);
  EXPECT_NEAR(good.factor, (0.4 + 0.6 * 1024 / 3072) / 0.7, 1e-12);
  EXPECT_NEAR(good.equal_time.triangles, 2560, 1e-9) << "half-way between 0.4 and 1";
  EXPECT_NEAR(*good.error_of_equal_time, 0.1 * std::log2(4096.0 / 2560) / 2, 1e-12);

  const EqualLevels& bad = table.rows[2];
  EXPECT_EQ(bad.equal_error->where, Where::beyond_coarsest);
  EXPECT_NEAR(bad.factor, 0.2 / 0.3, 1e-12);
  EXPECT_NEAR(bad.equal_time.triangles, 256 + 768 * 0.5, 1e-9);

  const EqualLevels& slow = table.rows[3];
  EXPECT_NEAR(slow.equal_error->triangles, 4096, 1e-9) << "as good as the whole mesh";
  EXPECT_EQ(slow.equal_time.where, Where::beyond_finest);
  EXPECT_NEAR(*slow.error_of_equal_time, 0, 1e-12);
}

TEST_F(EqualLevelsTest, LikenessesFallWhereErrorsRise) {
  StoreContents contents = contents_of(kAll);
  for (ComparisonRow& row : contents.comparisons) {
    row.scores[0].value = 1 - *row.scores[1].value;
    row.scores.pop_back();
  }
  const LevelTable table = table_of(contents);
  EXPECT_EQ(table.score.name, "likeness");
  EXPECT_NEAR(table.rows[0].equal_error->triangles, 512, 1e-9);
}

TEST_F(EqualLevelsTest, WithoutScoresCostAloneIsTold) {
  StoreContents contents = contents_of(kAll);
  contents.comparisons.clear();
  const LevelTable table = table_of(contents);
  EXPECT_EQ(table.score.name, "");
  EXPECT_FALSE(table.rows[1].equal_error.has_value());
  EXPECT_FALSE(table.rows[1].error_of_equal_time.has_value());
  EXPECT_NEAR(table.rows[1].equal_time.triangles, 2560, 1e-9);
  EXPECT_EQ(equal_levels_text(table, table.rows[1], "mesh"), " As dear is a level of about 2,560 triangles.");
}

TEST_F(EqualLevelsTest, ThereIsNoTableWithoutALevel) {
  const StoreContents contents = contents_of({kAll[0], kAll[1]});
  EXPECT_TRUE(level_tables(scenes_of(contents, docs()).at(0)).empty());
}

TEST_F(EqualLevelsTest, TheLargestCrowdThatWasScoredIsTaken) {
  StoreContents contents = contents_of(kAll);
  StoreContents larger = contents_of(kAll, 1000);
  for (MeasurementRow& row : larger.measurements) contents.measurements.push_back(row);
  for (RatioRow& row : larger.ratios) contents.ratios.push_back(row);
  EXPECT_EQ(table_of(contents).agents, 100U);
  contents.comparisons.clear();
  EXPECT_EQ(table_of(contents).agents, 1000U);
}

TEST_F(EqualLevelsTest, AreATableOfTheReport) {
  try {
    (void)chart_libraries();
  } catch (const Error&) {
    GTEST_SKIP() << "npm packages of the chart library absent at configure time";
  }
  const std::string page = report_page(contents_of(kAll), {"made-up.sqlite", docs()});
  const size_t table = page.find("<h2>Impostor or level of detail: 100 agents, 15 % of the picture covered</h2>");
  ASSERT_NE(table, std::string::npos);
  EXPECT_NE(page.find("<td>about 512 triangles</td><td>2.67 (2.61 to 2.72)</td>\n<td>fewer than 256 triangles</td>"
                      "<td>worse than 0.300</td><td class=\"l\">quick</td>",
                      table),
            std::string::npos)
      << page.substr(table, 3000);
  EXPECT_NE(page.find("<td>fewer than 256 triangles</td><td>less than 0.67 (0.65 to 0.68)</td>", table),
            std::string::npos);
  EXPECT_NE(page.find("<td class=\"l\">the level</td>", table), std::string::npos);
}

TEST_F(EqualLevelsTest, FollowEveryFigureOfSpeedInTheAnswer) {
  const StoreContents contents = contents_of(kAll);
  const std::vector<Scene> scenes = scenes_of(contents, docs());
  const std::vector<std::string> sentences = answer(scenes.at(0));
  const std::string quick =
      "With 100 agents, a level of about 512 triangles of mesh is as wrong (wrongness 0.200) and takes 2.67 times its "
      "time (2.61 to 2.72). As cheap would be a level of fewer than 256 triangles (wrongness worse than 0.300).";
  size_t found = 0;
  for (const std::string& sentence : sentences) {
    if (sentence.find("quick is 10.0 times as fast as mesh") == std::string::npos) continue;
    ++found;
    EXPECT_NE(sentence.find(quick), std::string::npos) << sentence;
  }
  EXPECT_EQ(found, 1U);
}

}  // namespace
}  // namespace crowdbench::reports
