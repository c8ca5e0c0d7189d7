// `regress` on simulated result files: what is unchanged passes, what is planted is found, and each output says so.
#include "bench/experiments/regress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "bench/commands/regress_output.h"
#include "bench/experiments/build_runs.h"
#include "bench/experiments/regress_times.h"
#include "bench/timing/control.h"
#include "bench/timing/timing.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/probability.h"
#include "metrics/registry.h"
#include "tests/bench/simulated_frames.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

using test::SimulatedMachine;

struct Build {
  double flat = 0.2;          // time over the reference's
  double slower_at_1000 = 1;  // a factor on the third representation at the largest crowd
  double ssim = 0.9;
  int shift = 0;  // of the picture, pixels
  int rounds = 96;
  double run_scatter = 0.003;  // standard deviation of a ratio's logarithm from one process to the next
};

// Made once for each shift.
const std::vector<uint8_t>& picture(int shift) {
  static std::map<int, std::vector<uint8_t>> all;
  if (const auto made = all.find(shift); made != all.end()) return made->second;
  Image8 image(64, 48, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<uint8_t>(((x + shift) / 4 + y / 4) % 2 == 0 ? 40 : 200);
  return all[shift] = encode_png(image);
}

// A result file of one run: three crowds, a reference and two others, their A/A, one comparison with its pictures.
StoreContents simulated_file(const Build& build, uint64_t seed, const SimulatedMachine& machine = {}) {
  StoreContents all;
  RunRow run;
  run.id = 1;
  run.scenario_name = "simulated";
  run.scenario_hash = "5cea";
  run.gl_renderer = "simulated";
  run.headline = "cpu";
  all.runs = {run};
  for (const uint32_t agents : {10U, 100U, 1000U}) {
    // What differs from one process to the next, by representation.
    const auto of_process = [&](uint64_t place) {
      return std::exp(build.run_scatter * test::simulated_normal(seed, agents * 8 + place, 77));
    };
    const double third = 0.4 * (agents == 1000 ? build.slower_at_1000 : 1);
    const auto rounds = test::simulated_rounds({1, build.flat * of_process(1), third * of_process(2), 1}, build.rounds,
                                               seed * 1000 + agents, machine);
    const PointKey mesh = {"mesh", "mannequin", agents, 640, 480, 0.15};
    for (size_t v = 0; v < 3; ++v) {
      MeasurementRow row;
      row.id = static_cast<int64_t>(all.measurements.size()) + 1;
      row.run = 1;
      row.key = mesh;
      row.key.representation = v == 0 ? "mesh" : v == 1 ? "flat" : "relief:boxes=2";
      row.reference = "mesh";
      row.samples = rounds[v];
      all.measurements.push_back(row);
    }
    all.ratios.push_back({1, 1, "floor", mesh, "floor=1", "cpu", 1.2, 1.19, 1.21, build.rounds});
    const Control control = judge_ratios(ratios_by_round(rounds[3], rounds[0], Metric::cpu), 1, 1);
    all.controls.push_back(
        {0, 1, mesh, "cpu", control.ratio.median, 0, 0, control.p, control.detectable, build.rounds});
  }
  ComparisonRow comparison;
  comparison.id = 1;
  comparison.run = 1;
  comparison.kind = "crowd";
  comparison.representation = "flat";
  comparison.reference = "mesh";
  comparison.character = "mannequin";
  comparison.agents = 100;
  comparison.requested_occupancy = 0.15;
  comparison.scores = {{std::string(metrics::scores()[0]->name), std::nullopt, "made up"}, {"ssim", build.ssim, ""}};
  all.comparisons = {comparison};
  all.pictures = {{1, 1, 1, "test", "", 64, 48, picture(build.shift)}};
  return all;
}

// What simulated runs are known to differ by.
constexpr double kRunScatter = Build{}.run_scatter;

RegressReport compare(const Build& before, const Build& after, uint64_t seed, RegressLimits limits = {}) {
  limits.run_scatter = kRunScatter;
  const std::vector<StoreContents> baseline = {simulated_file(before, 2 * seed)};
  const std::vector<StoreContents> current = {simulated_file(after, 2 * seed + 1)};
  RegressReport report = regress(baseline, current, limits, metrics::scores());
  for (PicturePoint& point : report.pictures) point.baseline = point.current = nullptr;  // of files that are gone
  return report;
}

const TimePoint& point_of(const RegressReport& report, const std::string& representation, uint32_t agents) {
  for (const TimePoint& point : report.times)
    if (point.key.representation == representation && point.key.agents == agents) return point;
  throw Error("test", "no such point", representation);
}

TEST(Regress, AnUnchangedBuildPassesFiftyTimes) {
  for (uint64_t run = 1; run <= 50; ++run) {
    const RegressReport report = compare({}, {}, run);
    ASSERT_EQ(report.times.size(), 9U);
    EXPECT_EQ(exit_status(report), 0) << run << '\n' << regress_text(report);
  }
}

TEST(Regress, APlantedSlowDownOfThreePercentIsFoundAtItsPlaceAlone) {
  constexpr uint64_t kTrials = 20;
  size_t found = 0;
  for (uint64_t trial = 0; trial < kTrials; ++trial) {
    const auto side = [&](double slower, uint64_t which) {
      std::vector<StoreContents> files;
      for (uint64_t run = 0; run < 12; ++run)
        files.push_back(
            simulated_file({.slower_at_1000 = slower, .rounds = 24}, 20'000 + (2 * trial + which) * 12 + run));
      return files;
    };
    const auto before = side(1, 0);
    const auto after = side(1.03, 1);
    const RegressReport report = regress(before, after, {}, metrics::scores());
    const TimePoint& point = point_of(report, "relief:boxes=2", 1000);
    found += exit_status(report) == 1 && point.verdict == Verdict::worse ? 1 : 0;
    EXPECT_NE(point_of(report, "relief:boxes=2", 100).verdict, Verdict::worse);
    EXPECT_NE(point_of(report, "flat", 1000).verdict, Verdict::worse);
    EXPECT_NEAR(point.change, 0.03, 0.015);
    EXPECT_EQ(point.unit, "runs");
    EXPECT_LT(point.interval.low, point.change);
    EXPECT_LE(point.p_slower, point.adjusted_slower);
  }
  EXPECT_GE(found, kTrials * 8 / 10)
      << "a power of 80 % at 12 runs of 24 rounds, 2 % of scatter and 0.3 % between runs";
}

TEST(Regress, FasterIsSaidAndNoRegression) {
  const RegressReport report = compare({}, {.flat = 0.17}, 7);
  EXPECT_EQ(exit_status(report), 0) << regress_text(report);
  EXPECT_EQ(point_of(report, "flat", 100).verdict, Verdict::better);
}

TEST(Regress, TooFewRoundsAndTooMuchNoiseAreNotEnoughData) {
  const RegressReport few = compare({.rounds = 5}, {.rounds = 5}, 3);
  EXPECT_EQ(exit_status(few), 3);
  EXPECT_NE(point_of(few, "flat", 10).reason.find("9 are needed"), std::string::npos);
  const std::vector<StoreContents> a = {simulated_file({.rounds = 24}, 1, {.noise = 0.3})};
  const std::vector<StoreContents> b = {simulated_file({.rounds = 24}, 2, {.noise = 0.3})};
  const RegressReport noisy = regress(a, b, {.run_scatter = kRunScatter}, metrics::scores());
  EXPECT_EQ(exit_status(noisy), 3) << regress_text(noisy);
  EXPECT_NE(regress_text(noisy).find("NOT ENOUGH DATA"), std::string::npos);
  const RegressReport nothing = regress(a, std::vector<StoreContents>{StoreContents{}}, {}, metrics::scores());
  EXPECT_EQ(exit_status(nothing), 3) << "no point in common";
}

// What a control shows without any change cannot be put down to a build.
TEST(Regress, AControlThatDiffersRaisesTheLeastEffect) {
  StoreContents after = simulated_file({.slower_at_1000 = 1.03}, 5);
  for (ControlRow& control : after.controls)
    if (control.of.agents == 1000) {
      control.ratio = 1.06;
      control.p = 0.001;
    }
  const std::vector<StoreContents> baseline = {simulated_file({}, 4)};
  const std::vector<StoreContents> current = {after};
  const RegressReport report = regress(baseline, current, {}, metrics::scores());
  EXPECT_NEAR(point_of(report, "relief:boxes=2", 1000).least_effect, 0.06, 1e-9);
  EXPECT_NE(point_of(report, "relief:boxes=2", 1000).verdict, Verdict::worse);
}

// No test tells these changes apart from none; what is said of them is what their intervals carry.
TEST(Regress, SameIsSaidOnlyWithinTheLeastEffect) {
  const auto judged = [](Interval interval, double control = 0) {
    TimePoint point;
    point.unit = "runs";
    point.interval = interval;
    point.change = (interval.low + interval.high) / 2;
    point.least_effect = std::max(0.01, control);
    std::vector<TimePoint> points = {point};
    judge_times(points, {});
    return points[0];
  };
  EXPECT_EQ(judged({-0.008, 0.009}).verdict, Verdict::same);
  const TimePoint wide = judged({-0.004, 0.013});
  EXPECT_EQ(wide.verdict, Verdict::indistinct);
  EXPECT_NE(wide.reason.find("a slow-down of 1 % is not excluded, one of 5 % is"), std::string::npos) << wide.reason;
  EXPECT_EQ(judged({-0.02, 0.005}).verdict, Verdict::indistinct) << "it may be faster";
  EXPECT_EQ(judged({-0.02, 0.06}).verdict, Verdict::unclear);
  // A slow-down that controls cover up is not called the same, and passes nothing.
  const TimePoint covered = judged({0.024, 0.038}, 0.035);
  EXPECT_EQ(covered.verdict, Verdict::unclear);
  EXPECT_NE(covered.reason.find("the controls of these runs (A/A) differ by 3.5 % without any change"),
            std::string::npos)
      << covered.reason;
  RegressReport report;
  report.times = {wide};
  EXPECT_EQ(exit_status(report), 0);
  EXPECT_NE(regress_text(report).find("not distinguishable"), std::string::npos);
  report.times = {covered};
  EXPECT_EQ(exit_status(report), 3);
}

// One of many runs whose control differs is chance; runs whose controls differ to one side are not.
TEST(Regress, ControlsOfManyRunsAreTakenTogether) {
  const auto files = [](uint64_t seed) {
    std::vector<StoreContents> all;
    for (uint64_t run = 0; run < 6; ++run) all.push_back(simulated_file({.rounds = 12}, seed + run));
    return all;
  };
  std::vector<StoreContents> before = files(400);
  std::vector<StoreContents> after = files(500);
  for (ControlRow& control : before[2].controls) {
    control.ratio = 1.06;
    control.p = 0.001;
  }
  EXPECT_EQ(point_of(regress(before, after, {}, metrics::scores()), "flat", 10).least_effect, 0.01);
  for (std::vector<StoreContents>* side : {&before, &after})
    for (StoreContents& one : *side)
      for (ControlRow& control : one.controls) control.ratio = 1.06;
  EXPECT_NEAR(point_of(regress(before, after, {}, metrics::scores()), "flat", 10).least_effect, 0.06, 1e-9);
}

// Rounds of one run share what differs from run to run: they have no verdict on times without it.
TEST(Regress, ARunASideTellsNothingUnlessItsScatterIsKnown) {
  const std::vector<StoreContents> before = {simulated_file({}, 40)};
  const std::vector<StoreContents> after = {simulated_file({.slower_at_1000 = 1.3}, 41)};
  const RegressReport unknown = regress(before, after, {}, metrics::scores());
  const TimePoint& point = point_of(unknown, "relief:boxes=2", 1000);
  EXPECT_EQ(exit_status(unknown), 3) << regress_text(unknown);
  EXPECT_FALSE(point.judged);
  EXPECT_EQ(point.runs_needed, 6U) << "nine points, level 1 %: 1 of the 924 ways to choose 6 of 12, 252 are too few";
  EXPECT_NEAR(point.change, 0.3, 0.02) << "what was seen is said";
  EXPECT_NE(point.reason.find("between 1 and 1 runs; what differs"), std::string::npos) << point.reason;
  EXPECT_NE(regress_json(unknown).dump().find("\"interval\":null"), std::string::npos);
  EXPECT_NE(regress_explanation(unknown, "relief:boxes=2, mannequin, 1000", {}).find("unclear"), std::string::npos);
  EXPECT_EQ(exit_status(regress(before, after, {.run_scatter = 0.01}, metrics::scores())), 1);
  EXPECT_EQ(exit_status(regress(before, after, {.run_scatter = 0.2}, metrics::scores())), 3)
      << "30 % is within what such runs differ by";
  // A changed picture needs no second run.
  const std::vector<StoreContents> shifted = {simulated_file({.shift = 1}, 41)};
  EXPECT_EQ(exit_status(regress(before, shifted, {}, metrics::scores())), 1);
}

// Five runs of each have no p below 1 / 252: at one of nine points nothing could be found, and that is said.
TEST(Regress, ARunMoreIsAskedForWhereTheTestItselfTakesIt) {
  const auto side = [](size_t runs, double slower, uint64_t seed) {
    std::vector<StoreContents> files;
    for (size_t run = 0; run < runs; ++run)
      files.push_back(simulated_file({.slower_at_1000 = slower, .rounds = 12}, seed + run));
    return files;
  };
  const auto before = side(5, 1, 600);
  const auto after = side(5, 1.5, 700);
  const RegressReport few = regress(before, after, {}, metrics::scores());
  EXPECT_EQ(exit_status(few), 3) << regress_text(few);
  EXPECT_EQ(point_of(few, "relief:boxes=2", 1000).runs_needed, 7U)
      << "six would do by the test; more than five by half";
  const auto more_before = side(6, 1, 600);
  const auto more_after = side(6, 1.5, 700);
  EXPECT_EQ(exit_status(regress(more_before, more_after, {}, metrics::scores())), 1);
}

// Where runs differ by several per cent, as on a machine with other work.
TEST(Regress, RunsThatDifferAreNoRegressionAndSayHowManyWouldTell) {
  size_t alarms = 0;
  size_t needed = 0;
  for (uint64_t trial = 0; trial < 20; ++trial) {
    std::vector<StoreContents> before;
    std::vector<StoreContents> after;
    for (uint64_t run = 0; run < 6; ++run) {
      before.push_back(simulated_file({.rounds = 12, .run_scatter = 0.06}, 5000 + 100 * trial + 2 * run));
      after.push_back(simulated_file({.rounds = 12, .run_scatter = 0.06}, 5001 + 100 * trial + 2 * run));
    }
    const RegressReport report = regress(before, after, {}, metrics::scores());
    alarms += exit_status(report) == 1 ? 1 : 0;
    EXPECT_NE(exit_status(report), 0) << "a slow-down of 5 % is not excluded";
    needed += point_of(report, "flat", 10).runs_needed;
    EXPECT_NE(regress_text(report).find("runs of each tell"), std::string::npos) << regress_text(report);
  }
  EXPECT_LE(alarms, 1U) << "level 1 %";
  // By the formula at 6.1 %: 2 ((2.326 + 0.842) 0.061 / 0.0388)^2 = 50; squares of a few runs' deviation average to it.
  EXPECT_GT(needed / 20, 35U);
  EXPECT_LT(needed / 20, 65U);
}

TEST(Regress, FiveRunsASideAreTheValues) {
  std::vector<StoreContents> before;
  std::vector<StoreContents> after;
  for (uint64_t run = 0; run < 6; ++run) {
    before.push_back(simulated_file({.rounds = 24}, 300 + 2 * run));
    after.push_back(simulated_file({.slower_at_1000 = 1.05, .rounds = 24}, 301 + 2 * run));
  }
  const RegressReport report =
      regress(before, after, {.correction = Correction::benjamini_hochberg}, metrics::scores());
  EXPECT_EQ(point_of(report, "flat", 10).unit, "runs");
  EXPECT_EQ(point_of(report, "flat", 10).baseline_values, 6U);
  EXPECT_EQ(point_of(report, "relief:boxes=2", 1000).verdict, Verdict::worse) << regress_text(report);
}

TEST(Regress, TheReferenceIsHeldAgainstItsFloor) {
  std::vector<StoreContents> before = {simulated_file({}, 8)};
  std::vector<StoreContents> after = {simulated_file({}, 9)};
  for (RatioRow& row : after[0].ratios)
    if (row.of.agents == 100) row = {1, 1, "floor", row.of, "floor=1", "cpu", 1.27, 1.26, 1.28, 96};
  const RegressReport report = regress(before, after, {.run_scatter = kRunScatter}, metrics::scores());
  EXPECT_EQ(point_of(report, "mesh", 100).verdict, Verdict::worse) << regress_text(report);
  EXPECT_EQ(point_of(report, "mesh", 10).verdict, Verdict::indistinct) << "medians alone do not exclude 1 %";
  EXPECT_EQ(point_of(report, "mesh", 100).yardstick, "its floor");
}

TEST(Regress, AScoreAndAPictureThatGotWorseAreFound) {
  const RegressReport worse = compare({}, {.ssim = 0.89}, 11);
  EXPECT_EQ(exit_status(worse), 1);
  ASSERT_EQ(worse.scores.size(), 2U);
  const RegressReport within = compare({}, {.ssim = 0.89}, 11, {.score_tolerances = {{"ssim", 0.02}}});
  EXPECT_EQ(exit_status(within), 0) << regress_text(within);
  EXPECT_EQ(exit_status(compare({}, {.ssim = 0.95}, 11)), 0) << "nearer to the reference";
  const RegressReport shifted = compare({}, {.shift = 1}, 11);
  EXPECT_EQ(exit_status(shifted), 1);
  ASSERT_EQ(shifted.pictures.size(), 1U);
  EXPECT_NEAR(shifted.pictures[0].share, 0.25, 0.02) << "one column in four changes its square";
  EXPECT_EQ(shifted.pictures[0].largest, 160);
}

TEST(Regress, OutputsSayTheSame) {
  const std::vector<StoreContents> before = {simulated_file({}, 20)};
  std::vector<StoreContents> after = {simulated_file({.slower_at_1000 = 1.08, .shift = 1}, 21)};
  after[0].measurements.erase(after[0].measurements.begin() + 1);  // flat, 10 agents
  const RegressReport report = regress(before, after, {.run_scatter = kRunScatter}, metrics::scores());
  EXPECT_EQ(report.only_baseline, std::vector<std::string>{"time of flat, 10 agents, 15 %"});
  const std::string text = regress_text(report);
  EXPECT_NE(text.find("REGRESSION: 2 worse"), std::string::npos) << text;
  EXPECT_NE(text.find("missing in CURRENT: time of flat, 10 agents"), std::string::npos) << text;
  EXPECT_NE(regress_markdown(report).find("**worse**"), std::string::npos);
  const std::string xml = regress_junit(report);
  EXPECT_NE(xml.find("failures=\"2\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("<skipped message=\"missing in CURRENT\"/>"), std::string::npos) << xml;
  EXPECT_EQ(regress_json(report).at("verdict").dump(), "\"regression\"");
  const support::ScratchFolder folder;
  const std::string why = regress_explanation(report, "relief:boxes=2, mannequin, 1000", {});
  EXPECT_NE(why.find("slower by"), std::string::npos) << why;
  const std::string pictures = regress_explanation(report, "test: flat", folder.path());
  EXPECT_NE(pictures.find("difference.png"), std::string::npos) << pictures;
  EXPECT_THROW(regress_explanation(report, "no such", {}), Error);
}

TEST(Regress, OtherDevicesAreNotCompared) {
  const std::vector<StoreContents> before = {simulated_file({}, 1)};
  std::vector<StoreContents> after = {simulated_file({}, 2)};
  after[0].runs[0].gl_renderer = "another";
  EXPECT_THROW(regress(before, after, {}, metrics::scores()), Error);
}

// CROWDBENCH_LONG_FORM=1: how often an unchanged build and one that is 3 % slower at one of nine points are called a
// regression, by how much runs differ and how many there are.
TEST(Regress, PowerByRunsAndTheirScatter) {
  const bool long_form = std::getenv("CROWDBENCH_LONG_FORM") != nullptr;
  const uint64_t trials = long_form ? 200 : 10;
  if (long_form)
    std::cout << "| a run differs by | runs of each | unchanged: regression | not enough data | 3 % slower: found |\n"
                 "|--:|--:|--:|--:|--:|\n";
  for (const double scatter : long_form ? std::vector{0.003, 0.01, 0.02} : std::vector{0.003})
    for (const size_t runs : long_form ? std::vector<size_t>{6, 8, 12, 24} : std::vector<size_t>{12}) {
      size_t alarms = 0;
      size_t unclear = 0;
      size_t found = 0;
      for (uint64_t trial = 0; trial < trials; ++trial) {
        const auto side = [&](double slower, uint64_t which) {
          std::vector<StoreContents> files;
          for (size_t run = 0; run < runs; ++run)
            files.push_back(simulated_file({.slower_at_1000 = slower, .rounds = 24, .run_scatter = scatter},
                                           100'000 + (trial * 3 + which) * runs + run, {.noise = 0.02}));
          return files;
        };
        const auto baseline = side(1, 0);
        const int same = exit_status(regress(baseline, side(1, 1), {}, metrics::scores()));
        alarms += same == 1 ? 1 : 0;
        unclear += same == 3 ? 1 : 0;
        found += exit_status(regress(baseline, side(1.03, 2), {}, metrics::scores())) == 1 ? 1 : 0;
      }
      if (long_form)
        std::cout << "| " << 100 * scatter << " % | " << runs << " | " << alarms << " of " << trials << " | " << unclear
                  << " | " << found << " of " << trials << " |\n"
                  << std::flush;
      EXPECT_LE(alarms, binomial_limits(trials, RegressLimits{}.level).high);
      if (scatter < 0.01 && runs >= 12) {
        EXPECT_GE(found, 80 * trials / 100);
      }
    }
}

// ---- two builds in turns

// A program that stands in for crowdbench: notes its name and arguments, and leaves a made-up result file.
class BuildRunsTest : public ::testing::Test {
 protected:
  std::string program(const std::string& name, int status) const {
    const std::filesystem::path path = folder_ / name;
    write_file(path, std::string_view("#!/bin/sh\necho " + name + " \"$1 $2 $3\" >>'" + (folder_ / "log").string() +
                                      "'\nfor last; do :; done\ncp '" + (folder_ / "made.sqlite").string() +
                                      "' \"$last\"\necho the reason >&2\nexit " + std::to_string(status) + "\n"));
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path.string();
  }
  void SetUp() override {
    StoreWriter store(folder_ / "made.sqlite");
    RunRow run;
    run.scenario_name = "made up";
    run.headline = "cpu";
    store.write(run);
  }
  support::ScratchFolder folder_;
};

TEST_F(BuildRunsTest, EachRunIsAProcessAndTheyAlternate) {
  const BuildRuns runs = run_builds(program("a", 0), program("b", 1), "plaza.toml --agents 5", 2);
  EXPECT_EQ(read_text(folder_ / "log"),
            "a bench plaza.toml --agents\nb bench plaza.toml --agents\na bench plaza.toml --agents\n"
            "b bench plaza.toml --agents\n");
  ASSERT_EQ(runs.a.size(), 2U);
  ASSERT_EQ(runs.b.size(), 2U) << "status 1 is a picture check that failed, and has rows";
  EXPECT_EQ(runs.b[1].runs.at(0).scenario_name, "made up");
}

TEST_F(BuildRunsTest, AProgramThatFailsIsNamedWithItsLastLine) {
  try {
    (void)run_builds(program("a", 0), program("b", 2), "x", 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.where, (folder_ / "b").string());
    EXPECT_EQ(error.wrong, "`bench x` failed: the reason");
  }
}

}  // namespace
}  // namespace crowdbench::bench
