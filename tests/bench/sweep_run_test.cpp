// Sweeps as a user runs them: points that fail, a stop in the middle, shards and what they are merged to.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "store/store.h"
#include "tests/support/driver.h"
#include "tests/support/running_driver.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;

using support::Outcome;

constexpr const char* kTiny = R"(
[scenario]
width = 64
height = 48
[[scenario.character]]
source = "mannequin:triangles=500"
[measure]
rounds = 10
time_limit_s = 0.02
scores = ["mae", "psnr"]
[axes]
)";

class SweepsGl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    fs::create_directories(work_);
    write_file(work_ / "p.toml",
               kTiny + std::string("crowd.agents = [1, 2, 3, 4, 5]\nrepresentation = [\"mesh:triangles=250\", "
                                   "\"mesh:triangles=200\"]\n"));
  }
  Outcome run(const std::string& arguments, bool with_stderr = true) const {
    return support::run_driver("cd '" + work_.string() + "' && CROWDBENCH_CACHE_DIR=../cache", arguments, with_stderr);
  }
  void plan(const std::string& name, const std::string& axes) const { write_file(work_ / name, kTiny + axes); }
  StoreContents rows(const std::string& file) const { return read_store(work_ / file, true, true); }

  // Of a file that is being written; none where there is no such file or none of its tables yet.
  size_t runs_of(const std::string& file) const {
    if (!fs::exists(work_ / file)) return 0;
    try {
      return rows(file).runs.size();
    } catch (const Error&) {
      return 0;
    }
  }

  // Everything of a file that does not depend on time, point by point.
  std::string untimed(const std::string& file) const {
    const StoreContents all = rows(file);
    std::map<int64_t, const ComparisonRow*> comparisons;
    for (const ComparisonRow& row : all.comparisons) comparisons[row.id] = &row;
    std::string text;
    for (const SweepPointRow& row : all.sweep_points) {
      text += fmt::format("{} {} {} {} {} {} {} {}", row.condition, row.repetition, row.role, row.point_key,
                          row.representation, row.settings, row.state, row.reason);
      if (row.comparison)
        for (const ScoreRow& score : comparisons.at(*row.comparison)->scores)
          text += fmt::format(" {}={:a}", score.name, score.value.value_or(-1));
      text += "\n";
    }
    return text;
  }

  support::ScratchFolder folder_;
  fs::path work_ = folder_ / "work";
};

TEST_F(SweepsGl, ShardsMergeToTheSameWhateverTheirNumber) {
  ASSERT_EQ(run("sweep p.toml --out one.sqlite").status, 0);
  for (const char* shard : {"2/3", "1/3", "3/3"}) {
    const std::string number(1, shard[0]);
    ASSERT_EQ(run("sweep p.toml --shard " + std::string(shard)).status, 0);
    EXPECT_TRUE(fs::exists(work_ / ("p-" + number + "-of-3.sqlite")));
  }
  const Outcome missing = run("merge m.sqlite p-1-of-3.sqlite p-3-of-3.sqlite");
  EXPECT_EQ(missing.status, 3) << missing.text;
  EXPECT_NE(missing.text.find("of 3 shards are missing: 2"), std::string::npos) << missing.text;
  EXPECT_FALSE(fs::exists(work_ / "m.sqlite"));
  const Outcome merged = run("merge m.sqlite p-3-of-3.sqlite p-1-of-3.sqlite p-2-of-3.sqlite");
  ASSERT_EQ(merged.status, 0) << merged.text;
  EXPECT_EQ(untimed("m.sqlite"), untimed("one.sqlite"));

  const StoreContents all = rows("m.sqlite");
  ASSERT_EQ(all.sweeps.size(), 1U);
  EXPECT_EQ(all.sweeps[0].points, 10U);
  EXPECT_EQ(all.sweeps[0].shards, 1U);
  EXPECT_EQ(all.runs.size(), 5U);
  // Two points, the reference and its twin; of the first three a measurement.
  ASSERT_EQ(all.sweep_points.size(), 20U);
  EXPECT_EQ(all.measurements.size(), 15U);
  EXPECT_EQ(all.measurements[0].samples.size(), static_cast<size_t>(all.measurements[0].rounds));
  EXPECT_EQ(all.sweep_points[2].role, "reference");
  EXPECT_EQ(all.sweep_points[3].role, "aa");
  EXPECT_TRUE(all.sweep_points[3].ratio.has_value());
  EXPECT_EQ(all.comparisons.size(), 10U);

  // The merged file is the whole plan's: its tables are printed, nothing is drawn.
  const Outcome again = run("sweep p.toml --out m.sqlite");
  EXPECT_EQ(again.status, 0);
  EXPECT_NE(again.text.find("holds all of it already"), std::string::npos) << again.text;
  EXPECT_NE(again.text.find("| 5 | mesh:triangles=200 |"), std::string::npos) << again.text;
  EXPECT_EQ(again.text.find("drawing on"), std::string::npos);
}

TEST_F(SweepsGl, WhatDoesNotBelongTogetherIsNotMerged) {
  ASSERT_EQ(run("sweep p.toml --shard 1/5").status, 0);
  plan("q.toml", "crowd.agents = [1, 2]\n");
  ASSERT_EQ(run("sweep q.toml --shard 1/2").status, 0);
  ASSERT_EQ(run("sweep q.toml --shard 2/2").status, 0);
  ASSERT_EQ(run("sweep q.toml --shard 1/1").status, 0);
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Outcome outcome = run("merge m.sqlite " + arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_NE(outcome.text.find(why), std::string::npos) << outcome.text;
    EXPECT_FALSE(fs::exists(work_ / "m.sqlite"));
  };
  refused("q-1-of-2.sqlite p-1-of-5.sqlite", "is of another plan");
  refused("q-1-of-2.sqlite q-1-of-1.sqlite", "merge shards that were cut alike");
  refused("q-1-of-2.sqlite q-1-of-2.sqlite", "name each shard once");
  refused("q.toml", "");
  // Another program's shard.
  StoreContents other = rows("q-2-of-2.sqlite");
  {
    StoreWriter store(work_ / "other.sqlite");
    SweepRow sweep = other.sweeps[0];
    store.write(sweep);
    for (RunRow run_row : other.runs) {
      run_row.revision = "another";
      store.write(run_row);
    }
    for (MeasurementRow& row : other.measurements) store.write(row);
    for (ComparisonRow& row : other.comparisons) store.write(row);
    for (SweepPointRow& row : other.sweep_points) store.write(row);
  }
  refused("q-1-of-2.sqlite other.sqlite", "its program is 'another'");
  EXPECT_EQ(run("merge m.sqlite q-1-of-2.sqlite other.sqlite --mixed").status, 0);
  EXPECT_EQ(rows("m.sqlite").runs.back().revision, "another");
  EXPECT_EQ(run("merge n.sqlite q-1-of-2.sqlite --allow-missing").status, 0);
}

TEST_F(SweepsGl, AFailedPointIsARowAndTheOthersGoOn) {
  plan("f.toml",
       "crowd.agents = [2, 3]\nrepresentation = [\"mesh:triangles=250\", \"flat:views=sphere-90x45,texels=1024\"]\n");
  const Outcome outcome = run("sweep f.toml --out f.sqlite");
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_NE(outcome.text.find("2 points done, 2 failed"), std::string::npos) << outcome.text;
  const StoreContents all = rows("f.sqlite");
  size_t failed = 0;
  for (const SweepPointRow& row : all.sweep_points)
    if (row.state == "failed") {
      ++failed;
      EXPECT_NE(row.reason.find("budget"), std::string::npos) << row.reason;
      EXPECT_FALSE(row.measurement.has_value());
    }
  EXPECT_EQ(failed, 2U);
  EXPECT_EQ(all.measurements.size(), 4U);

  plan("g.toml",
       "occupancy = [0.9]\ncrowd.agents = [1]\n[[axes.who]]\nlabel = \"nobody\"\n[[axes.who.character]]\nsource = "
       "\"nobody.glb\"\n");
  const Outcome none = run("sweep g.toml --out g.sqlite");
  EXPECT_EQ(none.status, 3) << none.text;
  EXPECT_NE(none.text.find("nobody.glb"), std::string::npos) << none.text;
}

// Its points are one condition, timed for minutes.
TEST_F(SweepsGl, SigtermIsAnsweredWithinAConditionOfWhichNothingIsKept) {
  std::string text = kTiny;
  const std::string rounds = "rounds = 10\ntime_limit_s = 0.02\n";
  text.replace(text.find(rounds), rounds.size(), "rounds = 100000\ntime_limit_s = 600\n");
  write_file(work_ / "t.toml", text + "representation = [\"mesh:triangles=250\", \"mesh:triangles=200\"]\n");
  for (const int signal_number : {SIGTERM, SIGINT}) {
    support::RunningDriver driver({"sweep", "t.toml", "--out", "t.sqlite"}, work_, folder_.path());
    ASSERT_TRUE(driver.wait_until_it_says("drawing on", 60)) << driver.said();
    driver.wait_for_end(1.5);
    ASSERT_LT(driver.status(), 0) << driver.said();
    driver.send(signal_number);
    EXPECT_LE(driver.wait_for_end(60), 3);
    EXPECT_EQ(driver.status(), signal_number == SIGTERM ? 75 : 128 + SIGINT) << driver.said();
    EXPECT_NE(driver.said().find("interrupted; "), std::string::npos) << driver.said();
    if (fs::exists(work_ / "t.sqlite.partial")) {
      EXPECT_TRUE(rows("t.sqlite.partial").sweep_points.empty());
    }
    EXPECT_FALSE(fs::exists(work_ / "t.sqlite"));
  }
}

TEST_F(SweepsGl, WhatWasMeasuredBeforeSigtermIsKeptAndTheRestIsMeasuredLater) {
  plan("t.toml", "crowd.agents = [1, 2, 3, 4, 5, 6]\n[points]\nrepetitions = 8\n");
  {
    support::RunningDriver driver({"sweep", "t.toml", "--out", "t.sqlite"}, work_, folder_.path());
    ASSERT_TRUE(driver.wait_until_it_says("drawing on", 60)) << driver.said();
    for (int i = 0; i < 2000 && driver.status() < 0 && runs_of("t.sqlite.partial") == 0; ++i) driver.wait_for_end(0.02);
    driver.send(SIGTERM);
    driver.wait_for_end(60);
    EXPECT_EQ(driver.status(), 75) << driver.said();
  }
  EXPECT_FALSE(fs::exists(work_ / "t.sqlite"));
  const size_t before = rows("t.sqlite.partial").runs.size();
  ASSERT_GT(before, 0U);
  ASSERT_LT(before, 48U);
  EXPECT_EQ(rows("t.sqlite.partial").sweep_points.size(), 2 * before) << "whole conditions: the point, and A/A";
  // What was begun is not measured anew, and not taken for another plan's.
  const std::string text = read_text(work_ / "t.toml");
  write_file(work_ / "u.toml", text.substr(0, text.find("[points]")));
  EXPECT_NE(run("sweep u.toml --out t.sqlite").text.find("holds another plan"), std::string::npos);
  EXPECT_NE(run("sweep t.toml --out t.sqlite --shard 1/2").text.find("holds shard 1/1"), std::string::npos);
  const Outcome dry = run("sweep t.toml --out t.sqlite --dry-run");
  EXPECT_NE(dry.text.find(fmt::format("; {} done already;", before)), std::string::npos) << dry.text;
  const Outcome rest = run("sweep t.toml --out t.sqlite");
  EXPECT_EQ(rest.status, 0) << rest.text;
  EXPECT_NE(rest.text.find(fmt::format("{} taken from the file", before)), std::string::npos) << rest.text;
  EXPECT_EQ(rows("t.sqlite").runs.size(), 48U);
  EXPECT_FALSE(fs::exists(work_ / "t.sqlite.partial"));
  EXPECT_FALSE(fs::exists(work_ / "t.sqlite.lock"));
}

TEST_F(SweepsGl, DryRunListsThePointsAndItsFileIsAboutAsLarge) {
  const Outcome dry = run("sweep p.toml --dry-run", false);
  EXPECT_EQ(dry.status, 0);
  EXPECT_NE(dry.text.find("condition 5: crowd.agents = 5, representation = mesh:triangles=200\n"), std::string::npos)
      << dry.text;
  EXPECT_NE(dry.text.find("p: 10 points in 5 conditions; about "), std::string::npos) << dry.text;
  EXPECT_FALSE(fs::exists(work_ / "p.sqlite"));
  EXPECT_NE(run("sweep p.toml --dry-run --shard 5/5", false).text.find("p: 2 points in 1 condition;"),
            std::string::npos);
  EXPECT_EQ(run("sweep p.toml --shard 6/5").status, 2);
  EXPECT_NE(run("sweep p.toml --shard 2").text.find("--shard: '2' is not a shard"), std::string::npos);
  EXPECT_EQ(run("sweep nowhere.toml").status, 2);
}

TEST_F(SweepsGl, JobsOfSchedulersAreWritten) {
  const Outcome slurm = run("sweep p.toml --slurm 3");
  EXPECT_EQ(slurm.status, 0) << slurm.text;
  const std::string array = read_text(work_ / "p.sbatch");
  EXPECT_NE(array.find("#SBATCH --array=1-3\n"), std::string::npos);
  EXPECT_EQ(support::run_shell("sh -n '" + (work_ / "p.sbatch").string() + "'").status, 0);
  EXPECT_NE(read_text(work_ / "p-merge.sbatch").find("p-3-of-3.sqlite"), std::string::npos);
  const Outcome none = run("sweep p.toml --slurm 3 --submit");
  if (support::run_shell("command -v sbatch").status != 0) {
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.text.find("--submit: sbatch failed"), std::string::npos) << none.text;
  }
  EXPECT_EQ(run("sweep p.toml --openjd 3").status, 0);
  const nlohmann::json jobs = nlohmann::json::parse(read_text(work_ / "p.openjd.json"));
  EXPECT_EQ(jobs.at("specificationVersion"), "jobtemplate-2023-09");
  EXPECT_EQ(jobs.at("steps").size(), 2U);
  EXPECT_EQ(jobs.at("steps")[0].at("parameterSpace").at("taskParameterDefinitions")[0].at("range"), "1-3");
  EXPECT_EQ(jobs.at("steps")[1].at("dependencies")[0].at("dependsOn"), jobs.at("steps")[0].at("name"));
  EXPECT_EQ(jobs.at("steps")[1].at("script").at("actions").at("onRun").at("args").size(), 5U);
}

}  // namespace
}  // namespace crowdbench::bench
