#include "bench/experiments/bench_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <set>
#include <thread>

#include "bench/experiments/bench_table.h"
#include "bench/experiments/ratio.h"
#include "bench/stage/stage.h"
#include "bench/timing/image_check.h"
#include "bench/timing/run_facts.h"
#include "bench/timing/timed_representation.h"
#include "core/error.h"
#include "core/progress.h"
#include "scene/cast/load_cast.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

constexpr const char* kFlat = "flat:views=sphere-8x3,frames=2,texels=32";

// A handful of coarse figures in a small picture: the bookkeeping of a run, not its figures, is under test.
class BenchRunGl : public testing::Test {
 protected:
  static void SetUpTestSuite() { context_ = std::make_unique<gl::Context>(gl::ContextOptions{"software"}); }
  static void TearDownTestSuite() { context_.reset(); }
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("crowdbench_bench_" + std::to_string(::getpid()) + ".sqlite");
    remove();
    request_.scenario.name = "test";
    request_.scenario.width = 96;
    request_.scenario.height = 72;
    request_.scenario.characters[0].source = "mannequin:triangles=500";
    request_.agents = {2, 4};
    request_.occupancies = {0.15};
    request_.rounds = request_.least_rounds = 3;
    request_.floors = true;
    cast_ = scene::load_cast(request_.scenario);
  }
  void TearDown() override { remove(); }
  void remove() {
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(file_.string() + suffix);
  }
  BenchSummary bench() {
    StoreWriter store(file_);
    const TimingMethod method{Metric::cpu, false, "not asked"};
    RunRow run = describe_run(*context_, method, request_.scenario, "bench", "test", request_.order_seed);
    run.id = store.write(run);
    return run_bench(*context_, cast_, method, run, request_, store, [&](const std::string& now) {
      if (!sleep_at_.empty() && now.starts_with(sleep_at_)) {
        std::this_thread::sleep_for(std::chrono::duration<double>(request_.total_time_s));
        sleep_at_.clear();
      }
      if (!stop_at_.empty() && now.starts_with(stop_at_)) throw Interrupted{};
    });
  }

  static std::unique_ptr<gl::Context> context_;
  std::filesystem::path file_;
  BenchRequest request_;
  scene::Cast cast_;
  std::string stop_at_;   // the beginning of a note; empty: never
  std::string sleep_at_;  // the beginning of the first note at which the time of the run passes
};
std::unique_ptr<gl::Context> BenchRunGl::context_;

TEST_F(BenchRunGl, MeasuresEveryPointOnceAndContinuesAFile) {
  const BenchSummary first = bench();
  EXPECT_EQ(first.measured, 2U);
  EXPECT_EQ(first.held, 0U);
  EXPECT_EQ(first.invalid, 0U);
  const BenchSummary again = bench();
  EXPECT_EQ(again.measured, 0U);
  EXPECT_EQ(again.held, 2U);
  request_.agents = {2, 4, 6};
  const BenchSummary more = bench();
  EXPECT_EQ(more.measured, 1U);
  EXPECT_EQ(more.held, 2U);

  const StoreContents all = read_store(file_, true);
  ASSERT_EQ(all.runs.size(), 3U);
  EXPECT_TRUE(all.runs[0].software);
  EXPECT_EQ(all.runs[0].scenario_hash, all.runs[2].scenario_hash);
  ASSERT_EQ(all.measurements.size(), 3U);
  for (const MeasurementRow& row : all.measurements) {
    EXPECT_EQ(row.status, Status::valid) << row.reason;
    EXPECT_EQ(row.key.representation, "mesh");
    EXPECT_EQ(row.samples.size(), 3U);
    EXPECT_GE(row.warmup_frames, 2);
    ASSERT_TRUE(row.frame_ns && row.cpu_ns);
    EXPECT_GT(row.frame_ns->median, 0);
    EXPECT_FALSE(row.gpu_ns.has_value());
    EXPECT_NEAR(row.achieved_occupancy.value_or(0), 0.15, 0.01);
    EXPECT_NEAR(static_cast<double>(row.covered_px.value_or(0)), 0.15 * 96 * 72, 0.01 * 96 * 72);
    EXPECT_GT(row.moved_px.value_or(0), 0U);
    EXPECT_EQ(row.touched_px, row.covered_px);  // a mesh discards nothing
    EXPECT_NEAR(static_cast<double>(row.triangles_per_agent.value_or(0)), 500, 50);
    EXPECT_GT(row.texture_bytes.value_or(0), 0U);
  }
  // Each point has its floor's ratio in the two metrics that a software rasteriser has.
  size_t floors = 0;
  for (const RatioRow& ratio : all.ratios) floors += ratio.kind == "floor" ? 1 : 0;
  EXPECT_EQ(floors, 6U);
}

TEST_F(BenchRunGl, ACurveEndsWhereAFramePassesTheBudgetAndSaysSo) {
  request_.budget_ms = 1e-6;
  const BenchSummary summary = bench();
  ASSERT_FALSE(summary.remarks.empty());
  EXPECT_NE(summary.remarks[0].find("mesh at 15 %: stopped: at 2 agents"), std::string::npos) << summary.remarks[0];
  const StoreContents all = read_store(file_);
  ASSERT_EQ(all.measurements.size(), 2U);
  for (const MeasurementRow& row : all.measurements) {
    EXPECT_EQ(row.status, Status::stopped);
    EXPECT_NE(row.reason.find("at 2 agents a frame took"), std::string::npos) << row.reason;
    EXPECT_FALSE(row.frame_ns.has_value());
  }
  // The same budget, or a smaller one, has nothing to measure, and says again where the curve ended.
  for (const double budget_ms : {1e-6, 0.9e-6}) {
    request_.budget_ms = budget_ms;
    const BenchSummary again = bench();
    EXPECT_EQ(again.measured, 0U);
    EXPECT_EQ(again.held, 1U);
    ASSERT_FALSE(again.remarks.empty());
    EXPECT_EQ(again.remarks[0], summary.remarks[0]);
    EXPECT_EQ(read_store(file_).measurements.size(), 2U);
  }
  // A larger budget goes on in the same file.
  request_.budget_ms = 10'000;
  EXPECT_EQ(bench().measured, 2U);
}

// No point goes on when the time of the run is over, however many rounds were asked for.
TEST_F(BenchRunGl, LeavesThePointAtHandWhenItsTimeIsOver) {
  request_.agents = {2};
  ASSERT_EQ(bench().measured, 1U);
  request_.agents = {2, 4, 6};
  request_.total_time_s = 1.5;
  sleep_at_ = "4 agents at 15 %: round 2";
  const BenchSummary summary = bench();
  EXPECT_EQ(summary.held, 1U);
  EXPECT_EQ(summary.measured, 0U);
  ASSERT_EQ(summary.remarks.size(), 2U);
  EXPECT_EQ(summary.remarks[0], "4 agents at 15 %: left for another run of the same command: the time was over");
  EXPECT_EQ(summary.remarks[1], "6 agents at 15 %: left for another run of the same command: the time was over");
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
}

// Rounds that were timed by then are kept where they are enough.
TEST_F(BenchRunGl, KeepsEnoughRoundsWhenItsTimeIsOver) {
  CROWDBENCH_SKIP_SANITIZED("BenchRunGl.LeavesThePointAtHandWhenItsTimeIsOver");
  request_.agents = {2};
  request_.floors = false;
  request_.rounds = request_.least_rounds = 100;
  request_.total_time_s = 4;
  sleep_at_ = "2 agents at 15 %: round 30";  // the warm-up takes 12 at most
  const BenchSummary summary = bench();
  if (sleep_at_ == "2 agents at 15 %: round 30") GTEST_SKIP() << "30 rounds take longer than 4 s here";
  EXPECT_EQ(summary.measured, 1U);
  const StoreContents all = read_store(file_, true);
  ASSERT_EQ(all.measurements.size(), 1U);
  EXPECT_GE(all.measurements[0].samples.size(), 18U);
  EXPECT_LE(all.measurements[0].samples.size(), 28U);
}

TEST_F(BenchRunGl, AnOccupancyOutOfReachIsARowWithItsReason) {
  request_.agents = {1};
  request_.occupancies = {1.0};
  const BenchSummary summary = bench();
  EXPECT_EQ(summary.measured, 0U);
  const StoreContents all = read_store(file_);
  ASSERT_EQ(all.measurements.size(), 1U);
  EXPECT_EQ(all.measurements[0].status, Status::unreachable);
  EXPECT_NE(all.measurements[0].reason.find("100 % were asked for"), std::string::npos) << all.measurements[0].reason;
  EXPECT_LT(all.measurements[0].achieved_occupancy.value_or(1), 0.99);
  ASSERT_EQ(summary.remarks.size(), 1U);
  EXPECT_NE(summary.remarks[0].find("1 agent at 100 %: skipped"), std::string::npos) << summary.remarks[0];
}

// A convex polygon around a figure touches more than the figure, and all of it.
TEST_F(BenchRunGl, AnImpostorTouchesMoreThanItCovers) {
  scene::Scenario scenario = request_.scenario;
  scenario.crowd.agents = 4;
  scenario.occupancy = 0.15;
  const Staged staged = stage_scenario(scenario, cast_, *context_);
  Stage stage(*context_, cast_);
  stage.show(staged);
  TimedRepresentation flat(stage, renderers::parse_spec(kFlat), scenario, uint64_t{64} << 20);
  const ImageCheck check = check_pictures(flat.capture(0), flat.capture(15), false, std::nullopt);
  EXPECT_GT(flat.touched_px(0), check.covered_px * 11 / 10);
  EXPECT_LT(flat.touched_px(0), check.covered_px * 4);
}

// What the rows of an impostor say, held against what it is and against the mesh's rows.
TEST_F(BenchRunGl, AnImpostorHasRowsRatiosScoresAndPicturesOfItsOwn) {
  request_.representations = {renderers::parse_spec(kFlat)};
  request_.order_seed = 77;
  const BenchSummary summary = bench();
  EXPECT_EQ(summary.measured, 2U);
  ASSERT_EQ(summary.stages.size(), 2U);
  EXPECT_EQ(summary.stages[0].agents, 2U);
  EXPECT_EQ(summary.stages[1].agents, 4U);
  const StoreContents all = read_store(file_, true);
  ASSERT_EQ(all.runs.size(), 1U);
  EXPECT_EQ(all.runs[0].order_seed, 77U);
  ASSERT_EQ(all.measurements.size(), 4U);
  for (const size_t first : {0U, 2U}) {
    const MeasurementRow& mesh = all.measurements[first];
    const MeasurementRow& flat = all.measurements[first + 1];
    ASSERT_EQ(mesh.key.representation, "mesh");
    ASSERT_EQ(flat.key.representation, kFlat);
    EXPECT_EQ(flat.status, Status::valid) << flat.reason;
    const StageFacts& stage = summary.stages[first / 2].facts;
    for (const MeasurementRow* row : {&mesh, &flat}) {
      EXPECT_EQ(row->achieved_occupancy, stage.coverage.occupancy);
      EXPECT_EQ(row->reference_px, stage.coverage.covered_px);
      EXPECT_EQ(*row->agents_wholly + *row->agents_partly + *row->agents_off, row->key.agents);
    }
    EXPECT_EQ(mesh.covered_px, stage.coverage.covered_px);
    EXPECT_EQ(mesh.touched_px, stage.touched_px);
    EXPECT_NE(flat.covered_px, mesh.covered_px) << "32 texels do not follow an outline to the pixel";
    EXPECT_GT(flat.touched_px, flat.covered_px) << "the polygon around each figure";
    // One polygon of at most eight corners an agent; a 500-triangle body has some hundreds.
    EXPECT_LE(*flat.triangles_per_agent, 6U);
    EXPECT_GT(*mesh.triangles_per_agent, 400U);
    EXPECT_LT(*flat.primitives, *mesh.primitives / 10);
    EXPECT_GT(*flat.disk_bytes, 1000U);
    EXPECT_FALSE(mesh.disk_bytes.has_value()) << "a mesh is not baked";
  }
  // Of each point: speed of flat alone, floors of both, each by CPU and by wall clock.
  std::multiset<std::string> ratios;
  for (const RatioRow& row : all.ratios)
    if (row.of.agents == 4) ratios.insert(row.kind + " " + row.of.representation + " " + row.to + " " + row.metric);
  const std::string flat = kFlat;
  EXPECT_EQ(ratios, (std::multiset<std::string>{"speed " + flat + " mesh cpu", "speed " + flat + " mesh wall",
                                                "floor " + flat + " floor=1 cpu", "floor " + flat + " floor=1 wall",
                                                "floor mesh floor=1 cpu", "floor mesh floor=1 wall"}));
  // Scores at both points, pictures of the larger crowd alone.
  ASSERT_EQ(all.comparisons.size(), 2U);
  EXPECT_EQ(all.comparisons[1].agents, 4U);
  std::multiset<std::string> pictures;
  for (const PictureRow& picture : all.pictures) {
    EXPECT_EQ(picture.comparison, all.comparisons[1].id);
    pictures.insert(picture.role);
  }
  EXPECT_EQ(pictures, (std::multiset<std::string>{"difference", "reference", "test"}));
  // The table has a line a row, with the ratio in flat's, and one an A/A pair.
  const std::string table = bench_table(all, all.runs[0]);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 7) << table;
  EXPECT_NE(table.find("15 %"), std::string::npos) << table;
}

TEST_F(BenchRunGl, WhatWasFinishedBeforeAnInterruptionIsKept) {
  stop_at_ = "4 agents at 15 %: round 2";  // within the second point, whatever number of frames the warm-up takes
  EXPECT_THROW(bench(), Interrupted);
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
  stop_at_.clear();
  const BenchSummary rest = bench();
  EXPECT_EQ(rest.measured, 1U);
  EXPECT_EQ(rest.held, 1U);
}

TEST_F(BenchRunGl, RatioOfTheMeshToItselfIsAboutOne) {
  RatioRequest request;
  request.scenario = request_.scenario;
  request.scenario.crowd.agents = 4;
  request.scenario.occupancy = 0.15;
  request.of = request.to = renderers::parse_spec("mesh");
  request.pairs = kLeastPairs;
  const RatioReport report = measure_ratio(*context_, cast_, request);
  EXPECT_TRUE(report.valid);
  EXPECT_EQ(report.headline, "cpu");
  ASSERT_TRUE(report.cpu && report.wall);
  EXPECT_FALSE(report.gpu.has_value());
  // A broken pairing (another scene, the wrong way round) is off by factors; noise on a busy machine is not.
  EXPECT_GT(report.cpu->median, 0.5);
  EXPECT_LT(report.cpu->median, 2.0);
  EXPECT_EQ(report.headline_ratio.pairs, 20U);
  EXPECT_EQ(report.of_check.covered_px, report.to_check.covered_px);
  EXPECT_GT(report.of_check.covered_px, 0U);
  EXPECT_NEAR(static_cast<double>(report.triangles), 500, 50);
  EXPECT_EQ(report.order_seed, kOrderSeed);
  // Every time is of one of four: both sides, the mesh's floor and the mesh of 500 triangles; the mesh is `of` itself.
  ASSERT_EQ(report.medians.size(), 4U);
  EXPECT_EQ(report.medians[2].name, "mesh:floor=1");
  EXPECT_EQ(report.medians[3].name, "mesh:triangles=500");

  request.pairs = kLeastPairs - 1;
  EXPECT_THROW(measure_ratio(*context_, cast_, request), Error);
}

// Rounds in which a frame costs what is said of it, whatever else happens in the round.
std::vector<SampleRow> rounds_of(int64_t cpu_ns, int64_t wall_ns) {
  std::vector<SampleRow> samples;
  for (int round = 0; round < 20; ++round) {
    const int64_t drift = 1 + round % 3;
    samples.push_back({round, 0, wall_ns * drift, cpu_ns * drift, 0, std::nullopt});
  }
  return samples;
}

TEST(RatioFigures, AreTheCostsOverEachOther) {
  const auto of = rounds_of(100, 10);
  const auto to = rounds_of(700, 40);
  const auto mesh = rounds_of(650, 30);
  const auto floor = rounds_of(500, 25);
  const auto low_polygon = rounds_of(250, 60);
  RatioReport report;
  put_ratios(report, {of, to, mesh, floor, low_polygon}, Metric::cpu);
  EXPECT_EQ(report.headline, "cpu");
  EXPECT_DOUBLE_EQ(report.cpu->median, 7.0);
  EXPECT_DOUBLE_EQ(report.wall->median, 4.0);
  EXPECT_FALSE(report.gpu.has_value());
  EXPECT_DOUBLE_EQ(report.headline_ratio.median, 7.0);
  EXPECT_DOUBLE_EQ(report.mesh_floor.median, 1.3);
  EXPECT_DOUBLE_EQ(report.to_low_polygon.median, 2.5);
  EXPECT_FALSE(report.is_void);
  EXPECT_EQ(report.void_reason, "");
  // By the wall clock the same rounds say otherwise.
  put_ratios(report, {of, to, mesh, floor, low_polygon}, Metric::wall);
  EXPECT_EQ(report.headline, "wall");
  EXPECT_DOUBLE_EQ(report.headline_ratio.median, 4.0);
  EXPECT_DOUBLE_EQ(report.mesh_floor.median, 1.2);
  EXPECT_DOUBLE_EQ(report.to_low_polygon.median, 6.0);
}

TEST(RatioFigures, AMeshFarAboveItsFloorVoidsThem) {
  const auto frame = rounds_of(100, 100);
  RatioReport report;
  const auto floor = rounds_of(100, 1);
  const auto near_it = rounds_of(139, 1);
  put_ratios(report, {frame, frame, near_it, floor, frame}, Metric::cpu);
  EXPECT_FALSE(report.is_void);
  const auto mesh = rounds_of(142, 1);
  put_ratios(report, {frame, frame, mesh, floor, frame}, Metric::cpu);
  EXPECT_TRUE(report.is_void);
  EXPECT_EQ(report.void_reason, "the mesh takes 1.42 times its own floor, more than 1.4: no fair yardstick");
}

TEST(RatioFigures, AClockThatGivesNoTimeIsAnError) {
  const auto frame = rounds_of(100, 100);
  const auto nothing = rounds_of(0, 0);
  RatioReport report;
  EXPECT_THROW(put_ratios(report, {nothing, frame, frame, frame, frame}, Metric::cpu), Error);
  EXPECT_THROW(put_ratios(report, {frame, frame, frame, frame, frame}, Metric::gpu), Error);
}

}  // namespace
}  // namespace crowdbench::bench
