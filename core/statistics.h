// The statistics that commands and reports share: order statistics, the median of paired ratios with a bootstrap
// interval, and where two cost curves cross. Pure functions: the same numbers in give the same numbers out.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crowdbench {

// The q-quantile, 0 <= q <= 1, by linear interpolation between order statistics at position (n - 1) q (type 7 of
// Hyndman and Fan 1996, the default of R and NumPy). `values`: any order, at least one, all finite.
double quantile(std::span<const double> values, double q);
// The 0.5-quantile: the middle value, or the mean of the two middle ones.
double median(std::span<const double> values);
// The same, which reorders them.
double median_in_place(std::span<double> values);

// The figures that a set of frame times is reported by. All in the unit of the input, save fps.
struct Summary {
  size_t count = 0;
  double median = 0;
  double p05 = 0;
  double p95 = 0;
  double p99 = 0;
  // 1e9 over the mean of the slowest 1 % of the frames (rounded up, so at least one): the "1 % low", in frames a
  // second.
  double low_1_percent_fps = 0;
};
// times_ns: frame times in nanoseconds, at least one, all positive.
Summary summarise(std::span<const double> times_ns);

struct Interval {
  double low = 0;
  double high = 0;
};

// The bootstrap percentile interval (Efron 1979) of the median: `resamples` sets of n values are drawn with replacement
// and the (1 - confidence) / 2 and (1 + confidence) / 2 quantiles of their medians returned. values: at least one,
// treated as independent draws. The draws are a hash of (seed, resample, draw): the same seed gives the same interval,
// on every machine. One value alone gives an interval of width 0, which says nothing: state the count beside it.
constexpr size_t kBootstrapResamples = 4000;
Interval bootstrap_median(std::span<const double> values, uint64_t seed, double confidence = 0.95,
                          size_t resamples = kBootstrapResamples);

// The median of the paired ratios numerator[i] / denominator[i] and its 95 % bootstrap interval, as `ratio` reports it:
// numerator = t(to), denominator = t(of), so that above 1 `of` is the faster.
struct MedianRatio {
  double median = 0;
  Interval interval;
  size_t pairs = 0;
};
// Both spans: the same length, at least one, all positive; element i of both was measured in the same round.
MedianRatio median_of_ratios(std::span<const double> numerator, std::span<const double> denominator, uint64_t seed,
                             size_t resamples = kBootstrapResamples);

// A cost curve: y (say, frame time) against x (say, agents); x strictly ascending, both positive. Between its points
// it is straight in (log x, log y), that is, a power law; outside them it is not defined.
struct Curve {
  std::vector<double> x;
  std::vector<double> y;
};
struct Crossover {
  double x = 0;
  double y = 0;
  bool first_is_below_after = false;  // beyond x the first curve is the cheaper one
};
// Every place where the order of the two curves changes, by ascending x, within the range of x that both cover. Curves
// that touch without changing order do not cross; where they coincide over a stretch before changing order, the
// stretch's far end is the crossover.
std::vector<Crossover> crossovers(const Curve& first, const Curve& second);

}  // namespace crowdbench
