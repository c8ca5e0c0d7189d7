// Controls (A/A): one representation timed twice in the same rounds, as if it were two. Whatever the method says of a
// pair that does not differ is the method's own error.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "bench/timing/timing.h"
#include "core/statistics.h"

namespace crowdbench::bench {

// The level of the verdict on a control: so often "differs" is said of what does not.
inline constexpr double kControlLevel = 0.05;
// The power for which the smallest detectable change is stated.
inline constexpr double kControlPower = 0.8;

struct Control {
  MedianRatio ratio;      // of the second's times to the first's
  double p = 1;           // two-sided, Wilcoxon's signed rank test of the logarithms of the ratios
  double detectable = 0;  // a change by this fraction is found with kControlPower at kControlLevel; infinite where no
                          // change would be, as there are too few rounds
  bool differs = false;   // p <= kControlLevel
};
// first, second: of the same rounds. Where successive ratios are alike, test and detectable change are of the
// larger variance that comes of it (core/block_bootstrap.h). std::nullopt: no pair, or the metric is not available.
std::optional<Control> judge_control(std::span<const SampleRow> first, std::span<const SampleRow> second, Metric metric,
                                     uint64_t seed);
// The same of ratios by round, at least one, all positive. resamples: of the interval.
Control judge_ratios(std::span<const double> ratios, uint64_t seed, size_t resamples = kBootstrapResamples);

// "1.00x [0.99, 1.01], p = 0.62: no difference; changes under 1.9 % would be missed (80 % power)".
std::string control_text(const MedianRatio& ratio, double p, double detectable);

// The row of a control in every metric that it has.
std::vector<ControlRow> control_rows(int64_t run, const PointKey& of, std::span<const SampleRow> first,
                                     std::span<const SampleRow> second);

}  // namespace crowdbench::bench
