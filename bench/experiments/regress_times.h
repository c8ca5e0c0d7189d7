// The times of `regress`: points of both sides paired by key, and the verdict on each.
#pragma once
#include <span>
#include <vector>

#include "bench/experiments/regress.h"

namespace crowdbench::bench {

// Of one side: logarithms of the ratio of a point's time to its yardstick's, by round, a vector a run.
struct TimeSeries {
  std::string scenario, metric;
  std::vector<std::vector<double>> runs;
  std::vector<double> controls;  // of each run that has one: the logarithm of what its A/A shows where nothing changed
  double control = 0;            // the largest of them that is not put down to chance by its own rounds, as a change
  // Of the reference, whose floor's samples are not kept: the logarithm of the stored ratio of the latest run, which is
  // the one value of each of its runs, and its standard error.
  std::optional<double> median, error;
};
struct TimeKey {
  std::string scenario_hash;
  std::string reference;
  PointKey key;
  auto operator<=>(const TimeKey&) const = default;
};
using TimesByKey = std::map<TimeKey, TimeSeries>;
TimesByKey times_of(std::span<const StoreContents> side);

// One point: the test, before the correction. verdict and reason are filled in by judge_times.
TimePoint compare_times(const TimeKey& key, const TimeSeries& baseline, const TimeSeries& current,
                        const RegressLimits& limits);
// Corrects over all points and gives each its verdict.
void judge_times(std::vector<TimePoint>& points, const RegressLimits& limits);

}  // namespace crowdbench::bench
