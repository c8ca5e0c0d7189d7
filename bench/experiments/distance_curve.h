// A score of many agents against how far away they are: binned medians with a bootstrap band, and from where on the
// score is good enough. Pure functions: the same points give the same curve, in whatever order they come.
//
// Based on: B. Efron, "Bootstrap methods: another look at the jackknife", Annals of Statistics 7 (1979); whole agents
// are drawn, with all of their frames, since the frames of one agent are not independent of each other.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "metrics/registry.h"

namespace crowdbench::bench {

// One agent in one frame. value: never NaN; may be infinite. x: finite.
struct CurvePoint {
  uint32_t agent = 0;
  double x = 0;
  double value = 0;
};

struct CurveBin {
  double from = 0, to = 0;  // x of its nearest and of its farthest point
  double x = 0;             // median
  double value = 0;         // median
  double low = 0,
         high = 0;  // 95 % percentile interval of that median, by agents drawn anew; of no width with one agent
  size_t points = 0, agents = 0;
};

struct ScoreCurve {
  std::vector<CurveBin> bins;  // from near to far
  size_t points = 0, agents = 0;
  // Spearman's, of the value with nearness to farness (+1: the farther away, the greater the value), ties by their mean
  // rank; nothing where all values or all x are equal.
  std::optional<double> rank_correlation;
  bool far_is_low = false;
  // By resample: the medians of the bins, NaN where the resample has no point there. Threshold intervals come of them.
  std::vector<std::vector<double>> resampled;
};

// Bins of equally many points, at most `bins` of them and at least kLeastBinAgents agents a bin on average (so one bin
// where there are few). far_is_low: x falls with distance, as the height in pixels does. Resamples draw as many agents
// as there are, with replacement, by hashes of (seed, resample, draw).
ScoreCurve make_curve(std::vector<CurvePoint> points, size_t bins, uint64_t seed, bool far_is_low = false);
inline constexpr size_t kLeastBinAgents = 5;
inline constexpr size_t kCurveResamples = 1000;

enum class Reached : uint8_t {
  from,                // from `at` on, within [low, high]
  everywhere,          // at the nearest agents already; a place nearer than they are is not known
  never,               // not at the farthest agents
  not_distinguishable  // the interval holds both that it is reached and that it is not, or there are too few agents
};
// "reached", "everywhere", "not_reached", "not_distinguishable": for JSON.
const char* reached_name(Reached reached);

// From where on, going away, the binned median is as good as a value or better, and stays so to the farthest bin.
// Between the bins' middles it is straight.
struct ThresholdPlace {
  Reached reached = Reached::never;
  std::optional<double> at;         // as the points have it; nothing: everywhere, or never
  std::optional<double> low, high;  // the nearer and the farther end of the 95 % interval; nothing: open at that end
};
// Fewer agents than kLeastBinAgents carry no verdict.
ThresholdPlace threshold_place(const ScoreCurve& curve, const metrics::Score& score, double value);

}  // namespace crowdbench::bench
