// Every script of tools/, run on tiny input: each does its work, and each check refuses what it is there to refuse.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "core/command_line.h"
#include "core/files.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench {
namespace {
namespace fs = std::filesystem;

using support::Outcome;

const fs::path kTop = CROWDBENCH_SOURCE_DIR;

// By which test each is run.
const std::map<std::string, std::string> kScripts = {
    {"bundle.sh", "Bundle"},
    {"check_bundle.sh", "Bundle"},
    {"check_format.sh", "FormatCheck"},
    {"check_headers.sh", "HeaderCheck"},
    {"check_shaders.sh", "ShaderCheck"},
    {"check_tidy.sh", "TidyCheck"},
    {"driver.mjs", "ReliefQuality"},
    {"figures.sh", "Figures"},
    {"flat_between.mjs", "FlatBetween"},
    {"gpu_check.sh", "Bundle"},
    {"lod_equal.mjs", "LodEqual"},
    {"masked_hair.mjs", "MaskedHair"},
    {"page_check.mjs", "PageCheck"},
    {"polypostor_figures.mjs", "PolypostorFigures"},
    {"relief_quality.mjs", "ReliefQuality"},
    {"relief_sweep.mjs", "ReliefSweep"},
    {"score_correlations.sh", "ScoreCorrelations"},
    {"approaches.sh", "Approaches"},
    {"drivers.mjs", "Drivers"},
    {"study_evidence.sh", "StudyEvidence"},
    {"study_kill.mjs", "StudyKill"},
    {"study_observer.mjs", "StudyObserver"},
    {"sweep_kill.mjs", "SweepKill"},
    {"tune_promises.mjs", "TunePromises"},
    {"random_faults.mjs", "RandomFaults"},
    {"small_sweep.mjs", "SweepKill"},
    {"relief_tears.mjs", "ReliefTears"},
    {"statistics_evidence.sh", "StatisticsEvidence"},
};

std::string quoted(const fs::path& path) { return shell_quoted(path.string()); }

class ScriptsGl : public ::testing::Test {
 protected:
  void SetUp() override {
    CROWDBENCH_SKIP_SANITIZED("the driver's own tests: scripts are for what is measured with, a release build");
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  }
  // `script` with `arguments` in the scratch folder, where bakes are kept too: both streams.
  Outcome run(const std::string& script, const std::string& arguments) const {
    EXPECT_EQ(kScripts.at(script), ::testing::UnitTest::GetInstance()->current_test_info()->name()) << script;
    const std::string program = (script.ends_with(".mjs") ? "node " : "") + quoted(kTop / "tools" / script);
    return support::run_shell("cd " + quoted(folder_.path()) +
                              " && CROWDBENCH_CACHE_DIR=cache CROWDBENCH_DEVICE=software " + program + " " + arguments +
                              " 2>&1");
  }
  // The package of the first of these programs that is missing; empty when all are there.
  static std::string missing(const std::vector<std::pair<std::string, std::string>>& programs_and_packages) {
    for (const auto& [program, package] : programs_and_packages)
      if (support::run_shell("command -v " + program + " >/dev/null").status != 0)
        return program + " is not installed (" + package + ")";
    return "";
  }
  std::string text(const std::string& file) const { return read_text(folder_ / file); }

  support::ScratchFolder folder_;
  std::string build_ = quoted(program_directory().parent_path());
  std::string driver_ = quoted(program_directory() / "crowdbench");
};
using Scripts = ScriptsGl;

#define NEEDS(...) \
  if (const std::string absent = missing({__VA_ARGS__}); !absent.empty()) GTEST_SKIP() << absent
using Need = std::pair<std::string, std::string>;

TEST(ScriptsTable, HoldsEveryScript) {
  std::set<std::string> there;
  for (const auto& entry : fs::directory_iterator(kTop / "tools")) there.insert(entry.path().filename().string());
  std::set<std::string> stated;
  for (const auto& [script, test] : kScripts) {
    stated.insert(script);
    bool found = false;
    const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
    for (int s = 0; s < all.total_test_suite_count(); ++s)
      for (int t = 0; t < all.GetTestSuite(s)->total_test_count(); ++t)
        found = found || all.GetTestSuite(s)->GetTestInfo(t)->name() == test;
    EXPECT_TRUE(found) << "no test " << test << " runs " << script;
  }
  EXPECT_EQ(stated, there);
}

// ---- figures

// No cell that is empty of what it should hold, and as many tables as there are headings of columns.
void expect_tables(const std::string& page, size_t tables) {
  const std::regex rule("\n\\|(---\\|)+\n\\| ");
  EXPECT_EQ(
      static_cast<size_t>(std::distance(std::sregex_iterator(page.begin(), page.end(), rule), std::sregex_iterator())),
      tables)
      << page;
  EXPECT_FALSE(std::regex_search(page, std::regex("[|/.] *(-?nan|NaN|-?inf|-?Infinity|undefined|null)\\b"))) << page;
}

TEST_F(ScriptsGl, Figures) {
  NEEDS(Need{"awk", "mawk"});
  const Outcome outcome = run("figures.sh", driver_ + " figures.md --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::string page = text("figures.md");
  expect_tables(page, 4);
  // The same sections as the page of the project has, each with the commands that made it.
  const std::regex heading("\n## [^\n]*");
  const std::string published = read_text(kTop / "docs/figures.md");
  for (auto it = std::sregex_iterator(published.begin(), published.end(), heading); it != std::sregex_iterator(); ++it)
    EXPECT_NE(page.find(it->str()), std::string::npos) << it->str();
  for (const char* command : {"ratio", "quality", "switch-distance", "popmap"})
    EXPECT_NE(page.find(std::string("\n    crowdbench ") + command + " "), std::string::npos) << command;
  const Outcome wrong = run("figures.sh", driver_ + " figures.md --frobnicate");
  EXPECT_EQ(wrong.status, 2) << wrong.text;
  const Outcome failed = run("figures.sh", "false other.md --tiny");
  EXPECT_NE(failed.status, 0) << "a driver that fails is no figure";
  EXPECT_FALSE(fs::exists(folder_ / "other.md"));
}

TEST_F(ScriptsGl, LodEqual) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("lod_equal.mjs", driver_ + " levels --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex(R"(\n\| flat:views=sphere-4x1,frames=2 \| 30 \| 0\.\d+ \| )")))
      << outcome.text;
  EXPECT_NE(outcome.text.find("\n| rigid:poses=2 | 30 |"), std::string::npos);
  EXPECT_EQ(outcome.text.find("NaN"), std::string::npos) << outcome.text;
  const Outcome again = run("lod_equal.mjs", driver_ + " levels --tiny");
  EXPECT_EQ(again.text, outcome.text) << "what was measured is kept";
  EXPECT_EQ(run("lod_equal.mjs", driver_ + " levels --heights 1").status, 2);
  EXPECT_EQ(run("lod_equal.mjs", driver_).status, 2);
}

TEST_F(ScriptsGl, MaskedHair) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("masked_hair.mjs", driver_ + " hair --tiny");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(
      std::regex_search(outcome.text, std::regex(R"(\n\| masked cards \| rigid:poses=2 \| 60 \| [01]\.\d+ \| )")))
      << outcome.text;
  EXPECT_EQ(outcome.text.find("NaN"), std::string::npos) << outcome.text;
  EXPECT_EQ(run("masked_hair.mjs", driver_).status, 2);
}

TEST_F(ScriptsGl, PolypostorFigures) {
  NEEDS(Need{"node", "nodejs"});
  for (const char* table : {"memory", "quality", "flicker", "characters", "tears", "speed", "bake"}) {
    const Outcome outcome = run("polypostor_figures.mjs", driver_ + " " + table + " --tiny");
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    expect_tables("\n" + outcome.text, table == std::string("quality") ? 2 : 1);
  }
  EXPECT_EQ(run("polypostor_figures.mjs", driver_ + " nothing").status, 2);
}

TEST_F(ScriptsGl, FlatBetween) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("flat_between.mjs", driver_ + " --tiny");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  expect_tables("\n" + outcome.text, 1);
  EXPECT_EQ(run("flat_between.mjs", driver_ + " --fast").status, 2);
  EXPECT_EQ(run("flat_between.mjs", "").status, 2);
}

TEST_F(ScriptsGl, ReliefQuality) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("relief_quality.mjs", driver_ + " --tiny");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  expect_tables("\n" + outcome.text, 1);
  EXPECT_NE(outcome.text.find("| three-quarter | 0."), std::string::npos) << outcome.text;
  EXPECT_EQ(run("relief_quality.mjs", "").status, 2);
}

TEST_F(ScriptsGl, ScoreCorrelations) {
  const Outcome outcome = run("score_correlations.sh", driver_ + " scores.md --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::string page = text("scores.md");
  for (const char* part : {"## Spearman's rho", "## Kendall's tau-b", "| `ssim` |", "| `cvvdp` |", "4 views",
                           "crowdbench quality --representation flat:views=hemi-4,rigid"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  // The pictures that the page shows are there.
  const std::regex link("\\]\\(([^)]+\\.png)\\)");
  for (auto at = std::sregex_iterator(page.begin(), page.end(), link); at != std::sregex_iterator(); ++at)
    EXPECT_TRUE(fs::exists(folder_ / (*at)[1].str())) << (*at)[1].str();
  EXPECT_EQ(run("score_correlations.sh", driver_ + " scores.md --frobnicate").status, 2);
  // Rows that are kept make a page without drawing; without the file there is none.
  EXPECT_NE(run("score_correlations.sh", driver_ + " other.md --rows none.sqlite --tiny").status, 0);
  EXPECT_FALSE(fs::exists(folder_ / "other.md"));
}

TEST_F(ScriptsGl, StatisticsEvidence) {
  NEEDS(Need{"awk", "mawk"});
  const Outcome outcome = run("statistics_evidence.sh", build_ + " statistics.md --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::string page = text("statistics.md");
  EXPECT_NE(page.find("The control of 3 runs"), std::string::npos) << page;
  EXPECT_TRUE(std::regex_search(page, std::regex("differed in [0-3] \\(.*detectable change: [0-9]+\\.[0-9] %")))
      << page;
  EXPECT_EQ(run("statistics_evidence.sh", build_ + " statistics.md --frobnicate").status, 2);
  EXPECT_EQ(run("statistics_evidence.sh", "nowhere other.md --tiny").status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "other.md"));
}

TEST_F(ScriptsGl, Drivers) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("drivers.mjs", driver_ + " pictures --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text,
                                std::regex("128 bits[^|]*\\|[^]*\\| `time_wrap` \\| [0-9.e-]+ \\| [^|]+ \\| [0-9]")));
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex("\\| mesh \\| [0-9]+, [0-9.e-]+ \\|"))) << outcome.text;
  EXPECT_EQ(outcome.text.find("undefined"), std::string::npos) << outcome.text;
  EXPECT_EQ(run("drivers.mjs", driver_ + " pictures --frobnicate").status, 2);
  EXPECT_EQ(run("drivers.mjs", "").status, 2);
}

// A character alone and one that was not tuned, each held against what was promised of it.
TEST_F(ScriptsGl, TunePromises) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("tune_promises.mjs", driver_ + " tunings --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(std::regex_search(
      outcome.text, std::regex("\\| mannequin_triangles=500 \\| [^|]+ \\| [0-9.]+ to [0-9.]+ \\| "
                               "[0-2] of 2 \\| [0-9.]+ to [0-9.]+ \\| [0-2] of 2 \\| 0 of 0 \\| [0-4] of 4")))
      << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex("\\| within \\| stated: 95 % \\| [01] of 1 ")))
      << outcome.text;
  EXPECT_EQ(outcome.text.find("undefined"), std::string::npos) << outcome.text;
  // What was found is kept.
  EXPECT_EQ(run("tune_promises.mjs", "/bin/false tunings --tiny").text, outcome.text);
  EXPECT_EQ(run("tune_promises.mjs", driver_ + " tunings --characters 'a;b;c'").status, 2);
  EXPECT_EQ(run("tune_promises.mjs", driver_ + " tunings --seeds").status, 2);
}

// Every representation's line of what is argued, and numbers of those that the plan names.
TEST_F(ScriptsGl, Approaches) {
  write_file(folder_ / "tiny.toml",
             std::string_view("name = \"tiny\"\n[scenario]\nwidth = 64\nheight = 48\ncrowd.agents = 3\n"
                              "[axes]\nrepresentation = [\"mesh:triangles=500\", \"rigid\"]\n"
                              "[[axes.scene]]\nlabel = \"three\"\n[measure]\nscores = [\"ssim\"]\n"
                              "time_limit_s = 1\n[[table]]\ntitle = \"Speed\"\n"
                              "rows = \"representation\"\ncolumns = \"scene\"\nvalue = \"speed\"\n"));
  const Outcome outcome = run("approaches.sh", driver_ + " tiny.toml approaches.md");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::string page = text("approaches.md");
  const std::regex table("\n\\|---[|:-]+\n\\| ");
  EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), table), std::sregex_iterator()), 4) << page;
  EXPECT_TRUE(std::regex_search(page, std::regex("\\| rigid \\| [0-9.]+ \\| [0-9.]+ \\| - \\| - \\| [0-9.]+ \\|")));
  EXPECT_TRUE(std::regex_search(page, std::regex("\\| rigid \\| [0-9.]+ \\| 0[.][0-3][0-9] \\|")));
  EXPECT_EQ(page.find("n/a"), std::string::npos) << page;
  EXPECT_EQ(page.find("|  |"), std::string::npos) << "an argument is missing: " << page;
  EXPECT_EQ(run("approaches.sh", driver_ + " nowhere.toml approaches.md").status, 2);
  EXPECT_EQ(run("approaches.sh", "").status, 2);
}

TEST_F(ScriptsGl, StudyEvidence) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("study_evidence.sh", build_ + " evidence.md --seeds 2 --kills 1");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_NE(text("evidence.md").find("2 simulated studies a row"), std::string::npos);
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("threshold of the mixed model[^\n]* of 2 \\|")));
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("same-different, export to interval[^\n]* of 2 \\|")));
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("1 kills under 50 [^\n]* 0 lost")));
  // One part anew: the others stay as they are.
  ASSERT_EQ(run("study_evidence.sh", build_ + " evidence.md --seeds 3 --part quest").status, 0);
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("\\| QUEST\\+ [^\n]* of 3 \\|")));
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("threshold of the mixed model[^\n]* of 2 \\|")));
  EXPECT_TRUE(std::regex_search(text("evidence.md"), std::regex("1 kills under 50 [^\n]* 0 lost")));
  EXPECT_EQ(run("study_evidence.sh", build_ + " evidence.md --part luck").status, 2);
  EXPECT_EQ(run("study_evidence.sh", build_ + " none.md --part quest").status, 2);
  EXPECT_EQ(run("study_evidence.sh", build_ + " evidence.md --frobnicate").status, 2);
  EXPECT_EQ(run("study_evidence.sh", "nowhere other.md").status, 2);
}

TEST_F(ScriptsGl, ReliefTears) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("relief_tears.mjs", driver_ + " --tiny");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  expect_tables("\n" + outcome.text, 1);
  EXPECT_EQ(outcome.text.find("NaN"), std::string::npos) << outcome.text;
  EXPECT_EQ(run("relief_tears.mjs", "").status, 2);
}

// Three moments here; `node tools/sweep_kill.mjs build/release/bin/crowdbench FOLDER` tries two hundred.
TEST_F(ScriptsGl, SweepKill) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("sweep_kill.mjs", driver_ + " kill 3");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex("3 kills, [0-9]+ sweeps ended, 0 of them"))) << outcome.text;
  EXPECT_EQ(run("sweep_kill.mjs", "").status, 2);
}

// Eight faults here; `node tools/random_faults.mjs build/release/bin/crowdbench FOLDER` tries a thousand.
TEST_F(ScriptsGl, RandomFaults) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("random_faults.mjs", driver_ + " faults 8 7");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("8 faults by seed 7, 0 of them"), std::string::npos) << outcome.text;
  EXPECT_EQ(run("random_faults.mjs", "").status, 2);
}

TEST_F(Scripts, StudyKill) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("study_kill.mjs", driver_ + " kill --kills 3 --clients 4");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(std::regex_search(outcome.text, std::regex("3 kills under 4 simulated clients: [1-9][0-9]* answers "
                                                         "acknowledged, 0 lost, 0 changed, 0 kept twice")))
      << outcome.text;
  EXPECT_EQ(run("study_kill.mjs", "").status, 2);
}

// Its work is done by StudyBrowserSlow in tests/studies.
TEST_F(Scripts, StudyObserver) {
  NEEDS(Need{"node", "nodejs"});
  if (!fs::exists(kTop / "node_modules/puppeteer-core")) GTEST_SKIP() << "puppeteer-core is not installed (npm ci)";
  const Outcome outcome = run("study_observer.mjs", "http://127.0.0.1:1/ --browser lynx");
  EXPECT_EQ(outcome.status, 2) << outcome.text;
  EXPECT_NE(outcome.text.find("usage: study_observer.mjs URL"), std::string::npos) << outcome.text;
  EXPECT_NE(run("study_observer.mjs", "--quick").text.find("'--quick'"), std::string::npos);
}

// What it finds right is found by PagesBrowserSlow in tests/bench.
TEST_F(Scripts, PageCheck) {
  NEEDS(Need{"node", "nodejs"});
  NEEDS(Need{"chromium", "chromium"});
  if (!fs::exists(kTop / "node_modules/puppeteer-core")) GTEST_SKIP() << "puppeteer-core is not installed (npm ci)";
  write_file(folder_ / "wide.html",
             "<!doctype html><title>t</title><body><div style='width: 700px'>wide</div>"
             "<table id='t'><tr><td> 1 </td><td>2</td></tr></table>"
             "<script>console.warn('a warning')</script><script type='application/json' data-plot='none'></script>");
  const Outcome outcome = run("page_check.mjs", quoted(folder_ / "wide.html") + " --wait 0.2");
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  const nlohmann::json said = nlohmann::json::parse(outcome.text, nullptr, false);
  ASSERT_TRUE(said.is_object()) << outcome.text;
  EXPECT_EQ(said.at("views")[0].at("sideways_px"), 0);
  EXPECT_GT(said.at("views")[2].at("sideways_px"), 200) << "390 pixels hold no 700";
  EXPECT_EQ(said.at("views")[0].at("console")[0], "warn: a warning");
  EXPECT_EQ(said.at("views")[0].at("drawn"), 0);
  EXPECT_EQ(said.at("tables").at("t")[0], (nlohmann::json{"1", "2"}));
  EXPECT_EQ(run("page_check.mjs", "").status, 2);
  EXPECT_EQ(run("page_check.mjs", "nowhere.html --quick").status, 2);
  EXPECT_EQ(run("page_check.mjs", quoted(folder_ / "wide.html") + " --opens often").status, 2);
  const nlohmann::json times =
      nlohmann::json::parse(run("page_check.mjs", quoted(folder_ / "wide.html") + " --opens 2").text, nullptr, false);
  ASSERT_TRUE(times.is_array());
  ASSERT_EQ(times.size(), 2U);
  EXPECT_GT(times[1].at("load"), 0);
  EXPECT_GE(times[1].at("seen"), times[1].at("load"));
  EXPECT_GT(times[1].at("cpu"), 0) << "a browser that works takes some";
}

TEST_F(ScriptsGl, ReliefSweep) {
  NEEDS(Need{"node", "nodejs"});
  const Outcome outcome = run("relief_sweep.mjs", driver_ + " sweep --tiny");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  expect_tables(outcome.text, 1);
  size_t cells = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "sweep")) {
    if (entry.path().extension() != ".json") continue;
    ++cells;
    const nlohmann::json cell = nlohmann::json::parse(read_text(entry.path()));
    EXPECT_GT(cell.at("iou").get<double>(), 0.5);
    EXPECT_GT(cell.at("speed").get<double>(), 0);
    EXPECT_EQ(cell.at("status"), "valid");
  }
  EXPECT_EQ(cells, 2U);
  // Started again it measures nothing anew: a driver that cannot is not asked.
  EXPECT_EQ(run("relief_sweep.mjs", "false sweep --tiny").status, 0);
  EXPECT_EQ(run("relief_sweep.mjs", driver_ + " sweep --axis nothing=1").status, 2);
}

// ---- the bundle, and what it does on a machine with a GPU

TEST_F(ScriptsGl, Bundle) {
  NEEDS(Need{"patchelf", "patchelf"}, Need{"cc", "gcc"}, Need{"readelf", "binutils"});
  const Outcome made = run("bundle.sh", "--with-tests " + build_ + " bundle.tar.gz");
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_TRUE(made.text.ends_with("/bundle.tar.gz\n")) << made.text;
  EXPECT_EQ(run("bundle.sh", folder_.path().string() + " nothing.tar.gz").status, 2) << "no driver there";
  EXPECT_FALSE(fs::exists(folder_ / "nothing.tar.gz"));

  // A rehearsal of `./run gpu-check` on software OpenGL.
  ASSERT_EQ(
      support::run_shell("cd " + quoted(folder_.path()) + " && tar -xzf bundle.tar.gz && mv crowdbench-* unpacked")
          .status,
      0);
  const std::string walker = quoted(kTop / "tests/data/assimp/walker.fbx");
  const Outcome inspected =
      support::run_shell("env -i " + quoted(folder_ / "unpacked/crowdbench") + " inspect " + walker + " 2>&1");
  EXPECT_EQ(inspected.status, 0) << inspected.text;
  const auto check = [&](const std::string& arguments) {
    return support::run_shell("cd " + quoted(folder_.path()) + " && CROWDBENCH_DEVICE= unpacked/gpu_check " +
                              arguments + " 2>&1");
  };
  const Outcome rehearsed = check("results --device software --tiny");
  EXPECT_EQ(rehearsed.status, 0) << rehearsed.text;
  const std::string summary = text("results/summary.txt");
  for (const char* step : {"device", "pictures", "bench", "report", "figures"})
    EXPECT_TRUE(std::regex_search(summary, std::regex(std::string(step) + " +[0-9]+ s  fine"))) << step << "\n"
                                                                                                << summary;
  EXPECT_NE(text("results/device.txt").find("drawing on "), std::string::npos);
  const std::string pictures = text("results/pictures.txt");
  EXPECT_NE(pictures.find("[  PASSED  ]"), std::string::npos) << pictures;
  EXPECT_NE(pictures.find("mesh: 0.000 % of "), std::string::npos) << pictures;
  EXPECT_NE(pictures.find("OK ] Registered/ContractGl."), std::string::npos) << "the contract's tests are among them";
  EXPECT_EQ(read_file(folder_ / "results/pictures/mesh.png"), read_file(kTop / "tests/data/golden/mesh.png"));
  expect_tables(text("results/figures.md"), 4);
  EXPECT_NE(text("results/bench.txt").find("mesh"), std::string::npos);
  EXPECT_EQ(text("results/bench.sqlite").substr(0, 13), "SQLite format");
  EXPECT_NE(text("results/report.html").find("</html>"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "results/cache"));
  // Nothing of an earlier check is written over, and a software rasteriser is no GPU.
  EXPECT_EQ(check("results --device software --tiny").status, 2);
  const Outcome software = check("full --device software");
  EXPECT_EQ(software.status, 2);
  EXPECT_NE(software.text.find("is a software rasteriser"), std::string::npos) << software.text;
  // What another driver draws otherwise is found, and kept: a golden picture that is not what is drawn.
  fs::copy_file(kTop / "tests/data/golden/rigid.png", folder_ / "unpacked/tests/data/golden/mesh.png",
                fs::copy_options::overwrite_existing);
  const Outcome differs = check("differs --device software --tiny");
  EXPECT_EQ(differs.status, 1) << differs.text;
  EXPECT_NE(text("differs/summary.txt").find("status 1"), std::string::npos);
  EXPECT_FALSE(fs::is_empty(folder_ / "differs/pictures"));

  const std::string own = ::getuid() == 0 ? "" : "--map-root-user ";
  if (support::run_shell("unshare --mount " + own + "chroot / true 2>/dev/null").status != 0)
    GTEST_SKIP() << "check_bundle.sh needs user namespaces or root; the rest is run";
  const Outcome checked = run("check_bundle.sh", "bundle.tar.gz");
  EXPECT_EQ(checked.status, 0) << checked.text;
  EXPECT_NE(checked.text.find("check_bundle: fine"), std::string::npos) << checked.text;
  // One library short it is found out.
  ASSERT_EQ(support::run_shell("cd " + quoted(folder_.path()) +
                               " && rm unpacked/lib/libfmt* && mkdir short && mv unpacked short/crowdbench-short && "
                               "tar -C short -czf short.tar.gz crowdbench-short")
                .status,
            0);
  EXPECT_NE(run("check_bundle.sh", "short.tar.gz").status, 0);
}

// ---- checks

TEST_F(Scripts, FormatCheck) {
  NEEDS(Need{"clang-format", "clang-format"});
  write_file(folder_ / "fine.h", "#pragma once\nint f(int a);\n");
  write_file(folder_ / "wrong.h", "#pragma once\nint  f( int a ) ;\n");
  EXPECT_EQ(run("check_format.sh", "fine.h").status, 0);
  const Outcome found = run("check_format.sh", "fine.h wrong.h");
  EXPECT_NE(found.status, 0);
  EXPECT_NE(found.text.find("wrong.h:2"), std::string::npos) << found.text;
  EXPECT_EQ(run("check_format.sh", "--fix wrong.h").status, 0);
  EXPECT_EQ(text("wrong.h"), text("fine.h"));
}

TEST_F(Scripts, HeaderCheck) {
  const std::string fine = quoted(kTop / "core/random.h");
  const Outcome passed = run("check_headers.sh", build_ + " " + fine);
  EXPECT_EQ(passed.status, 0) << passed.text;
  write_file(folder_ / "wrong.h", "#pragma once\nRow f();\n");
  const Outcome found = run("check_headers.sh", build_ + " wrong.h " + fine);
  EXPECT_NE(found.status, 0);
  EXPECT_NE(found.text.find("wrong.h does not compile alone"), std::string::npos) << found.text;
  EXPECT_EQ(run("check_headers.sh", "nowhere").status, 2);
}

// Over all variants that are drawn it is run by `./run check`; ShaderVariantsGl is that test.
TEST_F(Scripts, ShaderCheck) {
  NEEDS(Need{"glslangValidator", "glslang-tools"});
  write_file(folder_ / "fine.frag", "#version 450 core\nout vec4 c;\nvoid main() { c = vec4(1); }\n");
  write_file(folder_ / "wrong.frag", "#version 450 core\nout vec4 c;\nvoid main() { c = vec4(undeclared); }\n");
  const Outcome passed = run("check_shaders.sh", build_ + " fine.frag");
  EXPECT_EQ(passed.status, 0) << passed.text;
  const Outcome found = run("check_shaders.sh", build_ + " fine.frag wrong.frag");
  EXPECT_NE(found.status, 0);
  EXPECT_NE(found.text.find("undeclared"), std::string::npos) << found.text;
}

TEST_F(Scripts, TidyCheck) {
  NEEDS(Need{"clang-tidy", "clang-tidy"});
  const Outcome passed = run("check_tidy.sh", build_ + " 1 " + quoted(kTop / "core/command_line.cpp"));
  EXPECT_EQ(passed.status, 0) << passed.text;
  write_file(folder_ / "wrong.cpp", "int f(int a) {\n  if (a == 1) return 2; else return 2;\n}\n");
  const Outcome found = run("check_tidy.sh", build_ + " 1 " + quoted(folder_ / "wrong.cpp"));
  EXPECT_NE(found.status, 0);
  EXPECT_NE(found.text.find("bugprone-branch-clone"), std::string::npos) << found.text;
}

}  // namespace
}  // namespace crowdbench
