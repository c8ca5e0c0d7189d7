#include "bench/experiments/bench_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "bench/experiments/ratio.h"
#include "core/error.h"
#include "core/progress.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

// A handful of coarse figures in a small picture: the bookkeeping of a sweep, not its figures, is under test.
class SweepGl : public testing::Test {
 protected:
  static void SetUpTestSuite() { context_ = std::make_unique<gl::Context>(gl::ContextOptions{"software"}); }
  static void TearDownTestSuite() { context_.reset(); }
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("crowdbench_sweep_" + std::to_string(::getpid()) + ".sqlite");
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
  SweepSummary sweep() {
    StoreWriter store(file_);
    const TimingMethod method{Metric::cpu, false, "not asked"};
    RunRow run = describe_run(*context_, method, request_.scenario, "bench", "test");
    run.id = store.write(run);
    return run_sweep(*context_, cast_, method, run, request_, store, [&](const std::string& now) {
      if (!stop_at_.empty() && now.starts_with(stop_at_)) throw Interrupted{};
    });
  }

  static std::unique_ptr<gl::Context> context_;
  std::filesystem::path file_;
  SweepRequest request_;
  scene::Cast cast_;
  std::string stop_at_;  // the beginning of a note; empty: never
};
std::unique_ptr<gl::Context> SweepGl::context_;

TEST_F(SweepGl, MeasuresEveryPointOnceAndContinuesAFile) {
  const SweepSummary first = sweep();
  EXPECT_EQ(first.measured, 2U);
  EXPECT_EQ(first.held, 0U);
  EXPECT_EQ(first.invalid, 0U);
  const SweepSummary again = sweep();
  EXPECT_EQ(again.measured, 0U);
  EXPECT_EQ(again.held, 2U);
  request_.agents = {2, 4, 6};
  const SweepSummary more = sweep();
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
    EXPECT_EQ(row.covered_px, row.reference_px);
    EXPECT_NEAR(static_cast<double>(row.covered_px.value_or(0)) / (96 * 72), *row.achieved_occupancy, 1e-9);
    EXPECT_GT(row.moved_px.value_or(0), 0U);
    EXPECT_EQ(row.touched_px, row.covered_px);  // a mesh discards nothing
    EXPECT_EQ(row.triangles_per_agent, cast_.characters[0]->triangles());
    EXPECT_GT(row.texture_bytes.value_or(0), 0U);
  }
  // Each point has its floor's ratio in the two metrics that a software rasteriser has.
  size_t floors = 0;
  for (const RatioRow& ratio : all.ratios) floors += ratio.kind == "floor" ? 1 : 0;
  EXPECT_EQ(floors, 6U);
}

TEST_F(SweepGl, ACurveEndsWhereAFramePassesTheBudgetAndSaysSo) {
  request_.budget_ms = 1e-6;
  const SweepSummary summary = sweep();
  ASSERT_FALSE(summary.remarks.empty());
  EXPECT_NE(summary.remarks[0].find("mesh at 15 %: stopped at 2 agents"), std::string::npos) << summary.remarks[0];
  const StoreContents all = read_store(file_);
  ASSERT_EQ(all.measurements.size(), 2U);
  for (const MeasurementRow& row : all.measurements) {
    EXPECT_EQ(row.status, Status::stopped);
    EXPECT_NE(row.reason.find("at 2 agents a frame took"), std::string::npos) << row.reason;
    EXPECT_FALSE(row.frame_ns.has_value());
  }
  // A larger budget goes on in the same file.
  request_.budget_ms = 10'000;
  EXPECT_EQ(sweep().measured, 2U);
}

TEST_F(SweepGl, AnOccupancyOutOfReachIsARowWithItsReason) {
  request_.agents = {1};
  request_.occupancies = {1.0};
  const SweepSummary summary = sweep();
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
TEST_F(SweepGl, AnImpostorTouchesMoreThanItCovers) {
  scene::Scenario scenario = request_.scenario;
  scenario.crowd.agents = 4;
  scenario.occupancy = 0.15;
  const scene::Solved solved = solve_scene(*context_, scenario, cast_);
  Stage stage(*context_, cast_);
  stage.show(solved.scenario, solved.crowd, solved.camera);
  TimedRepresentation flat(stage, renderers::parse_spec("flat:views=sphere-8x3,texels=32,frames=2"), scenario.width,
                           scenario.height, uint64_t{64} << 20);
  const ImageCheck check = check_pictures(flat.capture(0), flat.capture(15), false, std::nullopt);
  EXPECT_GT(flat.touched_px(0), check.covered_px * 11 / 10);
  EXPECT_LT(flat.touched_px(0), check.covered_px * 4);
}

TEST_F(SweepGl, WhatWasFinishedBeforeAnInterruptionIsKept) {
  stop_at_ = "4 agents at 15 %: turn 2";  // within the second point, whatever number of frames the warm-up takes
  EXPECT_THROW(sweep(), Interrupted);
  EXPECT_EQ(read_store(file_).measurements.size(), 1U);
  stop_at_.clear();
  const SweepSummary rest = sweep();
  EXPECT_EQ(rest.measured, 1U);
  EXPECT_EQ(rest.held, 1U);
}

TEST_F(SweepGl, RatioOfTheMeshToItselfIsAboutOne) {
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
  EXPECT_EQ(report.triangles, cast_.characters[0]->triangles());
  EXPECT_EQ(report.void_reason.empty(), !report.is_void);
  EXPECT_EQ(report.is_void, report.mesh_floor.median > 1.4);

  request.pairs = kLeastPairs - 1;
  EXPECT_THROW(measure_ratio(*context_, cast_, request), Error);
}

}  // namespace
}  // namespace crowdbench::bench
