// Merging, on shards that nobody drew: CROWDBENCH_SWEEP_POINTS=10000 makes them large, and says how long it took.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>

#include "bench/sweep/merge.h"
#include "bench/sweep/sweep_run.h"
#include "tests/store/full_rows.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench::sweep {
namespace {

// A condition of two points with their times and scores, as ConditionBench makes them.
MeasuredCondition made_up(uint32_t condition) {
  MeasuredCondition out;
  out.run = full_run();
  out.run.scenario_hash = fmt::format("{:08x}", condition);
  for (int p = 0; p < 2; ++p) {
    MeasuredPoint point;
    point.row = full_sweep_point(0, 0, 0, 0);
    point.row.measurement.reset();
    point.row.comparison.reset();
    point.row.condition = condition;
    point.row.repetition = 0;
    point.row.point_key = fmt::format("{:015x}{}", condition, p);
    point.measurement = full_measurement(0);
    point.measurement->key.agents = condition;
    point.measurement->samples.clear();
    for (int i = 0; i < 24; ++i) point.measurement->samples.push_back({i, 1, 1000 + i, 2000, 3000, std::nullopt});
    for (int i = 0; i < 3; ++i) point.ratios.push_back(full_ratio(0));
    point.comparison = full_comparison(0);
    point.comparison->scores.clear();
    for (int i = 0; i < 8; ++i)
      point.comparison->scores.push_back({fmt::format("score{}", i), condition + 0.125 * i, ""});
    point.pictures = {full_picture(0, 0)};
    out.points.push_back(std::move(point));
  }
  return out;
}

SweepRow sweep_of(uint32_t conditions, Shard shard) {
  SweepRow row = full_sweep();
  row.conditions = conditions;
  row.repetitions = 1;
  row.points = 2 * uint64_t{conditions};
  row.shard = shard.index;
  row.shards = shard.count;
  return row;
}

class SweepMerge : public ::testing::Test {
 protected:
  MergeRequest shards(uint32_t conditions, uint32_t count) const {
    MergeRequest request;
    request.out = folder_ / fmt::format("of-{}.sqlite", count);
    for (uint32_t i = 1; i <= count; ++i) {
      const Shard shard{i, count};
      request.shards.push_back(folder_ / fmt::format("{}-of-{}.sqlite", i, count));
      StoreWriter store(request.shards.back());
      const int64_t sweep = store.write(sweep_of(conditions, shard));
      for (uint32_t c = 0; c < conditions; ++c)
        if (shard.holds(c)) write_condition(store, sweep, made_up(c));
    }
    return request;
  }
  support::ScratchFolder folder_;
};

TEST_F(SweepMerge, RowsKeepTogetherAndDoNotDependOnTheNumberOfShards) {
  const char* const asked = std::getenv("CROWDBENCH_SWEEP_POINTS");
  const auto conditions = static_cast<uint32_t>(asked != nullptr ? std::max(1, std::atoi(asked) / 2) : 20);
  ASSERT_NO_THROW(merge_shards(shards(conditions, 1)));
  const MergeRequest request = shards(conditions, 4);
  const auto begun = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const MergeOutcome outcome = merge_shards(request);
  if (asked != nullptr)
    fmt::print("{} points merged in {:.2f} s, {:.2f} s of CPU\n", outcome.contents.sweep_points.size(),
               std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(),
               static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  StoreContents one = read_store(folder_ / "of-1.sqlite", true, true);
  StoreContents four = read_store(request.out, true, true);
  EXPECT_TRUE(one.runs == four.runs);
  EXPECT_TRUE(one.measurements == four.measurements);
  EXPECT_TRUE(one.ratios == four.ratios);
  EXPECT_TRUE(one.comparisons == four.comparisons);
  EXPECT_TRUE(one.pictures == four.pictures);
  EXPECT_TRUE(one.sweep_points == four.sweep_points);
  EXPECT_TRUE(one.sweeps == four.sweeps);
  ASSERT_EQ(four.sweep_points.size(), 2 * size_t{conditions});
  // What is returned is what was written, samples and pictures apart.
  EXPECT_TRUE(outcome.contents.sweep_points == four.sweep_points);
  EXPECT_TRUE(outcome.contents.comparisons == four.comparisons);
  for (size_t i = 0; i < four.sweep_points.size(); ++i) {
    const SweepPointRow& row = four.sweep_points[i];
    EXPECT_EQ(row.condition, i / 2);
    EXPECT_EQ(four.measurements.at(static_cast<size_t>(*row.measurement) - 1).key.agents, row.condition);
    EXPECT_EQ(four.measurements.at(static_cast<size_t>(*row.measurement) - 1).run, row.run);
    EXPECT_EQ(four.comparisons.at(static_cast<size_t>(*row.comparison) - 1).scores[1].value, row.condition + 0.125);
    EXPECT_EQ(four.pictures.at(i).comparison, row.comparison);
  }
}

TEST_F(SweepMerge, AShardThatLacksAConditionIsNotWhole) {
  const MergeRequest request = shards(7, 2);
  {
    StoreWriter store(folder_ / "short.sqlite");
    const int64_t sweep = store.write(sweep_of(7, {2, 2}));
    write_condition(store, sweep, made_up(1));
  }
  MergeRequest lacking = request;
  lacking.shards[1] = folder_ / "short.sqlite";
  try {
    merge_shards(lacking);
    FAIL() << "it was merged";
  } catch (const MissingShards& missing) {
    EXPECT_EQ(missing.what, "missing in the shards named: 2 conditions");
  }
  EXPECT_FALSE(std::filesystem::exists(request.out));
  lacking.allow_missing = true;
  const MergeOutcome outcome = merge_shards(lacking);
  EXPECT_EQ(outcome.remarks, (std::vector<std::string>{"missing in the shards named: 2 conditions"}));
  EXPECT_EQ(outcome.contents.sweep_points.size(), 10U);
}

}  // namespace
}  // namespace crowdbench::bench::sweep
