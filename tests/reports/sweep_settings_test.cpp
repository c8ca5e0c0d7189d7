// What a sweep's points were set to, in headings and tables, and the points that were not drawn.
#include "reports/model/sweep_settings.h"

#include <gtest/gtest.h>

#include "reports/exports/exports.h"
#include "reports/page/points_section.h"
#include "tests/reports/rows.h"

namespace crowdbench::reports {
namespace {

SweepPointRow point_of(const std::string& settings, const std::string& state = "done", const std::string& reason = "") {
  SweepPointRow row;
  row.role = "point";
  row.representation = "flat";
  row.settings = settings;
  row.state = state;
  row.reason = reason;
  return row;
}

std::string text_of_point(const SweepPointRow& row) {
  StoreContents contents;
  contents.sweep_points = {row};
  return SweepSettings(contents).of_point(row);
}

// Samples have many digits, of which a reader needs those that tell them apart; the row keeps all.
TEST(SweepSettings, SampledNumbersAreAsShortAsTellsThemApart) {
  StoreContents contents;
  contents.sweep_points = {point_of(R"({"fov":"43.217391304347828","crowd.agents":"40"})"),
                           point_of(R"({"fov":"43.26","crowd.agents":"40"})")};
  const SweepSettings all(contents);
  EXPECT_EQ(all.of_point(contents.sweep_points[0]), "fov = 43.2, crowd.agents = 40");
  EXPECT_EQ(all.of_point(contents.sweep_points[1]), "fov = 43.26, crowd.agents = 40");
  EXPECT_EQ(all.of_point(point_of(R"({"fov":"7.12345678901"})")), "fov = 7.12345678901") << "none of theirs";
}

TEST(SweepSettings, AreReadInThePlansOrderWithoutWhatDraws) {
  EXPECT_EQ(text_of_point(point_of(R"({"seed":"1","crowd.agents":"40","representation":"flat"})")),
            "seed = 1, crowd.agents = 40");
  for (const char* odd : {"", "{}", "[1]", "{\"a\":", "{\"a\":3}", "\xff"})
    EXPECT_EQ(text_of_point(point_of(odd)), "") << odd;
}

// Of one scene, what its points share: an option that one of them alone has is not the scene's.
TEST(SweepSettings, OfASceneAreWhatItsPointsShare) {
  StoreContents contents = made_up_contents();
  const std::vector<Scene> scenes = scenes_of(contents);
  ASSERT_FALSE(scenes.empty());
  ASSERT_GE(scenes[0].rows.size(), 2U);
  EXPECT_EQ(SweepSettings(contents).of_scene(scenes[0]), "") << "no sweep made it";
  contents.sweep_points = {point_of(R"({"seed":"7","flat.texels":"32"})"), point_of(R"({"seed":"7"})"),
                           point_of(R"({"seed":"8"})")};
  contents.sweep_points[0].measurement = scenes[0].rows[0]->id;
  contents.sweep_points[1].measurement = scenes[0].rows[1]->id;
  EXPECT_EQ(SweepSettings(contents).of_scene(scenes[0]), "seed = 7") << "the third point is of another scene";
}

TEST(SweepSettings, PointsThatWereNotDrawnAreToldByReason) {
  StoreContents contents = made_up_contents();
  for (int i = 0; i < 7; ++i)
    contents.sweep_points.push_back(
        point_of("{\"seed\":\"" + std::to_string(i) + "\"}", "failed", "missing<b>.glb: cannot open"));
  contents.sweep_points.push_back(point_of("", "unreachable", "no camera covers so much"));
  contents.sweep_points.push_back(point_of("", "done"));
  contents.sweep_points.push_back(point_of("", "failed", "missing<b>.glb: cannot open"));
  contents.sweep_points.back().role = "aa";
  const std::vector<UndrawnPoints> all = undrawn_points(contents);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].count, 7U) << "the A/A twin is no point of the plan";
  EXPECT_EQ(all[0].some.size(), kUndrawnNamed);
  EXPECT_EQ(all[0].some[1], "flat, seed = 1");
  EXPECT_EQ(all[1].state, "unreachable");
  const std::string section = undrawn_section(contents).text;
  EXPECT_NE(section.find("missing&lt;b&gt;.glb: cannot open"), std::string::npos) << section;
  EXPECT_NE(section.find("<div>2 more</div>"), std::string::npos) << section;
  const std::string markdown = report_markdown(contents, "made-up.sqlite", made_up_scores());
  EXPECT_NE(markdown.find("7 points of the plan were not drawn (failed: "), std::string::npos);
  EXPECT_EQ(undrawn_section(made_up_contents()).text, "");
}

}  // namespace
}  // namespace crowdbench::reports
