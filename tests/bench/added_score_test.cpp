// A score that is added by one file and one line is found wherever scores are listed, printed, stored and exported.
// The one added here is of the test alone: a table with one line more is handed to all that walk the table.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/bench_run.h"
#include "bench/experiments/pop_map.h"
#include "bench/experiments/score_rows.h"
#include "core/files.h"
#include "core/image_io.h"
#include "reports/exports/exports.h"
#include "reports/exports/scores_markdown.h"
#include "reports/model/scores.h"
#include "reports/page/report_page.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using nlohmann::json;

// How far the red of the first pixel is off, with two figures pooled and a map.
metrics::ScoreResult first_red(const metrics::ScoreInput& input, metrics::Shared&) {
  metrics::ScoreResult result;
  result.value = std::abs(int{input.reference.codes->data[0]} - int{input.test.codes->data[0]}) / 10.0;
  result.pooled = {{"mean", *result.value}, {"q3", 1.5}};
  if (input.maps) result.map = metrics::ScoreMap{metrics::Plane(3, 2, 1), 0, 0, 0, 25.5, "tens"};
  return result;
}

const metrics::Score kAdded = {
    .name = "first_red",
    .title = "red of the first pixel",
    .column = "1st red",
    .unit = "tens",
    .direction = metrics::Direction::lower_is_better,
    .digits = 3,
    .least = 0,
    .greatest = 10000,  // by agent it counts pixels
    .needs = metrics::kNeedsCodes,
    .scope = metrics::Scope::region,
    .uses = metrics::kInTables | metrics::kHeadline | metrics::kCharted,
    .computes = "abs(a - b) / 10 of the first pixel's red",
    .source = "",
    .map_file = "first_red_map",
    .compute = first_red,
    .over_time =
        [] {
          return metrics::FrameScore{[](const metrics::ScoreInput&, metrics::Shared&) {},
                                     [] {
                                       metrics::ScoreResult result;
                                       result.value = 0.25;
                                       return result;
                                     }};
        },
    .by_agent = [](const metrics::ScoreInput&, metrics::Shared&, const metrics::AgentPixels& agent)
        -> std::optional<double> { return static_cast<double>(agent.pixels.size()); },
};

// Whatever needs a display gets the default one where nobody chose another.
const metrics::Score kOfADisplay = {
    .name = "of_a_display",
    .title = "of a display",
    .column = "display",
    .greatest = 1,
    .needs = metrics::kNeedsCodes | metrics::kNeedsDisplay,
    .computes = "nothing",
    .compute =
        [](const metrics::ScoreInput& input, metrics::Shared&) {
          metrics::ScoreResult result;
          result.value = input.display->pixels_per_degree;
          return result;
        },
};

const std::vector<const metrics::Score*>& table() {
  static const std::vector<const metrics::Score*> all = [] {
    std::vector<const metrics::Score*> scores(metrics::scores().begin(), metrics::scores().end());
    scores.push_back(&kAdded);
    scores.push_back(&kOfADisplay);
    return scores;
  }();
  return all;
}

using Add = void (*)(Command&, Run&, metrics::ScoreTable);

std::string output_of(Add add, std::vector<std::string> arguments) {
  CLI::App app;
  Run run;
  Command program(app);
  add(program, run, table());
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(run(), 0);
  std::fflush(stdout);
  return ::testing::internal::GetCapturedStdout();
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(AddedScore, IsInCompare) {
  const support::ScratchFolder folder;
  Image8 a(12, 12, 3);
  Image8 b = a;
  b.data[0] = 42;
  ImageU32 ids(12, 12, 1);
  *ids.at(4, 4) = *ids.at(5, 4) = 9;
  write_png(folder / "a.png", a);
  write_png(folder / "b.png", b);
  write_exr(folder / "ids.exr", ids);
  const std::vector<std::string> arguments = {"compare",
                                              (folder / "a.png").string(),
                                              (folder / "b.png").string(),
                                              "--ids-ref",
                                              (folder / "ids.exr").string(),
                                              "--ids-test",
                                              (folder / "ids.exr").string(),
                                              "--maps",
                                              (folder / "maps").string()};
  std::vector<std::string> with_json = arguments;
  with_json.emplace_back("--json");
  const json out = json::parse(output_of(add_compare, with_json));
  EXPECT_EQ(out.at("scores").at("first_red"), json::parse(R"({"mean": 4.2, "q3": 1.5})"));
  EXPECT_EQ(out.at("agents").at(0).at("first_red"), 2.0);
  EXPECT_EQ(out.at("scores").at("of_a_display"), metrics::default_display().pixels_per_degree)
      << "compare gives the default display to scores that cannot do without one";
  EXPECT_TRUE(std::filesystem::exists(folder / "maps" / "first_red_map.png"));
  const std::string text = output_of(add_compare, arguments);
  EXPECT_TRUE(contains(text, "first_red")) << text;
  EXPECT_TRUE(contains(text, "4.200  red of the first pixel, tens; 0 = equal")) << text;
  EXPECT_TRUE(contains(text, "1st red")) << text;
}

TEST(AddedScoreGl, IsInQuality) {
  const support::ScratchFolder folder;
  const std::vector<std::string> arguments = {"quality",
                                              "--representation",
                                              "mesh",
                                              "--character",
                                              "mannequin:triangles=500",
                                              "--height-px",
                                              "40",
                                              "--rows",
                                              "96",
                                              "--time",
                                              "0.1,0.2,0.3",
                                              "--flicker",
                                              "--maps",
                                              folder.path().string()};
  std::vector<std::string> with_json = arguments;
  with_json.emplace_back("--json");
  const json out = json::parse(output_of(add_quality, with_json));
  EXPECT_EQ(out.at("rows").at(0).at("first_red").at("mean"), 0);
  EXPECT_EQ(out.at("first_red").at(0).at("first_red"), 0.25) << "over time";
  EXPECT_EQ(out.at("first_red").at(0).at("frames"), 3);
  EXPECT_TRUE(std::filesystem::exists(folder / "mesh_h40_a0_e0_t0.1_first_red_map.png"));
  EXPECT_TRUE(contains(output_of(add_quality, arguments), "1st red"));
  // The same over an orbit: four azimuths at each of three times.
  std::vector<std::string> round = arguments;
  std::replace(round.begin(), round.end(), std::string("--flicker"), std::string("--orbit"));
  round.insert(round.end(), {"--azimuth-deg", "0:3:1"});
  EXPECT_TRUE(contains(output_of(add_quality, round), "over 4 azimuths as successive frames"));
  round.emplace_back("--json");
  const json orbit = json::parse(output_of(add_quality, round));
  ASSERT_EQ(orbit.at("first_red").size(), 3U);
  EXPECT_EQ(orbit.at("first_red").at(1).at("time"), 0.2);
  EXPECT_EQ(orbit.at("first_red").at(1).at("frames"), 4);
}

TEST(AddedScoreGl, IsInPopMaps) {
  const support::ScratchFolder folder;
  const std::string text = output_of(
      add_popmap, {"popmap", "--representation", "mesh", "--character", "mannequin:triangles=500", "--height-px", "40",
                   "--azimuth-deg", "0", "--elevation-deg", "0", "--phase", "0.1", "--out", folder.path().string()});
  EXPECT_TRUE(contains(text, "1st red")) << text;
  const json out = json::parse(read_text(folder / "popmap.json"));
  EXPECT_EQ(out.at("sizes").at(0).at("switch").at("own_cut").at("first_red").at("p95"), 0);
  EXPECT_EQ(out.at("cells").at(0).at("own_pose").at("fade_step_first_red"), 0);
  EXPECT_TRUE(contains(read_text(folder / "popmap.csv"), ",matched_fade_step_first_red"));
  EXPECT_TRUE(contains(read_text(folder / "popmap.html"), "Red of the first pixel, tens"));
}

TEST(AddedScoreGl, IsInDistance) {
  const support::ScratchFolder folder;
  const std::vector<std::string> arguments = {"distance",
                                              "--representation",
                                              "mesh",
                                              "--character",
                                              "mannequin:triangles=500",
                                              "--agents",
                                              "6",
                                              "--occupancy",
                                              "0.1",
                                              "--size",
                                              "96x72",
                                              "--threshold",
                                              "first_red=10000",
                                              "--out",
                                              (folder / "agents.csv").string()};
  const std::string text = output_of(add_distance, arguments);
  EXPECT_TRUE(contains(text, "mesh: red of the first pixel, tens, 0 = equal")) << text;
  EXPECT_TRUE(contains(text, "mesh: first_red of 10000 or better by distance from the eye: ")) << text;
  EXPECT_TRUE(contains(read_text(folder / "agents.csv"), ",first_red\n") ||
              contains(read_text(folder / "agents.csv"), ",first_red,"));
  std::vector<std::string> with_json = arguments;
  with_json.emplace_back("--json");
  const json document = json::parse(output_of(add_distance, with_json));
  for (const json& row : document.at("rows"))
    if (row.at("state") == "counted") {
      EXPECT_EQ(row.at("scores").at("mesh").at("first_red"), row.at("visible_px")) << "by agent: its pixels";
    }
}

// What `report` and `export` write of a result file, in every form that has scores.
void expect_in_what_is_told_of(const std::filesystem::path& results, const support::ScratchFolder& folder) {
  const auto path = [&](const char* name) { return (folder / name).string(); };
  (void)output_of(add_report,
                  {"report", results.string(), "--out", path("report.html"), "--markdown", path("report.md"),
                   "--scores-csv", path("report.csv"), "--json-out", path("report.json")});
  (void)output_of(add_export,
                  {"export", results.string(), "--scores-csv", path("export.csv"), "--json-out", path("export.json"),
                   "--markdown", path("export.md"), "--bencher", path("bencher.json")});
  for (const char* page : {"report.html", "report.md", "export.md"})
    EXPECT_TRUE(contains(read_text(folder / page), "Red of the first pixel, tens")) << page;
  for (const char* rows : {"report.csv", "export.csv"})
    EXPECT_TRUE(contains(read_text(folder / rows), "first_red")) << rows;
  EXPECT_TRUE(contains(read_text(folder / "bencher.json"), "first_red"));
  for (const char* rows : {"report.json", "export.json"})
    EXPECT_EQ(json::parse(read_text(folder / rows)).at("comparisons").at(0).at("scores").count("first_red"), 1U)
        << rows;
}

TEST(AddedScoreGl, IsInBenchReportAndExport) {
  const support::ScratchFolder folder;
  const std::string results = (folder / "results.sqlite").string();
  const json out =
      json::parse(output_of(add_bench, {"bench", "--representation", "mesh:triangles=400", "--character",
                                        "mannequin:triangles=500", "--agents", "5", "--occupancy", "0.15", "--size",
                                        "96x72", "--rounds", "10", "--no-floors", "--json", "--out", results}));
  EXPECT_EQ(out.at("comparisons").at(0).at("scores").count("first_red"), 1U);
  expect_in_what_is_told_of(results, folder);
}

TEST(AddedScoreGl, IsInDemo) {
  CROWDBENCH_SKIP_SANITIZED("AddedScoreGl.IsInBenchReportAndExport");
  const support::ScratchFolder folder;
  (void)output_of(add_demo, {"demo", "--tiny", "--no-clip", "--representation", "mesh:triangles=400", "--character",
                             "mannequin:triangles=500", "--out", (folder / "demo").string()});
  EXPECT_TRUE(contains(read_text(folder / "demo/report.html"), "Red of the first pixel, tens"));
  expect_in_what_is_told_of(folder / "demo/results.sqlite", folder);
}

TEST(AddedScore, IsInRowsReportAndExports) {
  renderers::Capture reference;
  reference.colour = Image8(16, 16, 4);
  reference.ids = ImageU32(16, 16, 1);
  reference.depth = ImageF(16, 16, 1);
  *reference.ids.at(3, 3) = 1;
  renderers::Capture test = reference;
  test.colour.data[0] = 55;
  StoreContents contents;
  RunRow run;
  run.id = 1;
  contents.runs.push_back(run);
  MeasurementRow measured;
  measured.run = 1;
  measured.key = {"flat", "somebody", 3, 16, 16, 0};
  measured.reference = "mesh";
  contents.measurements.push_back(measured);
  for (const char* kind : {"crowd", "agent"}) {
    ComparisonRow row;
    row.run = 1;
    row.kind = kind;
    row.representation = "flat";
    row.reference = "mesh";
    row.character = "somebody";
    row.agents = 3;
    if (row.kind == "agent") row.height_px = 64;
    row.scores = score_crowd(table(), {}, reference, test);
    contents.comparisons.push_back(row);
  }
  const std::vector<ScoreRow>& rows = contents.comparisons[0].scores;
  const auto named = [&](const std::string& name) {
    return std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) { return row.name == name; });
  };
  ASSERT_NE(named("first_red"), rows.end());
  EXPECT_EQ(named("first_red")->value, 5.5);
  ASSERT_NE(named("first_red.q3"), rows.end());
  ASSERT_NE(named("of_a_display"), rows.end());
  EXPECT_EQ(named("of_a_display")->value, metrics::default_display().pixels_per_degree);

  const std::vector<reports::ScoreDoc> docs = score_docs(table());
  const std::vector<reports::Scene> scenes = reports::scenes_of(contents, docs);
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_TRUE(contains(reports::headline_scores(scenes[0], contents.comparisons[0]), "red of the first pixel 5.500"));
  EXPECT_TRUE(contains(reports::scores_markdown(scenes[0]), "| Red of the first pixel, tens |"));
  EXPECT_TRUE(contains(reports::report_markdown(contents, "x", docs), "| Red of the first pixel, tens |"));
  EXPECT_TRUE(contains(reports::report_page(contents, {"x", docs}), "Red of the first pixel, tens"));
  EXPECT_TRUE(contains(reports::scores_csv(contents), "first_red"));
  const json all = json::parse(reports::results_json(contents, docs));
  EXPECT_EQ(all.at("comparisons").at(0).at("scores").at("first_red"), 5.5);
  EXPECT_EQ(all.at("scores").at(docs.size() - 2).at("unit"), "tens");
  EXPECT_TRUE(contains(metrics::scores_markdown(table()), "| `first_red` | red of the first pixel | tens | lower |"));
}

TEST(AddedScore, IsGivenADisplay) {
  const Image8 picture(2, 2, 3);
  const metrics::Display display{42};
  metrics::ScoreInput input;
  input.reference.codes = input.test.codes = &picture;
  input.display = &display;
  const metrics::Score* of_a_display = &kOfADisplay;
  metrics::Shared shared;
  const auto scored = metrics::score_pictures({&of_a_display, 1}, input, shared);
  ASSERT_EQ(scored.size(), 1U);
  EXPECT_EQ(scored[0].result.value, 42);
}

}  // namespace
}  // namespace crowdbench::bench
