// Based on: the normal approximation of the power of a test, effect = (z of the level + z of the power) x standard
// error, the error read from the interval of Hodges and Lehmann's estimate, which belongs to the signed rank test.
#include "bench/timing/control.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/block_bootstrap.h"
#include "core/hodges_lehmann.h"
#include "core/probability.h"
#include "core/rank_tests.h"

namespace crowdbench::bench {
namespace {

// Fewer values cannot come to a p of 5 %: with five of one sign it is 1 / 16.
constexpr size_t kLeastValues = 6;

double detectable_change(std::span<const double> logarithms, double inflation) {
  if (logarithms.size() < kLeastValues) return std::numeric_limits<double>::infinity();
  const Interval interval = hodges_lehmann(logarithms).interval;
  const double z_level = normal_quantile(1 - kControlLevel / 2);
  const double error = 0.5 * (interval.high - interval.low) / z_level * std::sqrt(inflation);
  return std::expm1((z_level + normal_quantile(kControlPower)) * error);
}

}  // namespace

Control judge_ratios(std::span<const double> ratios, uint64_t seed, size_t resamples) {
  std::vector<double> logarithms;
  logarithms.reserve(ratios.size());
  for (const double ratio : ratios) logarithms.push_back(std::log(ratio));
  const double inflation = serial_inflation(logarithms);
  Control control;
  control.ratio = {median(ratios), block_bootstrap_median(ratios, seed, 0.95, resamples), ratios.size()};
  control.p = 2 * inflated_p(wilcoxon_signed_rank(logarithms).p_two_sided / 2, inflation);
  control.detectable = detectable_change(logarithms, inflation);
  control.differs = control.p <= kControlLevel;
  return control;
}

std::optional<Control> judge_control(std::span<const SampleRow> first, std::span<const SampleRow> second, Metric metric,
                                     uint64_t seed) {
  const std::vector<double> ratios = ratios_by_round(second, first, metric);
  if (ratios.empty()) return std::nullopt;
  return judge_ratios(ratios, seed);
}

std::string control_text(const MedianRatio& ratio, double p, double detectable) {
  const std::string found =
      fmt::format("{:.3f}x [{:.3f}, {:.3f}], p = {:.2g}: {}", ratio.median, ratio.interval.low, ratio.interval.high, p,
                  p <= kControlLevel ? "DIFFERS, so do not trust differences of this size" : "no difference");
  if (std::isinf(detectable)) return found + "; too few rounds to find any";
  return found + fmt::format("; changes under {:.2g} % would be missed ({:.0f} % power)", 100 * detectable,
                             100 * kControlPower);
}

std::vector<ControlRow> control_rows(int64_t run, const PointKey& of, std::span<const SampleRow> first,
                                     std::span<const SampleRow> second) {
  std::vector<ControlRow> rows;
  for (const Metric metric : {Metric::cpu, Metric::wall, Metric::gpu})
    if (const auto control = judge_control(first, second, metric, kBootstrapSeed))
      rows.push_back({0, run, of, metric_name(metric), control->ratio.median, control->ratio.interval.low,
                      control->ratio.interval.high, control->p, control->detectable,
                      static_cast<int>(control->ratio.pairs)});
  return rows;
}

}  // namespace crowdbench::bench
