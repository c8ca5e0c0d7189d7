// Every command that `crowdbench --help` lists is run once as a user would, on tiny input, and what it is for is looked
// at.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/stage/low_polygon.h"
#include "core/files.h"
#include "core/image_io.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/driver_help.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/xvfb.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using nlohmann::json;
using support::Outcome;

constexpr const char* kImpostor = "flat:views=sphere-8x3,texels=32,frames=2";
constexpr const char* kCharacter = " --character mannequin:triangles=500";

class CommandsGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    fs::create_directories(work_);
  }
  // Runs in a folder of the test's own, where all share one cache of bakes.
  Outcome run(const std::string& arguments, bool with_stderr = true, const std::string& variables = "") const {
    return support::run_driver(
        "cd '" + work_.string() + "' && " + display_ + " CROWDBENCH_CACHE_DIR=../cache " + variables, arguments,
        with_stderr);
  }
  // What it prints as JSON; it must succeed.
  json facts(const std::string& arguments) const {
    const Outcome outcome = run(arguments, false);
    EXPECT_EQ(outcome.status, 0) << arguments << "\n" << run(arguments).text;
    json parsed = json::parse(outcome.text, nullptr, false);
    EXPECT_FALSE(parsed.is_discarded()) << arguments << "\n" << outcome.text;
    return parsed;
  }
  std::string text(const std::string& file) const { return read_text(work_ / file); }
  Image8 picture(const std::string& file) const { return decode_png(read_file(work_ / file), file); }

  support::ScratchFolder folder_;
  fs::path work_ = folder_ / "work";
  std::string display_;
};

// The amounts and the residue are the whole error, to the last digit.
void expect_causes(const json& row) {
  int64_t sum = row.at("residue").get<int64_t>();
  for (const auto& [cause, amount] : row.at("squared").items())
    if (!amount.is_null()) sum += amount.get<int64_t>();
  EXPECT_EQ(sum, row.at("total").get<int64_t>()) << row.dump(2);
}

bool is_flat(const Image8& image) {
  for (size_t i = 0; i < image.data.size(); ++i)
    if (image.data[i] != image.data[i % static_cast<size_t>(image.channels)]) return false;
  return true;
}

// In this order: some read what others wrote.
TEST_F(CommandsGl, EachDoesWhatItIsFor) {
  const std::string impostor = kImpostor;
  const std::string character = kCharacter;
  struct Trial {
    std::string command;
    std::function<void()> run;
  };
  const std::vector<Trial> trials = {
      {"info",
       [&] {
         const json j = facts("info --json");
         EXPECT_FALSE(j.at("renderer").get<std::string>().empty());
         EXPECT_FALSE(j.at("gl_version").get<std::string>().empty());
         EXPECT_TRUE(j.at("devices").is_array());
         EXPECT_GE(j.at("limits").at("texture_size").get<int>(), 4096);
         EXPECT_TRUE(j.at("gpu_timer").at("trusted").is_boolean());
         std::set<std::string> names;
         for (const json& r : facts("info --representations --json")) names.insert(r.at("name").get<std::string>());
         EXPECT_TRUE(names.contains("mesh"));
         EXPECT_TRUE(names.contains("flat"));
       }},
      {"inspect",
       [&] {
         const json j = facts("inspect mannequin:triangles=500 --out m.glb --json");
         EXPECT_GT(j.at("clips").size(), 0U);
         EXPECT_EQ(text("m.glb").substr(0, 4), "glTF");
         EXPECT_TRUE(j.at("levels").empty());
         // The levels that `bench` and `demo` add by themselves pass the check of what they cover.
         std::string added;
         for (const renderers::Spec& level : level_specs()) added += " --representation " + level.text();
         EXPECT_EQ(run("bench --agents 100 --occupancy 0.15 --rounds 10 --no-floors --out added.sqlite" + added).status,
                   0);
         const std::string levels = "inspect mannequin:triangles=500 --level triangles=300 --level ratio=0.3";
         const json told = facts(levels + " --height-px 60 --json").at("levels");
         ASSERT_EQ(told.size(), 2U);
         EXPECT_EQ(told[0].at("triangles"), 300);
         EXPECT_GT(told[0].at("max_m").get<double>(), told[0].at("rms_m").get<double>());
         EXPECT_NEAR(told[0].at("max_px").get<double>(), told[0].at("max_m").get<double>() / 1.75 * 60, 1e-3);
         EXPECT_GT(told[0].at("meshoptimizer").at("stated_m").get<double>(), 0);
         EXPECT_LT(told[1].at("triangles").get<int>(), 160);
         EXPECT_NE(run(levels).text.find("level         triangles=300 of mannequin: 300 of"), std::string::npos);
         EXPECT_EQ(run("inspect mannequin --level triangles=300,ratio=0.5").status, 2);
         EXPECT_EQ(run("inspect mannequin --level lod=1").status, 2);
         EXPECT_EQ(run("inspect mannequin --level floor=1").status, 2);
       }},
      {"pose",
       [&] {
         const json j = facts("pose m.glb --clip walk --time 0.2 --vertex 0 --json");
         EXPECT_EQ(j.at("samples").at("0").size(), 3U);
         EXPECT_LT(j.at("bbox_min").at(1).get<double>(), j.at("bbox_max").at(1).get<double>());
       }},
      {"schema",
       [&] {
         EXPECT_TRUE(facts("schema").contains("properties"));
         EXPECT_NE(run("schema --markdown").text.find("agents"), std::string::npos);
         EXPECT_NE(run("schema --scores").text.find("ssim"), std::string::npos);
         EXPECT_NE(run("schema --scores").text.find("pop_luma"), std::string::npos);
         EXPECT_FALSE(facts("schema --results --json").empty());
         EXPECT_EQ(facts("schema --results --json").at("causes").size(), 9U);
         EXPECT_NE(run("schema --results").text.find("\n| `silhouette` |"), std::string::npos);
         const Outcome defaults = run("schema --defaults", false);
         ASSERT_EQ(defaults.status, 0);
         write_file(work_ / "defaults.toml", defaults.text);
       }},
      {"cache",
       [&] {
         // In a folder of its own: what the others bake is theirs.
         const std::string own = "CROWDBENCH_CACHE_DIR=own ";
         EXPECT_EQ(run("bake" + character + " --representation " + impostor, false, own).status, 0);
         const json j = json::parse(run("cache list --json", false, own).text);
         ASSERT_EQ(j.at("entries").size(), 1U);
         EXPECT_EQ(j.at("entries")[0].at("kind"), "flat");
         EXPECT_EQ(j.at("bytes"), j.at("entries")[0].at("bytes"));
         EXPECT_EQ(j.at("limit_bytes"), 4ULL << 30);
         EXPECT_NE(run("cache clear", false, own).text.find("1 bake removed"), std::string::npos);
         EXPECT_NE(run("cache list", false, own).text.find("0 bakes"), std::string::npos);
         const Outcome wrong = run("cache empty");
         EXPECT_EQ(wrong.status, 2);
         EXPECT_NE(wrong.text.find("'empty' is not something to do with the cache"), std::string::npos);
         EXPECT_NE(run("cache clea").text.find("did you mean 'clear'?"), std::string::npos);
       }},
      {"render",
       [&] {
         const std::string stage = "render defaults.toml --agents 8 --size 96x72" + character;
         EXPECT_EQ(run(stage + " --out mesh.png").status, 0);
         EXPECT_EQ(run(stage + " --representation " + impostor + " --out flat.png").status, 0);
         EXPECT_EQ(picture("mesh.png").width, 96);
         EXPECT_EQ(picture("mesh.png").height, 72);
         EXPECT_FALSE(is_flat(picture("mesh.png")));
         EXPECT_NE(picture("mesh.png").data, picture("flat.png").data);
         const json truth = facts(stage + " --truth --json --out truth.png --ids truth.exr").at("truth");
         EXPECT_EQ(picture("truth.png").width, 96);
         EXPECT_GT(truth.at("covered").get<int>(), 50);
         EXPECT_EQ(truth.at("unexplained"), 0) << truth;
         EXPECT_LE(truth.at("worst_distance_px").get<double>(), truth.at("largest_bound_px").get<double>());
         EXPECT_GT(facts("compare mesh.png truth.png --json").at("scores").at("ssim").get<double>(), 0.98);
         EXPECT_EQ(run("render --truth --single --size 40x30 --out alone.png" + character).status, 0);
         EXPECT_FALSE(is_flat(picture("alone.png")));
       }},
      {"bake",
       [&] {
         const json j = facts("bake --representation " + impostor + character + " --json");
         EXPECT_TRUE(j.at("cached").get<bool>()) << "render has made it";
         EXPECT_GT(j.at("gpu_bytes").get<int64_t>(), 10'000);
         EXPECT_GT(j.at("disk_bytes").get<int64_t>(), 10'000);
       }},
      {"compare",
       [&] {
         const json j = facts("compare mesh.png flat.png --maps maps --json");
         EXPECT_EQ(j.at("width"), 96);
         EXPECT_GT(j.at("scores").at("ssim").get<double>(), 0.5);
         EXPECT_LT(j.at("scores").at("ssim").get<double>(), 1.0);
         EXPECT_EQ(picture("maps/absdiff.png").width, 96);
         EXPECT_EQ(facts("compare mesh.png mesh.png --json").at("scores").at("ssim"), 1.0);
       }},
      {"quality",
       [&] {
         const json rows =
             facts("quality --representation " + impostor + " --height-px 40 --rows 64 --json" + character).at("rows");
         ASSERT_GE(rows.size(), 1U);
         for (const json& row : rows) {
           EXPECT_GT(row.at("silhouette_iou").get<double>(), 0.6);
           EXPECT_LE(row.at("silhouette_iou").get<double>(), 1.0);
           EXPECT_EQ(row.at("causes").at("told_by"), "comparing");
         }
         const json mesh =
             facts("quality --representation mesh --reference truth --height-px 40 --rows 64 --exact-pose --json" +
                   character);
         EXPECT_EQ(mesh.at("reference"), "truth");
         EXPECT_GT(mesh.at("rows")[0].at("silhouette_iou").get<double>(), 0.99);
         EXPECT_GT(mesh.at("rows")[0].at("ssim").get<double>(), 0.98);
         const json told =
             facts("quality --representation " + impostor + " --height-px 40 --rows 64 --causes --json" + character);
         expect_causes(told.at("rows")[0].at("causes"));
         EXPECT_EQ(told.at("rows")[0].at("causes").at("told_by"), "drawing");
         EXPECT_NE(told.at("causes")[0].at("words").get<std::string>().find("with 1 view"), std::string::npos);
       }},
      {"switch-distance",
       [&] {
         const json rows =
             facts("switch-distance --representation " + impostor + " --ratio 1 --size 128x96 --json" + character)
                 .at("rows");
         ASSERT_EQ(rows.size(), 1U);
         const double derived = rows[0].at("depth_m").get<double>();
         EXPECT_GT(derived, 0.1);
         EXPECT_NEAR(rows[0].at("measured_depth_m").get<double>() / derived, 1.0, 0.02);
       }},
      {"popmap",
       [&] {
         const json sizes =
             facts("popmap --representation " + impostor +
                   " --azimuth-deg 0 --elevation-deg 0 --phase 0.1 --ratio 1 --out pops --json" + character)
                 .at("sizes");
         ASSERT_EQ(sizes.size(), 1U);
         EXPECT_EQ(sizes[0].at("cells"), 1);
         EXPECT_GT(sizes[0].at("switch").size(), 0U);
         EXPECT_FALSE(fs::is_empty(work_ / "pops"));
       }},
      {"popping",
       [&] {
         write_file(work_ / "moving.toml",
                    "[[camera.key]]\ntime = 0.0\neye = [0.0, 2.0, 6.0]\n"
                    "[[camera.key]]\ntime = 1.0\neye = [0.0, 3.0, 10.0]\n");
         const json j = facts(
             "popping moving.toml --agents 12 --size 96x72 --frames 12 --out switches --representation 'hybrid(mesh,(" +
             impostor + "),distance=8)' --json" + character);
         ASSERT_EQ(j.at("runs").size(), 1U);
         EXPECT_GT(j.at("runs")[0].at("seen").get<int>(), 0);
         EXPECT_EQ(j.at("pictures").size() % 3, 0U);
         EXPECT_EQ(fs::is_empty(work_ / "switches"), false);
       }},
      {"distance",
       [&] {
         const json j = facts(
             "distance --agents 8 --occupancy 0.1 --size 96x72 --scores mae --threshold mae=255 "
             "--representation " +
             impostor + " --out agents.csv --db d.sqlite --json" + character);
         EXPECT_GE(j.at("agents").at("counted").get<int>(), 2);
         ASSERT_EQ(j.at("curves").size(), 3U) << "against distance, height and texels";
         EXPECT_GT(j.at("curves")[0].at("bins")[0].at("median").get<double>(), 0);
         EXPECT_EQ(j.at("curves")[0].at("thresholds").size(), 1U);
         EXPECT_NE(text("agents.csv").find("counted"), std::string::npos);
         // The same from the result file.
         const Outcome report = run("report d.sqlite --out d.html --json-out d.json");
         EXPECT_EQ(report.status, 0) << report.text;
         EXPECT_NE(text("d.html").find("Difference over distance"), std::string::npos);
         const json rows = json::parse(text("d.json"));
         ASSERT_EQ(rows.at("curves").size(), 3U);
         EXPECT_EQ(rows.at("curves")[0].at("bins")[0].at("median"), j.at("curves")[0].at("bins")[0].at("median"));
         EXPECT_EQ(rows.at("thresholds").size(), 3U);
         ASSERT_EQ(rows.at("comparisons").size(), j.at("rows").size());
         EXPECT_EQ(rows.at("comparisons")[0].at("distance_m"), j.at("rows")[0].at("distance_m"));
         EXPECT_EQ(rows.at("comparisons")[0].at("scores").at("mae"), j.at("rows")[0].at("scores").begin()->at("mae"));
         const json told =
             facts("distance --agents 8 --occupancy 0.1 --size 96x72 --scores mae --causes --representation " +
                   impostor + " --json" + character)
                 .at("causes")[0];
         expect_causes(told.at("frames")[0]);
         EXPECT_GE(told.at("frames")[0].at("agents").size(), 2U);
         for (const json& agent : told.at("frames")[0].at("agents")) expect_causes(agent);
         EXPECT_FALSE(told.at("words").get<std::string>().empty());
       }},
      {"tune",
       [&] {
         const json j = facts(
             "tune --representation mesh:triangles=100 --agents 9 --size 160x120 --heights 3 --moments 1 " +
             std::string(
                 "--azimuth-deg 0,90 --elevation-deg 0 --rounds 4 --threshold mae=255 --promise-seeds 3 --prove 1 "
                 "--prove-figures 8 --budget-ms 100000 --page t.html --db t.sqlite --json") +
             character);
         EXPECT_NE(text("t.html").find("Which representation from which distance on"), std::string::npos);
         EXPECT_TRUE(j.at("software").is_boolean());
         EXPECT_NE(j.at("times").get<std::string>().find(j.at("renderer").get<std::string>()), std::string::npos);
         const Outcome report = run("report t.sqlite --out t2.html --json-out t.json");
         EXPECT_EQ(report.status, 0) << report.text;
         const json rows = json::parse(text("t.json"));
         ASSERT_EQ(rows.at("tunings").size(), 1U);
         EXPECT_EQ(rows.at("tunings")[0].at("representation"), j.at("representation"));
         EXPECT_EQ(rows.at("tunings")[0].at("budget_ns"), 1e11);
         EXPECT_EQ(rows.at("tunings")[0].value("tuned_switches", json::array()).size(), j.at("switches").size());
         EXPECT_EQ(rows.at("comparisons").size(), 6U) << "three heights from two sides, one candidate";
         EXPECT_EQ(j.at("characters")[0].at("candidates").size(), 2U);
         EXPECT_EQ(j.at("characters")[0].at("candidates")[0].at("heights").size(), 3U);
         EXPECT_EQ(j.at("chosen").size(), 3U);
         EXPECT_TRUE(j.at("representation").is_string());
         EXPECT_TRUE(j.at("budget").at("fits").get<bool>());
         EXPECT_GT(j.at("budget").at("measured_frame_ms").get<double>(), 0);
         EXPECT_EQ(j.at("promise").at("seeds").size(), 3U);
         EXPECT_EQ(j.at("proof").at("errors")[0].at("figures"), 8);
         EXPECT_EQ(j.at("proof").at("speed").at("seeds").size(), 1U);
         const Outcome nobody = run("tune --agents 0 --prove 1" + character);
         EXPECT_EQ(nobody.status, 2);
         EXPECT_NE(nobody.text.find("the crowd has no agents"), std::string::npos) << nobody.text;
         EXPECT_EQ(j.at("proof").at("score").at("seeds").size(), 1U);
         EXPECT_TRUE(j.at("promise_of_others").at("why_not").is_string());
         const Outcome alone = run("tune --prove 1 --prove-on mannequin" + character);
         EXPECT_EQ(alone.status, 2);
         EXPECT_NE(alone.text.find("of a character that was not tuned nothing is promised: one character was tuned"),
                   std::string::npos)
             << alone.text;
       }},
      {"ratio",
       [&] {
         const json j =
             facts("ratio --of mesh --to mesh:floor=1 --agents 4 --size 64x48 --pairs 20 --json" + character);
         EXPECT_TRUE(j.at("valid").get<bool>());
         EXPECT_EQ(j.at("pairs"), 20);
         const double ratio = j.at(j.at("headline").get<std::string>() + "_ratio").get<double>();
         EXPECT_GT(ratio, 0.02);
         EXPECT_LT(ratio, 50);
         EXPECT_LE(j.at("interval").at(0).get<double>(), ratio);
         EXPECT_GE(j.at("interval").at(1).get<double>(), ratio);
         ASSERT_EQ(j.at("levels").size(), 1U) << "of 500 triangles, which every ratio has";
         EXPECT_GT(j.at("levels").at("mesh:triangles=500")[0].at("poses").get<int>(), 0);
       }},
      {"bench",
       [&] {
         const json j =
             facts("bench --representation " + impostor +
                   " --agents 2,5 --occupancy 0 --size 64x48 --rounds 10 --no-floors --budget-ms 60000 --out "
                   "r.sqlite --json" +
                   character);
         ASSERT_EQ(j.at("measurements").size(), 4U);
         for (const json& row : j.at("measurements")) {
           EXPECT_EQ(row.at("status"), "valid") << row.dump();
           EXPECT_GT(row.at("frame_ns").get<double>(), 0);
         }
         EXPECT_EQ(text("r.sqlite").substr(0, 13), "SQLite format");
         EXPECT_TRUE(j.at("levels").empty());
         const std::string levels =
             "bench --representation mesh:triangles=200 --agents 2 --occupancy 0 --size 64x48 "
             "--rounds 10 --no-floors --out levels.sqlite --json";
         const json drawn = facts(levels + character).at("levels");
         EXPECT_GT(drawn.at("mesh:triangles=200")[0].at("max_m").get<double>(), 0);
       }},
      {"sweep",
       [&] {
         write_file(work_ / "s.toml",
                    "[scenario]\nwidth = 64\nheight = 48\nrepresentation = \"" + impostor +
                        "\"\n[[scenario.character]]\nsource = \"mannequin:triangles=500\"\n[axes]\ncrowd.agents = [2, "
                        "5]\n[measure]\nrounds = 10\ntime_limit_s = 0.1\n");
         EXPECT_NE(run("sweep s.toml --dry-run").text.find("s: 2 points in 2 conditions"), std::string::npos);
         const json j = facts("sweep s.toml --json");
         ASSERT_EQ(j.at("sweep_points").size(), 6U);  // with the reference and its twin
         EXPECT_EQ(j.at("sweep_points")[0].at("state"), "done");
         EXPECT_EQ(j.at("measurements").size(), 4U);
         const Outcome tables = run("sweep s.toml --markdown s.md");
         EXPECT_EQ(tables.status, 0);
         EXPECT_NE(text("s.md").find("| crowd.agents | representation |"), std::string::npos) << text("s.md");
       }},
      {"merge",
       [&] {
         const json j = facts("merge merged.sqlite s.sqlite --json");
         EXPECT_EQ(j.at("sweep_points").size(), 6U);
       }},
      {"correlate",
       [&] {
         const std::string views = "quality --height-px 24,40 --azimuth-deg 0,90 --rows 64 --db q.sqlite --json" +
                                   character + " --representation ";
         facts(views + impostor);
         facts(views + "rigid");
         const json j =
             facts("correlate q.sqlite --scores silhouette_iou,mae,flip --markdown q.md --pictures worst --json");
         EXPECT_EQ(j.at("views"), 8);
         EXPECT_EQ(j.at("groups"), 2);
         ASSERT_EQ(j.at("pairs").size(), 3U);
         EXPECT_GT(j.at("pairs")[2].at("spearman").at("value"), 0.5) << "mae and flip agree";
         EXPECT_NE(text("q.md").find("| `flip` |"), std::string::npos);
         EXPECT_TRUE(fs::is_directory(work_ / "worst"));
       }},
      {"stability",
       [&] {
         const Outcome listed = run("stability --list");
         EXPECT_NE(listed.text.find("world_1e7"), std::string::npos) << listed.text;
         const json j = facts(
             "stability --small --representation mesh --case time_wrap --case world_1e3 --markdown "
             "holds.md --page holds.html --db holds.sqlite --json");
         ASSERT_EQ(j.at("cases").size(), 2U);
         const Outcome report = run("report holds.sqlite --json-out holds.json");
         EXPECT_EQ(report.status, 0) << report.text;
         const json stored = json::parse(text("holds.json")).at("stability_cases");
         ASSERT_EQ(stored.size(), 2U);
         for (size_t i = 0; i < 2; ++i) {
           EXPECT_EQ(stored[i].at("name"), j.at("cases")[i].at("case"));
           for (const char* member : {"representation", "measured", "bound", "unit", "pass", "note"})
             EXPECT_EQ(stored[i].at(member), j.at("cases")[i].at(member)) << member;
         }
         for (const char* member : {"case", "representation", "measured", "bound", "unit", "pass"})
           EXPECT_TRUE(j.at("cases")[1].contains(member)) << member;
         EXPECT_EQ(j.at("failed"), 0);
         EXPECT_NE(text("holds.md").find("| `world_1e3` |"), std::string::npos);
         EXPECT_NE(text("holds.html").find("world_1e3"), std::string::npos);
       }},
      {"regress",
       [&] {
         // The file with itself: nothing is worse; whether ten rounds are enough to pass depends on the machine's mood.
         const Outcome same =
             run("regress r.sqlite r.sqlite --detect 900 --run-scatter 1 --markdown regress.md --junit regress.xml");
         EXPECT_TRUE(same.status == 0 || same.status == 3) << same.text;
         EXPECT_NE(same.text.find(": 0 worse"), std::string::npos) << same.text;
         EXPECT_NE(text("regress.md").find(": 0 worse"), std::string::npos);
         EXPECT_NE(text("regress.xml").find("failures=\"0\""), std::string::npos);
         const json j = json::parse(run("regress r.sqlite r.sqlite --detect 900 --run-scatter 1 --json", false).text);
         ASSERT_EQ(j.at("times").size(), 2U) << "without floors the reference has no yardstick";
         EXPECT_EQ(j.at("times")[0].at("change"), 0);
         EXPECT_EQ(j.at("pictures").size(), 2U);
         EXPECT_EQ(j.at("pictures")[0].at("share"), 0);
         EXPECT_NE(run("regress r.sqlite r.sqlite --explain 1 --pictures why").text.find("difference.png"),
                   std::string::npos);
         EXPECT_EQ(run("regress r.sqlite q.sqlite").status, 3) << "nothing in common";
         // One run says nothing of what differs between runs; five files of a folder do.
         EXPECT_NE(run("regress r.sqlite r.sqlite").text.find("5 runs of each are needed"), std::string::npos);
         std::filesystem::create_directory(work_ / "runs");
         for (const char* name : {"1", "2", "3", "4", "5"})
           std::filesystem::copy_file(work_ / "r.sqlite", work_ / "runs" / (std::string(name) + ".sqlite"));
         const Outcome folders = run("regress runs runs --detect 900");
         EXPECT_EQ(folders.status, 0) << folders.text;
       }},
      {"history",
       [&] {
         // One file given twice stands for two runs.
         const json j = facts("history r.sqlite r.sqlite --chart h.html --json");
         ASSERT_EQ(j.at("series").size(), 2U);
         EXPECT_EQ(j.at("series")[0].at("values").size(), 2U);
         EXPECT_TRUE(j.at("series")[0].at("changes").empty());
         EXPECT_NE(text("h.html").find("Nothing changed"), std::string::npos);
         EXPECT_NE(run("history r.sqlite").text.find("no point was measured twice"), std::string::npos);
       }},
      {"model",
       [&] {
         const json j = facts("model r.sqlite --markdown model.md --json");
         ASSERT_EQ(j.at("scenes").size(), 1U);
         const json& scene = j.at("scenes")[0].at("scene");
         EXPECT_EQ(scene.at("models").size(), 2U);
         EXPECT_NE(scene.at("models")[0].at("absent").get<std::string>().find("a model takes 5 at least"),
                   std::string::npos);
         EXPECT_EQ(scene.at("pareto")[0].at("entries").size(), 2U);
         EXPECT_NE(text("model.md").find("## Cost model"), std::string::npos);
         EXPECT_NE(run("model q.sqlite").text.find("no point was timed"), std::string::npos);
       }},
      {"export",
       [&] {
         const Outcome outcome =
             run("export r.sqlite --csv e.csv --scores-csv es.csv --json-out e.json --google-benchmark g2.json "
                 "--bencher b.json --frame-log f.csv --markdown e.md");
         EXPECT_EQ(outcome.status, 0) << outcome.text;
         const json bencher = json::parse(text("b.json"));
         ASSERT_EQ(bencher.size(), 4U);
         EXPECT_GT(bencher.begin()->at("wall-time").at("value").get<double>(), 0);
         EXPECT_EQ(text("f.csv").substr(0, 30), "Application,MsBetweenPresents,");
         const std::string frames = text("f.csv");
         EXPECT_EQ(std::count(frames.begin(), frames.end(), '\n'), 1 + 4 * 10);
         EXPECT_EQ(json::parse(text("e.json")).at("controls").size(), 4U) << "two points, CPU and wall clock";
       }},
      {"study serve",
       [&] {
         fs::create_directories(work_ / "served/page");
         write_file(work_ / "served/page/index.html", std::string_view("<p>page</p>"));
         write_file(work_ / "served/page/trials.json",
                    R"({"format": 1, "study": "abc", "task": "forced-choice", "stimuli": {"s1": {}},
                        "answers": [{"value": "upper"}, {"value": "lower"}], "lists": [{"id": "1",
                        "trials": [{"trial": "t1", "stimulus": "s1", "block": 1, "kind": "main"}]}]})");
         const Outcome served = run("study serve served --port 0", true, "timeout --foreground -s INT 1");
         EXPECT_NE(served.text.find("http://127.0.0.1:"), std::string::npos) << served.text;
         EXPECT_NE(served.text.find("every answer that was acknowledged is in served/answers.sqlite"),
                   std::string::npos)
             << served.text;
       }},
      {"study answers",
       [&] {
         write_file(work_ / "served/sides.json",
                    R"({"stimuli": {"s1": {"kind": "test", "condition_name": "d=5", "level": 5, "upper": "mesh",
                        "lower": "flat", "expected": "upper"}}})");
         write_file(
             work_ / "saved.json",
             R"([{"study": "abc", "participant": "p", "list": "1", "item": "t1", "kind": "main", "stimulus": "s1",
                         "answer": "upper", "rt_ms": 900}])");
         const json j = facts("study answers saved.json --study served --csv given.csv --json");
         EXPECT_EQ(j.at("trials"), 1);
         EXPECT_EQ(
             facts("study analyze given.csv --resamples 0 --json").at("tasks").at(0).at("conditions").at(0).at("yes"),
             1);
         EXPECT_NE(run("study answers served/answers.sqlite --study served").text.find("has no answers of this study"),
                   std::string::npos);
       }},
      {"study freeze",
       [&] {
         write_file(work_ / "study.toml",
                    "[scenario]\nwidth = 64\nheight = 48\ncrowd.agents = 3\ndisplay.model = \"standard_fhd\"\n"
                    "[[scenario.character]]\n"
                    "source = \"mannequin:triangles=500\"\n[conditions]\ntest = \"mesh:triangles=60\"\n"
                    "[stimulus]\nseconds = 0.1\nlead_in_seconds = 0\ncrowds = 1\nseeds = \"same\"\n"
                    "[catch]\nidentical = 0\nbroken = 0\n[method]\nrepeats = 1\n");
         EXPECT_NE(run("study export study.toml out").text.find("is not frozen"), std::string::npos);
         write_file(work_ / "wrong.toml", text("study.toml") + "[factors]\nclip = [\"fly\"]\n");
         for (const char* command : {"study freeze wrong.toml", "study export wrong.toml --dry-run"}) {
           const Outcome wrong = run(command);
           EXPECT_EQ(wrong.status, 2) << command;
           EXPECT_NE(wrong.text.find("wrong.toml:21: "), std::string::npos) << wrong.text;
         }
         const json frozen = facts("study freeze study.toml --json");
         EXPECT_EQ(frozen.at("hash").get<std::string>().size(), 64U);
         EXPECT_EQ(frozen.at("default_consent"), true) << "it has a place left for who runs the study";
       }},
      {"study export",
       [&] {
         const json dry = facts("study export study.toml --dry-run --json");
         EXPECT_EQ(dry.at("conditions").size(), 1U);
         EXPECT_EQ(dry.at("lists"), 2);
         EXPECT_NE(run("study export study.toml --dry-run").text.find("2 lists, 2 participants, 3 trials each"),
                   std::string::npos);
         const json j = facts("study export study.toml out --json");
         EXPECT_EQ(j.at("stacked"), json::parse(text("out/page/trials.json")).at("stimuli").size());
         EXPECT_EQ(facts("study export study.toml out --json").at("stacked"), 0);
         // The scenario's display, or the one that is asked for: its light and its pixels a degree are those of
         // `compare` on it, and so are scores of the same frames.
         write_file(work_ / "seat.json",
                    R"({"pixels_per_degree": 31, "max_luminance": 120, "contrast": 500, "E_ambient": 40})");
         EXPECT_EQ(run("study export study.toml seat --display seat.json").status, 0);
         for (const auto& [folder, display] : {std::pair("out", "standard_fhd"), std::pair("seat", "seat.json")}) {
           SCOPED_TRACE(display);
           const json study = json::parse(text(std::string(folder) + "/study.json"));
           const json pair = study.at("stimuli").at(0);
           const auto half = [&pair, work = std::string(folder)](const char* which) {
             return fmt::format("{}/work/{}.mp4", work, pair.at(which).at("half").get<std::string>());
           };
           ASSERT_EQ(pair.at("test_on_top"), true);
           const json same = facts(fmt::format("compare {} {} --scores flip,cvvdp --display {} --json", half("lower"),
                                               half("upper"), display));
           EXPECT_EQ(study.at("scores_display"), same.at("display").at("text"));
           const auto first = std::ranges::find(pair.at("scores"), "flip", [](const json& s) { return s.at("score"); });
           ASSERT_NE(first, pair.at("scores").end());
           EXPECT_EQ(first->at("mean"), same.at("by_frame").at("flip").at(first->at("worst_frame").get<size_t>()));
         }
         EXPECT_NE(json::parse(text("out/study.json")).at("scores_display").get<std::string>().find("standard_fhd"),
                   std::string::npos)
             << "the scenario's display";
       }},
      {"study analyze",
       [&] {
         write_file(work_ / "answers.csv",
                    "who,distance_m,seen\n1,5,yes\n1,10,no\n1,15,yes\n2,5,yes\n2,10,yes\n2,15,no\n");
         const std::string table = "study analyze --table answers.csv --columns participant=who,answer=seen";
         const json j = facts(table + " --json").at("tasks").at(0).at("conditions").at(0);
         EXPECT_EQ(j.at("yes"), 4);
         EXPECT_EQ(j.at("participants"), 2);
         const auto chance = [&](const char* options) {
           return facts(table + options + " --resamples 0 --json").at("settings").at("chance").get<double>();
         };
         EXPECT_EQ(chance(" --guess 0.25"), 0.25) << "one of four alternatives";
         EXPECT_EQ(chance(" --guess 0.25 --chance 0.4"), 0.4);
         EXPECT_EQ(chance(" --guess 0"), 0.5);
         EXPECT_EQ(run(table + ",level=distance_m --falling --resamples 10 --markdown answers.md").status, 0);
         EXPECT_NE(text("answers.md").find("Psychometric function: logistic, falling"), std::string::npos);
         const Outcome wrong = run("study analize");
         EXPECT_EQ(wrong.status, 2);
         EXPECT_NE(wrong.text.find("'analize' is not a command of study; did you mean 'analyze'?"), std::string::npos)
             << wrong.text;
         EXPECT_NE(
             run("study").text.find("study: a command is missing; there are freeze, export, serve, answers, analyze, "
                                    "simulate, power"),
             std::string::npos);
         EXPECT_NE(run("study analyze --jsn").text.find("study analyze has no option '--jsn'; did you mean --json?"),
                   std::string::npos);
         EXPECT_NE(run("study analyze").text.find("there are no answers to analyse"), std::string::npos);
         EXPECT_NE(
             run("study analyze answers.csv --ties drp").text.find("--ties: there is no 'drp'; did you mean 'drop'?"),
             std::string::npos);
         // Everything that is written, and a plan that was frozen for other answers.
         write_file(work_ / "asked.toml", "[conditions]\ntest = \"flat\"\n[analysis]\nmargin = 0.2\n");
         write_file(work_ / "scores.csv", "condition,ssim\nnear,0.9\nfar,0.8\n");
         std::string answers = "study,participant,condition,answer\n";
         for (int i = 0; i < 40; ++i)
           answers += fmt::format("0123456789abcdef,{},{},{}\n", i % 4, i % 2 == 0 ? "near" : "far",
                                  i % 3 == 0 ? "yes" : "no");
         write_file(work_ / "studied.csv", answers);
         const json planned = facts(
             "study analyze studied.csv --plan asked.toml --scores scores.csv --between 0.3 --resamples 20 --page "
             "page.html --out all --export other --json");
         EXPECT_EQ(planned.at("plan").at("standing"), "Not the planned analysis");
         EXPECT_EQ(planned.at("plan").at("sentences").at(0), "asked.toml was not frozen before the first answer.");
         EXPECT_NE(planned.at("plan").at("sentences").at(1).get<std::string>().find("--between 0.3"),
                   std::string::npos);
         EXPECT_EQ(planned.at("settings").at("margin"), 0.2);
         EXPECT_EQ(planned.at("tasks")[0].at("differences").size(), 1U);
         EXPECT_EQ(planned.at("tasks")[0].at("prediction").at("best"), "ssim");
         EXPECT_NE(text("page.html").find("Not the planned analysis"), std::string::npos);
         for (const char* file : {"all/report.html", "all/report.md", "all/analysis.json", "other/analysis.R",
                                  "other/dataset_description.json", "other/data/study_answers_data.csv"})
           EXPECT_TRUE(fs::exists(work_ / file)) << file;
       }},
      {"study simulate",
       [&] {
         const json j = facts(
             "study simulate --observers 12 --levels 0,1,2,3 --threshold 1.5 --slope 2 --repeats 10 --out "
             "simulated.csv --json");
         EXPECT_EQ(j.at("observers"), "simulated");
         EXPECT_EQ(j.at("answers"), 480);
         const json curve =
             facts("study analyze simulated.csv --guess 0 --resamples 0 --level 0.5 --json").at("tasks").at(0);
         EXPECT_NEAR(curve.at("curves").at(0).at("threshold").get<double>(), 1.5, 0.3);
         EXPECT_EQ(curve.at("mixed_models").at(0).at("participants"), 12);
         // Of an exported study, as its server would keep them.
         EXPECT_EQ(
             facts("study simulate served --observers 5 --seed 2 --out served/simulated.sqlite --json").at("answers"),
             5);
         const json shares = facts("study analyze served/simulated.sqlite --resamples 0 --random none --json")
                                 .at("tasks")
                                 .at(0)
                                 .at("conditions")
                                 .at(0);
         EXPECT_EQ(shares.at("yes").get<int>() + shares.at("no").get<int>(), 5);
         EXPECT_EQ(run("study simulate served --out served/simulated.sqlite").status, 2) << "it is there";
         EXPECT_NE(run("study simulate --out x.csv").text.find("there is nothing to answer"), std::string::npos);
         run("study simulate served --observers 2 --out simulated.csv");
         EXPECT_TRUE(text("simulated.csv").starts_with("observers,study,"));
       }},
      {"study power",
       [&] {
         const json j = facts("study power --participants 6,24 --simulations 40 --json");
         ASSERT_EQ(j.at("rows").size(), 2U);
         EXPECT_LT(j.at("rows")[0].at("power").get<double>(), j.at("rows")[1].at("power").get<double>());
         EXPECT_EQ(facts("study power study.toml --simulations 5 --json").at("plan"), "study.toml");
         EXPECT_NE(run("study power --participants 6 --simulations 5").text.find("simulated: 0.5 logits"),
                   std::string::npos);
         // A plan's own design: its threshold, and its margin.
         write_file(work_ / "planned.toml",
                    text("study.toml") +
                        "[question]\ntask = \"forced-choice\"\nask = \"differs\"\n[factors]\nmesh.triangles = "
                        "[40, 80, 160, 320]\n[analysis]\nlevel = \"mesh.triangles\"\nfalling = true\nmargin = 0.2\n");
         const std::string power = "study power planned.toml --participants 8 --repeats 3 --simulations 5";
         const json own = facts(power + " --threshold 150 --slope -0.03 --json");
         EXPECT_EQ(own.at("threshold").at("threshold"), 150);
         EXPECT_EQ(own.at("threshold").at("levels"), (json{40, 80, 160, 320}));
         EXPECT_EQ(own.at("threshold").at("guess"), 0.5);
         EXPECT_EQ(own.at("threshold").at("rows")[0].at("trials_per_participant"), 12);
         EXPECT_EQ(own.at("equivalence").at("rows")[0].at("trials_per_participant"), 3);
         EXPECT_LT(facts(power + " --json").at("threshold").at("slope").get<double>(), 0) << "it falls";
         EXPECT_NE(run(power).text.find("95 % CI width"), std::string::npos);
         EXPECT_EQ(run(power + " --effect 1").status, 2) << "there are no two conditions";
         EXPECT_EQ(run("study power --threshold 3").status, 2) << "of no plan";
       }},
      {"report",
       [&] {
         const Outcome outcome =
             run("report r.sqlite --out r.html --markdown r.md --csv r.csv --scores-csv s.csv --json-out r.json "
                 "--google-benchmark g.json");
         EXPECT_EQ(outcome.status, 0) << outcome.text;
         EXPECT_NE(text("r.html").find("</html>"), std::string::npos);
         EXPECT_NE(text("r.md").find("flat"), std::string::npos);
         EXPECT_NE(text("r.csv").find("frame_ns"), std::string::npos);
         EXPECT_NE(text("s.csv").find("ssim"), std::string::npos);
         EXPECT_EQ(json::parse(text("r.json")).at("measurements").size(), 4U);
         EXPECT_GT(json::parse(text("g.json")).at("benchmarks").size(), 0U);
         fs::copy_file(work_ / "r.sqlite", work_ / "again.sqlite");
         const Outcome both = run("report r.sqlite again.sqlite --out both.html --markdown both.md");
         EXPECT_EQ(both.status, 0) << both.text;
         EXPECT_NE(text("both.md").find("again.sqlite: times as fast as mesh"), std::string::npos);
         EXPECT_NE(text("both.html").find("The files beside each other"), std::string::npos);
         EXPECT_EQ(run("report r.sqlite r.sqlite --out twice.html").status, 2) << "a file is named twice";
       }},
      {"pair",
       [&] {
         const json j = facts("pair --a mesh --b " + impostor +
                              " --agents 4 --size 64x48 --frames 3 --out clip.mp4 --json" + character);
         EXPECT_EQ(j, json::parse(text("clip.json")));
         EXPECT_FALSE(j.at("equal").get<bool>());
         EXPECT_GT(fs::file_size(work_ / "clip.mp4"), 1000U);
       }},
      {"view",
       [&] {
         const std::string line = "view --agents 4 --size 64x48 --frames 2 --screenshot v.png" + character;
         if (!test::Xvfb::installed()) {
           const Outcome outcome = run(line);
           EXPECT_EQ(outcome.status, 2) << "without a display it says so (Xvfb is not installed)";
           return;
         }
         const test::Xvfb server;
         display_ = "DISPLAY=" + server.display() + " WAYLAND_DISPLAY=";
         const Outcome outcome = run(line);
         display_.clear();
         ASSERT_EQ(outcome.status, 0) << outcome.text;
         EXPECT_FALSE(is_flat(picture("v.png")));
       }},
      {"demo",
       [&] {
         const Outcome outcome =
             run("demo --tiny --representation flat:views=sphere-8x3,texels=64,frames=8" + character, false);
         EXPECT_EQ(outcome.status, 0) << outcome.text;
         EXPECT_TRUE(outcome.text.ends_with("/crowdbench-demo/report.html\n"))
             << "the report's path, last: " << outcome.text;
         EXPECT_NE(text("crowdbench-demo/report.html").find("</html>"), std::string::npos);
         EXPECT_EQ(text("crowdbench-demo/results.sqlite").substr(0, 13), "SQLite format");
         int clips = 0;
         for (const auto& entry : fs::directory_iterator(work_ / "crowdbench-demo"))
           clips += entry.path().extension() == ".mp4" ? 1 : 0;
         EXPECT_GE(clips, 1);
       }},
  };
  std::set<std::string> listed;
  for (const std::string& command : support::driver_commands()) listed.insert(command);
  std::set<std::string> tried;
  for (const Trial& trial : trials) tried.insert(trial.command);
  EXPECT_EQ(tried, listed) << "the table above holds every command of --help, and no other";
  for (const Trial& trial : trials) {
    SCOPED_TRACE(trial.command);
    trial.run();
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace crowdbench::bench
