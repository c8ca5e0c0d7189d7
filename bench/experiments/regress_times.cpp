// Based on: Mann and Whitney's test of the current values against those of the baseline moved by the least effect,
// which asks for more than that effect and not only for any; Hodges and Lehmann's estimate for the size; Holm's or
// Benjamini and Hochberg's correction.
#include "bench/experiments/regress_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/experiments/point_name.h"
#include "bench/timing/control.h"
#include "bench/timing/timing.h"
#include "core/block_bootstrap.h"
#include "core/hodges_lehmann.h"
#include "core/probability.h"
#include "core/rank_tests.h"

namespace crowdbench::bench {
namespace {

constexpr double kPower = 0.8;
constexpr const char* kFloor = "its floor";

Metric metric_of(const std::string& headline) {
  return headline == "gpu" ? Metric::gpu : headline == "wall" ? Metric::wall : Metric::cpu;
}

const MeasurementRow* find_reference(const StoreContents& contents, const MeasurementRow& row) {
  PointKey key = row.key;
  key.representation = row.reference;
  // Rows of one point are of one run and follow each other: the nearest is of the same rounds.
  const MeasurementRow* found = nullptr;
  for (const MeasurementRow& other : contents.measurements)
    if (other.run == row.run && other.key == key && !other.samples.empty() &&
        (found == nullptr || std::abs(other.id - row.id) < std::abs(found->id - row.id)))
      found = &other;
  return found;
}

// What the controls at this place show.
void add_controls(TimeSeries& series, const StoreContents& contents, const RunRow& run, const PointKey& key) {
  for (const ControlRow& control : contents.controls) {
    if (control.run != run.id || control.metric != run.headline || control.of.agents != key.agents ||
        control.of.requested_occupancy != key.requested_occupancy || control.of.character != key.character)
      continue;
    series.controls.push_back(std::log(control.ratio));
    if (control.p <= kControlLevel)
      series.control = std::max(series.control, std::expm1(std::abs(series.controls.back())));
  }
}

// The change that controls show where nothing changed. One of twenty runs differs by chance: of many it is asked
// whether they differ to the same side.
double control_of(const TimeSeries& baseline, const TimeSeries& current, bool by_run) {
  if (!by_run) return std::max(baseline.control, current.control);
  std::vector<double> all = baseline.controls;
  all.insert(all.end(), current.controls.begin(), current.controls.end());
  if (all.empty() || wilcoxon_signed_rank(all).p_two_sided > kControlLevel) return 0;
  return std::expm1(std::abs(median(all)));
}

void add_floor(TimeSeries& series, const StoreContents& contents, const RunRow& run, const PointKey& key) {
  for (const RatioRow& row : contents.ratios) {
    if (row.run != run.id || row.kind != "floor" || row.of != key || row.metric != run.headline || !(row.low > 0))
      continue;
    series.median = std::log(row.ratio);
    series.error = std::log(row.high / row.low) / (2 * normal_quantile(0.975));
  }
}

void add_row(TimesByKey& all, const StoreContents& contents, const RunRow& run, const MeasurementRow& row) {
  if (row.status != Status::valid || row.samples.empty()) return;
  TimeSeries series;
  series.scenario = run.scenario_name;
  series.metric = run.headline;
  add_controls(series, contents, run, row.key);
  if (row.key.representation == row.reference) {
    add_floor(series, contents, run, row.key);
    if (!series.median) return;
    series.runs.push_back({*series.median});
  } else {
    const MeasurementRow* reference = find_reference(contents, row);
    if (reference == nullptr) return;
    std::vector<double> logarithms = ratios_by_round(row.samples, reference->samples, metric_of(run.headline));
    if (logarithms.empty()) return;
    for (double& value : logarithms) value = std::log(value);
    series.runs.push_back(std::move(logarithms));
  }
  const auto [place, fresh] = all.try_emplace({run.scenario_hash, row.reference, row.key}, series);
  if (fresh) return;
  TimeSeries& known = place->second;
  known.control = std::max(known.control, series.control);
  known.controls.insert(known.controls.end(), series.controls.begin(), series.controls.end());
  known.median = series.median;
  known.error = series.error;
  for (std::vector<double>& values : series.runs) known.runs.push_back(std::move(values));
}

std::vector<double> values_by(const TimeSeries& series, bool by_run) {
  std::vector<double> values;
  for (const std::vector<double>& run : series.runs) {
    if (by_run) {
      values.push_back(median(run));
      continue;
    }
    values.insert(values.end(), run.begin(), run.end());
  }
  return values;
}

// Of the difference of both sides, by how much successive rounds of a run are alike.
double inflation_of(const TimeSeries& baseline, const TimeSeries& current) {
  double sum = 0;
  double rounds = 0;
  for (const TimeSeries* series : {&baseline, &current})
    for (const std::vector<double>& run : series->runs) {
      sum += serial_inflation(run) * static_cast<double>(run.size());
      rounds += static_cast<double>(run.size());
    }
  return rounds > 0 ? sum / rounds : 1;
}

// How many times larger the variance of the difference of both sides is than that of their independent rounds.
// error: of the difference, from these.
double inflation_by_runs(const TimeSeries& baseline, const TimeSeries& current, double error, double run_scatter) {
  const double alike = inflation_of(baseline, current);
  const double between = run_scatter * run_scatter *
                         (1 / static_cast<double>(baseline.runs.size()) + 1 / static_cast<double>(current.runs.size()));
  return alike + (error > 0 ? between / (error * error) : 0);
}

// The standard deviation of a run's median, over both sides; nothing where no side has two.
std::optional<double> scatter_of_runs(const TimeSeries& baseline, const TimeSeries& current) {
  double squares = 0;
  double degrees = 0;
  for (const TimeSeries* series : {&baseline, &current}) {
    const std::vector<double> values = values_by(*series, true);
    double sum = 0;
    for (const double value : values) sum += value;
    const double mean = sum / static_cast<double>(std::max<size_t>(1, values.size()));
    for (const double value : values) squares += (value - mean) * (value - mean);
    degrees += static_cast<double>(values.size()) - (values.empty() ? 0 : 1);
  }
  return degrees > 0 ? std::optional(std::sqrt(squares / degrees)) : std::nullopt;
}

// Runs of each side without which the exact rank test finds nothing at one of so many points, whatever it shows: of n
// and n values the least p is one over the ways to choose n of 2 n.
size_t least_runs(size_t points, const RegressLimits& limits) {
  const double tests = limits.correction == Correction::none ? 1 : static_cast<double>(points);
  size_t n = 1;
  for (double ways = 2; tests / ways > limits.level; ++n)
    ways *= static_cast<double>((2 * n + 2) * (2 * n + 1)) / static_cast<double>((n + 1) * (n + 1));
  return std::max(n, kRunsAsValues);
}

// Runs of each side that find a slow-down of limits.detect with kPower, by the normal law; at least kRunsAsValues, and
// more than there are: they did not tell.
size_t runs_needed(const TimeSeries& baseline, const TimeSeries& current, double least_effect,
                   const RegressLimits& limits) {
  const std::optional<double> scatter = scatter_of_runs(baseline, current);
  const double step = std::log1p(limits.detect) - std::log1p(least_effect);
  const size_t more = std::max(kRunsAsValues, std::min(baseline.runs.size(), current.runs.size()) * 3 / 2);
  if (!scatter || !(step > 0)) return more;
  const double errors = (normal_quantile(1 - limits.level) + normal_quantile(kPower)) * *scatter / step;
  return std::max(more, static_cast<size_t>(std::ceil(std::min(2 * errors * errors, 1e6))));
}

std::vector<double> moved(std::vector<double> values, double by) {
  for (double& value : values) value += by;
  return values;
}

double detectable_of(double error, const RegressLimits& limits, double least_effect) {
  return std::expm1(std::log1p(least_effect) + (normal_quantile(1 - limits.level) + normal_quantile(kPower)) * error);
}

double error_of(const Shift& shift) {
  return (shift.interval.high - shift.interval.low) / (2 * normal_quantile(0.975));
}

void put_medians(TimePoint& point, double baseline, double current) {
  point.baseline = std::exp(baseline);
  point.current = std::exp(current);
  point.change = std::expm1(current - baseline);
}

void compare_values(TimePoint& point, const std::vector<double>& baseline, const std::vector<double>& current,
                    const Shift& shift, double inflation, const RegressLimits& limits) {
  const double step = std::log1p(point.least_effect);
  const auto widened = [&](double end) {
    return std::expm1(shift.estimate + (end - shift.estimate) * std::sqrt(inflation));
  };
  point.interval = {widened(shift.interval.low), widened(shift.interval.high)};
  point.p_slower = inflated_p(mann_whitney(current, moved(baseline, step)).p_greater, inflation);
  point.p_faster = inflated_p(mann_whitney(current, moved(baseline, -step)).p_less, inflation);
  point.detectable = detectable_of(error_of(shift) * std::sqrt(inflation), limits, point.least_effect);
}

// Of the stored medians and their intervals, as if these were of normal values.
void compare_intervals(TimePoint& point, const TimeSeries& baseline, const TimeSeries& current,
                       const RegressLimits& limits) {
  const double scatter = limits.run_scatter.value_or(0);
  const double error = std::max(1e-12, std::hypot(*baseline.error, *current.error, scatter * std::sqrt(2.0)));
  const double change = *current.median - *baseline.median;
  const double step = std::log1p(point.least_effect);
  const double reach = normal_quantile(0.975) * error;
  point.interval = {std::expm1(change - reach), std::expm1(change + reach)};
  point.p_slower = normal_cdf(-(change - step) / error);
  point.p_faster = normal_cdf((change + step) / error);
  point.detectable = detectable_of(error, limits, point.least_effect);
}

std::string name_of(const PointKey& key) {
  return fmt::format("{}, {}, {}, {}, {}x{}", key.representation, key.character, agents_text(key.agents),
                     view_name(key.requested_occupancy), key.width, key.height);
}

std::string change_text(const TimePoint& point) {
  return fmt::format("{:+.1f} % [{:+.1f}, {:+.1f}]", 100 * point.change, 100 * point.interval.low,
                     100 * point.interval.high);
}

// "; about 30 runs of each tell"
std::string needed_text(const TimePoint& point) {
  return point.runs_needed > 0 ? fmt::format("; about {} runs of each tell", point.runs_needed) : std::string();
}

// Of a change that no test tells and that is no slow-down of limits.detect.
void judge_small(TimePoint& point, const RegressLimits& limits) {
  point.reason = change_text(point);
  if (point.interval.high <= limits.least_effect && point.interval.low >= -limits.least_effect) {
    point.verdict = Verdict::same;
    return;
  }
  point.verdict = Verdict::indistinct;
  if (point.interval.high > limits.least_effect)
    point.reason += fmt::format(": a slow-down of {:.2g} % is not excluded, one of {:.3g} % is",
                                100 * limits.least_effect, 100 * limits.detect);
  if (point.least_effect <= limits.least_effect) return;
  point.reason +=
      fmt::format("; the controls of these runs (A/A) differ by {:.2g} % without any change", 100 * point.least_effect);
  // All of the interval is a slow-down that was asked about, which the controls cover up.
  if (point.interval.low > limits.least_effect) point.verdict = Verdict::unclear;
}

void judge(TimePoint& point, const RegressLimits& limits) {
  if (!point.judged) {
    point.verdict = Verdict::unclear;
    point.reason = fmt::format(
        "{:+.1f} % between {} and {} runs; what differs from run to run without any change is not known, {} runs of "
        "each are needed",
        100 * point.change, point.baseline_runs, point.current_runs, point.runs_needed);
  } else if (point.unit == "rounds" && std::min(point.baseline_values, point.current_values) < limits.least_rounds) {
    point.verdict = Verdict::unclear;
    point.reason = fmt::format("{} and {} rounds, {} are needed", point.baseline_values, point.current_values,
                               limits.least_rounds);
  } else if (point.adjusted_slower <= limits.level) {
    point.verdict = Verdict::worse;
    point.reason = fmt::format("slower by {}, more than {:.2g} %", change_text(point), 100 * point.least_effect);
  } else if (point.adjusted_faster <= limits.level) {
    point.verdict = Verdict::better;
    point.reason = fmt::format("faster: {}", change_text(point));
  } else if (point.interval.high > limits.detect) {
    point.verdict = Verdict::unclear;
    point.reason = fmt::format("{}: a slow-down of {:.3g} % is not excluded{}", change_text(point), 100 * limits.detect,
                               needed_text(point));
  } else {
    judge_small(point, limits);
  }
}

}  // namespace

TimesByKey times_of(std::span<const StoreContents> side) {
  TimesByKey all;
  for (const StoreContents& contents : side) {
    std::map<int64_t, const RunRow*> runs;
    for (const RunRow& run : contents.runs) runs[run.id] = &run;
    for (const MeasurementRow& row : contents.measurements)
      if (const auto run = runs.find(row.run); run != runs.end()) add_row(all, contents, *run->second, row);
  }
  return all;
}

TimePoint compare_times(const TimeKey& key, const TimeSeries& baseline, const TimeSeries& current,
                        const RegressLimits& limits) {
  TimePoint point;
  point.scenario = current.scenario;
  point.what = name_of(key.key);
  point.key = key.key;
  point.metric = current.metric;
  point.baseline_runs = baseline.runs.size();
  point.current_runs = current.runs.size();
  const bool by_run = std::min(point.baseline_runs, point.current_runs) >= kRunsAsValues;
  point.judged = by_run || limits.run_scatter;
  point.least_effect = std::max(limits.least_effect, control_of(baseline, current, by_run));
  point.yardstick = current.median ? kFloor : "the reference";
  point.runs_needed = runs_needed(baseline, current, point.least_effect, limits);
  const std::vector<double> before = values_by(baseline, by_run);
  const std::vector<double> after = values_by(current, by_run);
  point.unit = by_run ? "runs" : current.median ? "intervals" : "rounds";
  point.baseline_values = before.size();
  point.current_values = after.size();
  point.detectable = std::numeric_limits<double>::infinity();
  if (before.empty() || after.empty()) return point;
  put_medians(point, median(before), median(after));
  if (!point.judged) return point;
  if (point.unit == "intervals") {
    compare_intervals(point, baseline, current, limits);
    return point;
  }
  const Shift shift = hodges_lehmann(after, before);
  const double inflation =
      by_run ? 1 : inflation_by_runs(baseline, current, error_of(shift), limits.run_scatter.value_or(0));
  point.change = std::expm1(shift.estimate);
  compare_values(point, before, after, shift, inflation, limits);
  return point;
}

void judge_times(std::vector<TimePoint>& points, const RegressLimits& limits) {
  std::vector<double> slower;
  std::vector<double> faster;
  for (const TimePoint& point : points) {
    slower.push_back(point.p_slower);
    faster.push_back(point.p_faster);
  }
  slower = adjusted_p_values(slower, limits.correction);
  faster = adjusted_p_values(faster, limits.correction);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].adjusted_slower = slower[i];
    points[i].adjusted_faster = faster[i];
    points[i].runs_needed = std::max(points[i].runs_needed, least_runs(points.size(), limits));
    judge(points[i], limits);
  }
}

}  // namespace crowdbench::bench
