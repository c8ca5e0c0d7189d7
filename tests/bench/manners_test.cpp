// The driver as a new user meets it, from outside: it stops when told to, says what it does and for how long, names
// what was wrong and what would be right, calls one thing by one name, and never says that what was not written was.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "core/files.h"
#include "core/image_io.h"
#include "tests/support/driver.h"
#include "tests/support/driver_help.h"
#include "tests/support/running_driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using support::Outcome;
using support::RunningDriver;

constexpr double kAnswerSeconds = 3;  // to Ctrl-C and SIGTERM

size_t lines_of(const std::string& text) { return static_cast<size_t>(std::count(text.begin(), text.end(), '\n')); }

class Manners : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    fs::create_directories(work_);
    ::setenv("CROWDBENCH_CACHE_DIR", (folder_ / "cache").c_str(), 1);
  }
  void TearDown() override { ::unsetenv("CROWDBENCH_CACHE_DIR"); }
  // In a folder of the test's own.
  Outcome run(const std::string& arguments, bool with_stderr = true) const {
    return support::run_driver("cd '" + work_.string() + "';", arguments, with_stderr);
  }
  support::ScratchFolder folder_;
  fs::path work_ = folder_ / "work";
};
using MannersGl = Manners;

// ---- stopping

struct Long {
  const char* name;
  std::vector<std::string> arguments;
  int signal_number;
};

class StopsGl : public Manners, public ::testing::WithParamInterface<Long> {};

TEST_P(StopsGl, WithinThreeSecondsAndLeavesNothingHalfWritten) {
  const Long& work = GetParam();
  write_file(work_ / "million.toml", "[crowd]\nagents = 1000000\nplacement = \"poisson\"\n");
  RunningDriver driver(work.arguments, work_, folder_.path());
  ASSERT_TRUE(driver.wait_until_it_says("drawing on", 60)) << driver.said();
  driver.wait_for_end(1);  // it is well under way then
  if (driver.status() >= 0) GTEST_SKIP() << "this device is done with it in a second";
  driver.send(work.signal_number);
  const double seconds = driver.wait_for_end(60);
  EXPECT_LE(seconds, kAnswerSeconds);
  // Done within that time is an answer, too.
  if (driver.status() == 0) GTEST_SKIP() << "it was about to end when it was told to";
  EXPECT_EQ(driver.status(), 128 + work.signal_number);
  const std::string said = driver.said();
  EXPECT_NE(said.find("crowdbench: interrupted; "), std::string::npos) << said;
  for (const auto& entry : fs::directory_iterator(work_)) {
    const std::string name = entry.path().filename().string();
    // Told to stop after the last write, it leaves what it wrote, whole.
    if (name == "x.png")
      EXPECT_NO_THROW(read_image(entry.path()));
    else
      EXPECT_TRUE(name == "million.toml" || name.starts_with("results.sqlite")) << name;
  }
  if (fs::exists(folder_ / "cache")) {
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
      EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Commands, StopsGl,
    ::testing::Values(
        Long{"ManyMeshes", {"render", "--agents", "200000", "--out", "x.png"}, SIGTERM},
        Long{"ManyImpostors",
             {"render", "--agents", "200000", "--size", "1700x1700", "--out", "x.png", "--supersample", "3",
              "--representation", "flat:views=sphere-4x1,texels=32,frames=1"},
             SIGINT},
        Long{"Placement", {"render", "million.toml", "--out", "x.png"}, SIGTERM},
        Long{"Solving", {"render", "--agents", "100000", "--occupancy", "0.3", "--out", "x.png"}, SIGINT},
        Long{"Bake", {"bench", "--representation", "relief", "--agents", "1", "--out", "results.sqlite"}, SIGTERM},
        Long{"Bench", {"bench", "--representation", "mesh", "--agents", "20000", "--full"}, SIGINT},
        Long{"Ratio", {"ratio", "--of", "mesh", "--to", "mesh", "--agents", "20000"}, SIGTERM},
        Long{"Popping",
             {"popping", "--agents", "20000", "--representation", "hybrid(mesh,mesh,distance=9)", "--frames", "1000"},
             SIGINT},
        Long{"Pair", {"pair", "--a", "mesh", "--b", "mesh", "--agents", "3000", "--out", "x.mp4"}, SIGTERM}),
    [](const auto& command) { return std::string(command.param.name); });

TEST_F(MannersGl, StudyExportStopsAndSaysWhereItGoesOn) {
  write_file(work_ / "study.toml",
             "[scenario]\ncrowd.agents = 50\n[conditions]\ntest = \"mesh:triangles=500\"\n[stimulus]\n"
             "seconds = 30\nlargest_px = 480\n");
  ASSERT_EQ(run("study freeze study.toml").status, 0);
  RunningDriver driver({"study", "export", "study.toml", "out"}, work_, folder_.path());
  ASSERT_TRUE(driver.wait_until_it_says("drawing on", 60)) << driver.said();
  driver.wait_for_end(1);
  ASSERT_LT(driver.status(), 0) << driver.said();
  driver.send(SIGINT);
  EXPECT_LE(driver.wait_for_end(60), kAnswerSeconds);
  EXPECT_EQ(driver.status(), 128 + SIGINT);
  EXPECT_NE(driver.said().find("the same command goes on there"), std::string::npos) << driver.said();
  for (const auto& entry : fs::recursive_directory_iterator(work_ / "out"))
    EXPECT_FALSE(entry.is_regular_file()) << entry.path();
}

// Rays ask for no device, so that it has not to be waited for.
TEST_F(Manners, TruthStops) {
  CROWDBENCH_SKIP_SANITIZED("StopsGl");
  RunningDriver driver(
      {"render", "--truth", "--agents", "2000", "--size", "1600x1200", "--supersample", "9", "--out", "x.png"}, work_,
      folder_.path());
  driver.wait_for_end(1);
  ASSERT_LT(driver.status(), 0) << driver.said();
  driver.send(SIGINT);
  EXPECT_LE(driver.wait_for_end(60), kAnswerSeconds);
  EXPECT_EQ(driver.status(), 128 + SIGINT);
  EXPECT_NE(driver.said().find("crowdbench: interrupted; "), std::string::npos) << driver.said();
  EXPECT_EQ(driver.said().find("drawing on"), std::string::npos) << "a device was opened";
  EXPECT_FALSE(fs::exists(work_ / "x.png"));
}

// Frames of one folder that is compared with itself: two hundred names of one picture of noise.
TEST_F(Manners, CompareStopsBetweenFrames) {
  CROWDBENCH_SKIP_SANITIZED("Compare");
  Image8 noise(1920, 1080, 3);
  for (size_t i = 0; i < noise.data.size(); ++i) noise.data[i] = static_cast<uint8_t>(i * i >> 7U);
  fs::create_directories(work_ / "frames");
  write_png(work_ / "frames" / "0.png", noise);
  for (int t = 1; t < 200; ++t)
    fs::create_hard_link(work_ / "frames" / "0.png", work_ / "frames" / fmt::format("{}.png", t));
  RunningDriver driver({"compare", "frames", "frames", "--chart", "chart.html"}, work_, folder_.path());
  driver.wait_for_end(1);
  ASSERT_LT(driver.status(), 0) << driver.said();
  driver.send(SIGINT);
  EXPECT_LE(driver.wait_for_end(60), kAnswerSeconds);
  EXPECT_EQ(driver.status(), 128 + SIGINT);
  EXPECT_NE(driver.said().find("crowdbench: interrupted; "), std::string::npos) << driver.said();
  EXPECT_FALSE(fs::exists(work_ / "chart.html"));
}

// ---- stdout

TEST_F(MannersGl, OutputThatCannotBeWrittenIsStatusTwoInEveryCommand) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "/dev/full is not there";
  ASSERT_EQ(run("render --agents 2 --size 48x48 --out a.png").status, 0);
  ASSERT_EQ(run("bench --representation mesh --agents 2 --occupancy 0 --size 32x32 --rounds 10 --time-limit 0.1 --out "
                "r.sqlite")
                .status,
            0);
  const std::string flat = "--representation flat:views=sphere-4x1,texels=32,frames=1";
  const std::string small = " --character mannequin:triangles=500";
  // Its picture may fail the check (status 1): what is wanted are ratios to the mesh.
  run("bench " + flat + small + " --agents 2 --occupancy 0 --size 32x32 --rounds 10 --time-limit 0.1 --out f.sqlite");
  ASSERT_TRUE(fs::exists(work_ / "f.sqlite"));
  ASSERT_EQ(run("quality --representation mesh --height-px 20,24 --rows 48 --db q.sqlite" + small).status, 0);
  write_file(work_ / "answers.csv", "answer\nyes\nno\n");
  fs::create_directories(work_ / "served/page");
  write_file(work_ / "served/page/index.html", "");
  write_file(work_ / "served/page/trials.json",
             R"({"format": 1, "study": "abc", "task": "forced-choice", "stimuli": {"s1": {}},
                 "answers": [{"value": "upper"}, {"value": "lower"}], "lists": [{"id": "1",
                 "trials": [{"trial": "t1", "stimulus": "s1", "block": 1, "kind": "main"}]}]})");
  write_file(work_ / "saved.json", R"([{"study": "abc", "participant": "p", "item": "consent", "kind": "page"}])");
  write_file(work_ / "study.toml", "[conditions]\ntest = \"mesh:triangles=60\"\n");
  write_file(work_ / "s.toml", "[scenario]\nwidth = 32\nheight = 32\n[axes]\ncrowd.agents = [2]\n");
  ASSERT_EQ(run("sweep s.toml").status, 0);
  const std::multimap<std::string, std::string> prints = {
      {"info", ""},
      {"info", "--json"},
      {"info", "--representations"},
      {"inspect", "mannequin:triangles=500 --json"},
      {"render", "--agents 2 --size 48x48 --out b.png"},
      {"bake", "--representation mesh --json" + small},
      {"cache", "list"},
      {"cache", "list --json"},
      {"pose", "mannequin:triangles=500 --json"},
      {"compare", "a.png a.png --json"},
      {"compare", "a.png a.png"},
      {"quality", "--representation mesh --height-px 20 --rows 48 --json" + small},
      {"switch-distance", flat + " --ratio 1 --size 64x64 --json" + small},
      {"popmap", flat + " --azimuth-deg 0 --elevation-deg 0 --phase 0 --ratio 1 --json" + small},
      {"popping", "--representation 'hybrid(mesh,mesh)' --agents 2 --size 32x32 --frames 2 --json" + small},
      {"distance", "--representation mesh --scores mae --agents 2 --size 32x32 --json" + small},
      {"tune",
       "--representation mesh:triangles=100 --agents 2 --size 32x32 --heights 2 --moments 1 --azimuth-deg 0 "
       "--elevation-deg 0 --rounds 4 --threshold mae=255 --json" +
           small},
      {"stability", "--small --representation mesh --case time_wrap --json"},
      {"ratio", "--of mesh --to mesh --agents 2 --size 32x32 --pairs 20 --json" + small},
      {"bench", "--representation mesh --agents 2 --occupancy 0 --size 32x32 --out r.sqlite"},
      {"bench", "--representation mesh --agents 2 --occupancy 0 --size 32x32 --out r.sqlite --json"},
      {"sweep", "s.toml --dry-run"},
      {"sweep", "s.toml --out s.sqlite"},
      {"sweep", "s.toml --out s.sqlite --json"},
      {"merge", "m.sqlite s.sqlite"},
      {"merge", "m.sqlite s.sqlite --json"},
      {"pair", "--a mesh --b mesh --agents 2 --size 48x48 --frames 2 --out c.mp4"},
      {"correlate", "q.sqlite"},
      {"correlate", "q.sqlite --json"},
      {"regress", "r.sqlite r.sqlite"},
      {"regress", "r.sqlite r.sqlite --json"},
      {"history", "f.sqlite f.sqlite"},
      {"history", "f.sqlite f.sqlite --json"},
      {"model", "r.sqlite"},
      {"model", "r.sqlite --json"},
      {"export", "r.sqlite --csv r.csv"},
      {"study freeze", "study.toml"},
      {"study export", "study.toml --dry-run"},
      {"study serve", "served --port 0"},
      {"study answers", "saved.json --study served"},
      {"study answers", "saved.json --study served --json"},
      {"study analyze", "answers.csv"},
      {"study analyze", "answers.csv --json"},
      {"study simulate", "--levels 1 --out simulated.csv"},
      {"study power", "--participants 2 --simulations 2 --json"},
      {"report", "r.sqlite --csv r.csv"},
      {"demo", "--tiny --no-clip " + flat + small},
      {"schema", ""},
      {"schema", "--results"},
  };
  for (const std::string& command : support::driver_commands()) {
    if (command == "view") continue;  // its answer is the window
    const auto [from, to] = prints.equal_range(command);
    EXPECT_NE(from, to) << command << " is not tried here";
    // CommandsGl runs the others where sanitizers watch.
    if (support::kSanitized && command != "info" && command != "schema" && command != "compare") continue;
    for (auto it = from; it != to; ++it) {
      SCOPED_TRACE(command + " " + it->second);
      const Outcome outcome = run(command + " " + it->second + " 2>err.txt >/dev/full; exit $?; true", false);
      EXPECT_EQ(outcome.status, 2);
      EXPECT_NE(read_text(work_ / "err.txt").find("standard output: cannot be written"), std::string::npos)
          << read_text(work_ / "err.txt");
    }
  }
  for (const char* told : {"--help", "--version", "render --help", "schema"}) {
    const Outcome outcome = run(std::string(told) + " 2>&1 >/dev/full; exit $?; true", false);
    EXPECT_EQ(outcome.status, 2) << told;
    EXPECT_EQ(outcome.text,
              "crowdbench: standard output: cannot be written: No space left on device; free some space or choose "
              "another place\n")
        << told;
  }
}

// ---- what was wrong

TEST_F(Manners, WhatIsWrongIsSaidWithItsValueItsRangeAndTheNearestName) {
  write_file(work_ / "wrong.toml", "seed = 4\n\nrepresentation = \"flax\"\n");
  write_file(work_ / "gone.toml", "[[character]]\nsource = \"mannequin\"\nanimations = [\"gone.glb\"]\n");
  write_file(work_ / "clip.toml",
             "[[character]]\nclips = [\"walk\"]\n\n[[character]]\nsource = \"mannequin\"\nclips = [\"wlak\"]\n");
  const struct {
    const char* arguments;
    const char* says;
  } wrong[] = {
      {"", "a command is missing; there are info, "},
      {"rendr", "'rendr' is not a command; did you mean 'render'?"},
      {"rendr --agents 5", "did you mean 'render'?"},
      {"frobnicate", "'frobnicate' is not a command; there are info, "},
      {"--agents 5 render", "--agents belongs behind the command: crowdbench render --agents"},
      {"render --agentz 5", "render has no option '--agentz'; did you mean --agents?"},
      {"render --frobnicate", "render has no option '--frobnicate'; see crowdbench render --help"},
      {"render a.toml b.toml", "'b.toml' is one argument too many for render"},
      {"render --agents", "--agents: its value is missing"},
      {"render --seed 1 --seed 2", "--seed: is given more than once"},
      {"info --json=5", "--json: takes no value"},
      {"render --agents -1", "--agents: '-1' is not a whole number from 0 to 1000000"},
      {"render --agents 5x", "--agents: '5x' is not a whole number from 0 to 1000000"},
      {"bench --agents 1,,3", "--agents: '1,,3' leaves a value out; see crowdbench bench --help"},
      {"bench --occupancy=0.5,", "--occupancy: '0.5,' leaves a value out"},
      {"bench --agents 10,0", "--agents: '0' is not a whole number from 1 to 1000000"},
      {"render --seed -5", "--seed: '-5' is not a whole number from 0 to 18446744073709551615"},
      {"bench --seed -5", "--seed: '-5' is not a whole number from 0 to 18446744073709551615"},
      {"render --seed 18446744073709551616", "is not a whole number from 0 to 18446744073709551615"},
      {"render --occupancy nan", "--occupancy: 'nan' is not a number from 0.0001 to 1"},
      {"render --tick -1", "--tick: '-1' is not a whole number"},
      {"pair --a mesh --b flat --out x.mp4 --crf 99", "--crf: '99' is not a whole number from 0 to 51"},
      {"ratio --of mesh --to mesh --pairs 3", "--pairs: '3' is not a whole number from 20 to"},
      {"stability --case wrold", "--case: 'wrold' is neither a case nor a group of cases; did you mean 'world'?"},
      {"regress a.sqlite", "two result files are needed"},
      {"regress / /", "/: holds no result file; give a file of `bench`, or a folder of such files"},
      {"regress a.sqlite b.sqlite --run-scatter -1", "--run-scatter: '-1' is not a number from 0 to 1000"},
      {"regress --program x", "--program: is given 1 times; give it twice"},
      {"regress a.sqlite b.sqlite --runs 7", "--runs requires --program; see crowdbench regress --help"},
      {"regress a.sqlite b.sqlite --bench plaza.toml", "--bench requires --program"},
      {"regress a.sqlite b.sqlite --pictures why", "--pictures requires --explain"},
      {"regress a.sqlite b.sqlite --correction bonferroni", "--correction: 'bonferroni' is not a correction"},
      {"regress a.sqlite b.sqlite --detect 0.5", "--detect: 0.5 % is not more than the least effect of 1 %"},
      {"regress a.sqlite b.sqlite --tolerance simm=1", "did you mean 'ssim'?"},
      {"export r.sqlite", "nothing to write"},
      {"report a.sqlite b.sqlite --csv x.csv", "these forms have no place for a file's name"},
      {"popmap --fade 0", "--fade: '0' is not a whole number from 1 to 60"},
      {"pose mannequin --vertex -1", "--vertex: '-1' is not a whole number"},
      {"quality --representation mesh --reference meshes",
       "--reference: 'meshes' is not a reference; use mesh or truth"},
      {"quality --representation mesh --reference truth --causes", "--causes: causes are told apart by what is drawn"},
      {"render --truth --representation mesh --out x.png", "--representation"},
      {"quality", "--representation is required"},
      {"quality --representation flax", "--representation: there is no representation 'flax'; did you mean 'flat'?"},
      {"ratio --of flax --to mesh", "--of: there is no representation 'flax'"},
      {"pair --a mesh --b flax --out x.mp4", "--b: there is no representation 'flax'"},
      {"render wrong.toml --out x.png", "wrong.toml:3: `representation`: there is no representation 'flax'"},
      {"bench wrong.toml", "wrong.toml:3: `representation`: there is no representation 'flax'"},
      {"view wrong.toml", "wrong.toml:3: `representation`: there is no representation 'flax'"},
      {"render clip.toml --out x.png", "clip.toml:6: there is no clip 'wlak' of mannequin"},
      {"render gone.toml --out x.png", "gone.toml:3: gone.glb: cannot open"},
      {"render clip.toml --out x.png --clip wlak", "--clip: there is no clip 'wlak' of mannequin"},
      {"pose mannequin --clip runing", "there is no clip 'runing'; did you mean run? It has walk, run, idle, wave"},
      {"pose mannequin --clip 99", "there is no clip '99'; give a name or an index from 0 to 3; it has walk, run"},
      {"render --out x.png --animations mannequin --bones foo", "--bones: 'foo' is not a pair of nodes"},
      {"render --out x.png --bones a=b", "--bones: nothing plays: no other file's clips are used"},
      {"bench --display standard_fdh", "'standard_fdh' is not a display; did you mean standard_fhd?"},
      {"render --representation relief:rule=foo --out x.png", "'foo' is not one of dominant, any, threshold[W]"},
      {"view --frames 2 --screenshot x.gif", "--screenshot: 'x.gif' ends in .gif; what is written is FILE.png"},
      {"export r.sqlite --csv c.xlsx", "--csv: 'c.xlsx' ends in .xlsx; what is written is FILE.csv"},
      {"report r.sqlite --json-out r.TXT", "--json-out: 'r.TXT' ends in .txt; what is written is FILE.json"},
      {"pose mannequin --clip wlak", "there is no clip 'wlak'; did you mean walk? It has walk, run, idle, wave"},
  };
  for (const auto& w : wrong) {
    SCOPED_TRACE(w.arguments);
    const Outcome outcome = run(w.arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_EQ(lines_of(outcome.text), 1U) << outcome.text;
    EXPECT_NE(outcome.text.find(w.says), std::string::npos) << outcome.text;
  }
  // What stands in the file is not to blame where an option overrides it.
  const Outcome overridden = run("render wrong.toml --out x.png --representation flay");
  EXPECT_NE(overridden.text.find("--representation: there is no representation 'flay'"), std::string::npos)
      << overridden.text;
}

// What an option's value can be is known without a character; what the character lacks, when it is there.
class WrongRepresentationGl : public MannersGl, public testing::WithParamInterface<const char*> {};

TEST_P(WrongRepresentationGl, OfAFileIsToldByItsLine) {
  write_file(work_ / "s.toml", std::string("seed = 4\n\nrepresentation = \"") + GetParam() + "\"\n");
  const Outcome outcome = run("render s.toml --agents 2 --size 32x32 --out x.png");
  EXPECT_EQ(outcome.status, 2) << outcome.text;
  const size_t last = outcome.text.rfind("crowdbench: ");
  ASSERT_NE(last, std::string::npos) << outcome.text;
  EXPECT_TRUE(outcome.text.substr(last).starts_with("crowdbench: s.toml:3: `representation`: representation '"))
      << outcome.text;
}

INSTANTIATE_TEST_SUITE_P(ByValue, WrongRepresentationGl,
                         testing::Values("mesh:lods=abc", "mesh:lods=1.5", "mesh:lods=2000/abc", "mesh:lods=0.5/0.9",
                                         "relief:resolution=head", "relief:steps=banana", "relief:rule=foo",
                                         "relief:capture=walk@2"));
INSTANTIATE_TEST_SUITE_P(ByCharacter, WrongRepresentationGl,
                         testing::Values("mesh:lods=own", "mesh:lod=7", "relief:resolution=heady@64",
                                         "relief:capture=walkk", "polypostor:parts=Foo"));

// No command makes a folder for a file, and all say so before anything is drawn.
TEST_F(Manners, OutputsNeedAFolderThatIsThere) {
  write_file(work_ / "r.sqlite", "");
  const char* const outputs[] = {
      "render --out a/b/x.png",
      "render --mask a/b/x.png",
      "render --ids a/b/x.exr",
      "render --depth a/b/x.exr",
      "inspect mannequin --out a/b/m.glb",
      "bench --out a/b/r.sqlite",
      "sweep s.toml --out a/b/r.sqlite",
      "sweep s.toml --markdown a/b/r.md",
      "merge a/b/r.sqlite r.sqlite",
      "pair --a mesh --b mesh --out a/b/c.mp4",
      "view --frames 1 --screenshot a/b/x.png",
      "regress r.sqlite r.sqlite --markdown a/b/r.md",
      "regress r.sqlite r.sqlite --junit a/b/r.xml",
      "regress r.sqlite r.sqlite --explain 1 --pictures a/b/pictures",
      "history r.sqlite --chart a/b/h.html",
      "export r.sqlite --csv a/b/r.csv",
      "export r.sqlite --bencher a/b/r.json",
      "export r.sqlite --frame-log a/b/r.csv",
      "report r.sqlite --out a/b/r.html",
      "report r.sqlite --markdown a/b/r.md",
      "report r.sqlite --csv a/b/r.csv",
      "report r.sqlite --scores-csv a/b/r.csv",
      "report r.sqlite --json-out a/b/r.json",
      "report r.sqlite --google-benchmark a/b/r.json",
      "demo --out a/b/demo",
      "popmap --out a/b/pops",
      "popping --representation 'hybrid(mesh,mesh)' --out a/b/pops",
      "distance --representation mesh --out a/b/agents.csv",
      "distance --representation mesh --chart a/b/page.html",
      "distance --representation mesh --db a/b/r.sqlite",
      "tune --page a/b/page.html",
      "tune --db a/b/r.sqlite",
      "quality --representation mesh --db a/b/r.sqlite",
      "correlate r.sqlite --markdown a/b/r.md",
      "study serve served --answers a/b/answers.sqlite",
      "study answers saved.json --study served --csv a/b/answers.csv",
      "study answers saved.json --study served --json-lines a/b/answers.jsonl",
      "study answers saved.json --study served --jspsych a/b/answers.json",
      "study analyze answers.csv --markdown a/b/r.md",
      "study export study.toml a/b/out",
      "study analyze answers.csv --page a/b/r.html",
      "study analyze answers.csv --out a/b/r",
      "study analyze answers.csv --export a/b/r",
      "study simulate --levels 1 --out a/b/simulated.csv",
      "correlate r.sqlite --pictures a/b/pictures",
      "quality --representation mesh --maps a/b/maps",
      "compare x.png y.png --maps a/b/maps",
  };
  for (const char* arguments : outputs) {
    SCOPED_TRACE(arguments);
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_EQ(lines_of(outcome.text), 1U) << outcome.text;
    EXPECT_NE(outcome.text.find("there is no folder 'a/b'; make it first (mkdir -p 'a/b')"), std::string::npos)
        << outcome.text;
  }
  EXPECT_FALSE(fs::exists(work_ / "a"));
  for (const char* arguments : {"render --out /dev/null", "render --out ''", "render --out ."}) {
    SCOPED_TRACE(arguments);
    EXPECT_EQ(run(arguments).status, 2);
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

// ---- one name

TEST_F(Manners, OneThingHasOneNameAndOneWordingInAllCommands) {
  std::map<std::string, std::map<std::string, std::set<std::string>>> texts;  // option, wording, commands
  std::map<std::string, std::map<std::string, support::OptionHelp>> by_command;
  for (const std::string& command : support::driver_commands()) {
    by_command[command] = support::driver_help(command).options;
    for (const auto& [name, option] : by_command[command]) texts[name][option.text].insert(command);
  }
  ASSERT_GE(by_command.size(), 16U);
  for (const char* shared : {"device", "size", "bake-budget", "no-cache", "samples", "supersample", "no-ground"}) {
    EXPECT_EQ(texts[shared].size(), 1U) << shared;
    for (const auto& [text, commands] : texts[shared]) EXPECT_GE(commands.size(), 2U) << shared << ": " << text;
  }
  EXPECT_EQ(texts["seed"].size(), 2U) << "of the crowd, and of simulated observers";
  // What draws one representation, or several, says so with the same option; pairs name their two sides.
  for (const char* command :
       {"render", "bake", "quality", "switch-distance", "popmap", "popping", "distance", "bench", "view", "demo"})
    EXPECT_TRUE(by_command[command].count("representation")) << command;
  for (const auto& [command, options] : by_command) {
    if (options.count("representations")) {
      EXPECT_EQ(command, "info") << "there it is a question, not a choice";
    }
    for (const char* other : {"save", "output", "backend", "renderer", "gpu", "char", "resolution"})
      EXPECT_FALSE(options.count(other)) << command << " --" << other;
  }
  // Everything that takes a character, takes it so; it is an argument only where it is what the command is about.
  for (const char* command : {"render", "bake", "quality", "switch-distance", "popmap", "popping", "distance", "ratio",
                              "bench", "pair", "view", "demo"})
    EXPECT_TRUE(by_command[command].count("character")) << command;
  for (const auto& [command, options] : by_command)
    if (command != "schema" && command != "inspect" && command != "pose" && command != "report" &&
        command != "regress" && command != "history" && command != "export" && command != "correlate" &&
        command != "model" && command != "compare" && command != "cache" && command != "merge" &&
        !command.starts_with("study ")) {
      EXPECT_TRUE(options.count("device")) << command;
    }
}

TEST_F(Manners, WhatIsReadIsNotWrittenOver) {
  write_file(work_ / "answers.md", "answer\nyes\nno\n");
  for (const char* line : {"study analyze --table answers.md --markdown answers.md",
                           "study analyze --table answers.md --markdown ./answers.md",
                           "export answers.md --csv new.csv --scores-csv ./new.csv"}) {
    const Outcome outcome = run(line);
    EXPECT_EQ(outcome.status, 2) << line;
    EXPECT_NE(outcome.text.find("is also what"), std::string::npos) << outcome.text;
  }
  // A name that ends as another format's files do is a mistake.
  const Outcome other = run("render --agents 1 --size 32x32 --out picture.jpg");
  EXPECT_EQ(other.status, 2) << other.text;
  EXPECT_NE(other.text.find("'picture.jpg' ends in .jpg; what is written is FILE.png"), std::string::npos)
      << other.text;
  EXPECT_EQ(read_text(work_ / "answers.md"), "answer\nyes\nno\n");
  EXPECT_FALSE(fs::exists(work_ / "new.csv"));
}

// ---- what was done

TEST_F(MannersGl, RenderEndsWithWhatItDrew) {
  const Outcome levels =
      run("render --agents 2 --size 60x40 --out l.png --character mannequin:triangles=500 --representation "
          "mesh:lods=300/200",
          false);
  const size_t last = levels.text.rfind('\n', levels.text.size() - 2);
  ASSERT_NE(last, std::string::npos) << levels.text;
  EXPECT_NE(levels.text.rfind("level of ", last), std::string::npos) << levels.text;
  EXPECT_EQ(levels.text.find("level of ", last), std::string::npos) << levels.text;
  EXPECT_NE(levels.text.find("2 agents (2 in view) as mesh:lods=300/200", last), std::string::npos) << levels.text;
  const Outcome outcome = run("render --agents 7 --size 60x40 --tick 3 --out a.png --ids ids.exr", false);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_TRUE(std::regex_match(outcome.text,
                               std::regex("drew 7 agents \\([0-7] in view\\) as mesh, tick 3, 60x40 pixels: a.png, "
                                          "ids.exr\n")))
      << outcome.text;
}

TEST_F(MannersGl, EqualSidesOfAPairAreSaidToBeEqual) {
  const std::string common = " --agents 3 --size 64x48 --frames 2 --character mannequin:triangles=500 --out ";
  const Outcome equal = run("pair --a mesh --b mesh" + common + "equal.mp4");
  EXPECT_EQ(equal.status, 0) << equal.text;
  EXPECT_NE(equal.text.find("mesh and mesh draw equal pictures"), std::string::npos) << equal.text;
  EXPECT_TRUE(nlohmann::json::parse(read_text(work_ / "equal.json")).at("equal"));
  const Outcome other = run("pair --a mesh --b mesh:floor=1" + common + "other.mp4");
  EXPECT_EQ(other.status, 0) << other.text;
  EXPECT_EQ(other.text.find("equal pictures"), std::string::npos) << other.text;
  EXPECT_FALSE(nlohmann::json::parse(read_text(work_ / "other.json")).at("equal"));
}

TEST_F(MannersGl, BenchForecastsKeepsToItsTimeAndSaysWhatItWrote) {
  const std::string small = " --representation mesh --size 32x32 --character mannequin:triangles=500 --occupancy 0";
  const Outcome first = run("bench --agents 1,2 --rounds 10 --time-limit 0.1" + small);
  EXPECT_EQ(first.status, 0) << first.text;
  EXPECT_NE(first.text.find("bench: 2 points of 1 representation and the mesh, about "), std::string::npos)
      << first.text;
  EXPECT_NE(first.text.find("2 points measured, 0 taken from the file; results.sqlite"), std::string::npos)
      << first.text;
  // Twenty thousand agents do not fit into what is left of three seconds; the points that do not are named. What goes
  // on after them is one solving, or one round, that had begun.
  const auto begun = std::chrono::steady_clock::now();
  const Outcome brief = run("bench --minutes 0.05 --agents 1,20000,40000 --out brief.sqlite" + small);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(), 20);
  EXPECT_EQ(brief.status, 0) << brief.text;
  EXPECT_NE(brief.text.find("40000 agents at the scenario's camera: left for another run of the same command"),
            std::string::npos)
      << brief.text;
}

TEST_F(MannersGl, DemoForecasts) {
  CROWDBENCH_SKIP_SANITIZED("CommandsGl");
  const Outcome outcome =
      run("demo --tiny --no-clip --character mannequin:triangles=500 --representation "
          "flat:views=sphere-8x3,texels=64,frames=8");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("demo: 4 steps, about "), std::string::npos) << outcome.text;
  // Levels of more triangles than the character has are the character.
  const std::string page = read_text(work_ / "crowdbench-demo" / "report.html");
  EXPECT_NE(page.find("triangles=200"), std::string::npos);
  EXPECT_EQ(page.find("triangles=2000"), std::string::npos);
}

// The stored command line is the whole of it.
TEST_F(MannersGl, TheResultFileHoldsTheWholeCommandLine) {
  const std::string line =
      "bench --representation mesh --agents 1 --occupancy 0 --size 32x32 --rounds 10 --time-limit 0.1 --character "
      "mannequin:triangles=500 --out 'my results.sqlite'";
  const Outcome outcome = run(line + " --json", false);
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(nlohmann::json::parse(outcome.text).at("runs").at(0).at("arguments"), "crowdbench " + line + " --json");
}

// ---- fast answers

// What needs no OpenGL loads neither its driver nor what reads and writes pictures and clips.
TEST_F(Manners, FastAnswersLoadNoHeavyLibrary) {
  for (const char* arguments : {"--help", "--version", "render --help", "info --representations", "schema", "rendr",
                                "render --agents -1", "render --out x.png --representation flax"}) {
    SCOPED_TRACE(arguments);
    const Outcome outcome = support::run_driver("LD_DEBUG=libs", arguments);
    EXPECT_NE(outcome.text.find("calling init"), std::string::npos) << "the loader says what it loads";
    for (const char* heavy : {"OpenImageIO", "libEGL", "libGL.so", "avcodec", "libLLVM", "libX11-xcb"})
      EXPECT_EQ(outcome.text.find(heavy), std::string::npos) << heavy;
  }
}

}  // namespace
}  // namespace crowdbench::bench
