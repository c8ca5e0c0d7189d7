#include "bench/experiments/distance_curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/random.h"
#include "core/rank_correlation.h"

namespace crowdbench::bench {
namespace {

constexpr uint64_t kResamplePurpose = 0x64697374;
constexpr double kBandConfidence = 0.95;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kEverywhere = -kNever;

double middle_of(double a, double b) { return a == b ? a : 0.5 * (a + b); }

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return middle_of(values[(values.size() - 1) / 2], values[values.size() / 2]);
}

// The points of one bin by value, with the places of their agents among all.
struct Member {
  double value = 0;
  size_t agent = 0;
};

// The median where each agent counts as often as it was drawn; NaN where none was.
double weighted_median(const std::vector<Member>& by_value, const std::vector<uint32_t>& drawn) {
  uint64_t total = 0;
  for (const Member& m : by_value) total += drawn[m.agent];
  if (total == 0) return std::numeric_limits<double>::quiet_NaN();
  const uint64_t first = (total - 1) / 2;
  const uint64_t second = total / 2;
  uint64_t passed = 0;
  double lower = 0;
  for (size_t i = 0; i < by_value.size(); ++i) {
    const uint64_t next = passed + drawn[by_value[i].agent];
    if (first >= passed && first < next) lower = by_value[i].value;
    if (second < next) return middle_of(lower, by_value[i].value);
    passed = next;
  }
  return lower;
}

// The ends of the interval, outwards to values that occur, since some may be infinite.
std::pair<double, double> interval_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const double last = static_cast<double>(values.size() - 1);
  const auto low = static_cast<size_t>(std::floor(last * 0.5 * (1 - kBandConfidence)));
  const auto high = static_cast<size_t>(std::ceil(last * 0.5 * (1 + kBandConfidence)));
  return {values[low], values[high]};
}

CurveBin bin_of(const CurvePoint* begin, const CurvePoint* end) {
  CurveBin bin;
  std::vector<double> x;
  std::vector<double> values;
  std::vector<uint32_t> agents;
  for (const CurvePoint* p = begin; p != end; ++p) {
    x.push_back(p->x);
    values.push_back(p->value);
    agents.push_back(p->agent);
  }
  std::sort(agents.begin(), agents.end());
  bin.agents = static_cast<size_t>(std::unique(agents.begin(), agents.end()) - agents.begin());
  bin.points = x.size();
  bin.from = x.front();
  bin.to = x.back();
  bin.x = median_of(std::move(x));
  bin.value = median_of(std::move(values));
  return bin;
}

// Medians by resample and bin. members: of each bin, by value.
std::vector<std::vector<double>> resample(const std::vector<std::vector<Member>>& members, size_t agents,
                                          uint64_t seed) {
  std::vector<std::vector<double>> out(kCurveResamples);
  std::vector<uint32_t> drawn(agents);
  for (size_t r = 0; r < kCurveResamples; ++r) {
    std::fill(drawn.begin(), drawn.end(), 0U);
    for (size_t i = 0; i < agents; ++i) ++drawn[random_below(seed, r * agents + i, kResamplePurpose, agents)];
    for (const std::vector<Member>& bin : members) out[r].push_back(weighted_median(bin, drawn));
  }
  return out;
}

// From where the medians are good to the farthest, in metres away (or minus x): kEverywhere, kNever, or a place.
double crossing(const ScoreCurve& curve, const std::vector<double>& medians, const metrics::Score& score,
                double value) {
  const double sign = curve.far_is_low ? -1 : 1;
  std::optional<size_t> good;
  for (size_t b = medians.size(); b-- > 0;) {
    if (std::isnan(medians[b])) continue;
    if (!metrics::is_worse(score, medians[b], value)) {
      good = b;
      continue;
    }
    if (!good) return kNever;
    const double far = sign * curve.bins[*good].x;
    if (!std::isfinite(medians[b]) || !std::isfinite(medians[*good])) return far;
    const double near = sign * curve.bins[b].x;
    return near + (value - medians[b]) / (medians[*good] - medians[b]) * (far - near);
  }
  return good ? kEverywhere : kNever;
}

}  // namespace

ScoreCurve make_curve(std::vector<CurvePoint> points, size_t bins, uint64_t seed, bool far_is_low) {
  assert(bins > 0);
  ScoreCurve curve;
  curve.far_is_low = far_is_low;
  curve.points = points.size();
  if (points.empty()) return curve;
  const double sign = far_is_low ? -1 : 1;
  std::sort(points.begin(), points.end(), [&](const CurvePoint& a, const CurvePoint& b) {
    if (a.x != b.x) return sign * a.x < sign * b.x;
    return a.agent != b.agent ? a.agent < b.agent : a.value < b.value;
  });
  std::vector<uint32_t> agents;
  std::vector<double> away;
  std::vector<double> values;
  for (const CurvePoint& p : points) {
    agents.push_back(p.agent);
    away.push_back(sign * p.x);
    values.push_back(p.value);
  }
  std::sort(agents.begin(), agents.end());
  agents.erase(std::unique(agents.begin(), agents.end()), agents.end());
  curve.agents = agents.size();
  curve.rank_correlation = spearman(away, values);

  const size_t count = std::clamp<size_t>(agents.size() / kLeastBinAgents, 1, bins);
  std::vector<std::vector<Member>> members(count);
  for (size_t b = 0; b < count; ++b) {
    const CurvePoint* const begin = points.data() + b * points.size() / count;
    const CurvePoint* const end = points.data() + (b + 1) * points.size() / count;
    curve.bins.push_back(bin_of(begin, end));
    for (const CurvePoint* p = begin; p != end; ++p)
      members[b].push_back(
          {p->value, static_cast<size_t>(std::lower_bound(agents.begin(), agents.end(), p->agent) - agents.begin())});
    std::stable_sort(members[b].begin(), members[b].end(),
                     [](const Member& a, const Member& c) { return a.value < c.value; });
  }
  curve.resampled = resample(members, agents.size(), seed);
  for (size_t b = 0; b < count; ++b) {
    std::vector<double> medians;
    for (const std::vector<double>& of : curve.resampled)
      if (!std::isnan(of[b])) medians.push_back(of[b]);
    if (medians.empty()) medians.push_back(curve.bins[b].value);
    std::tie(curve.bins[b].low, curve.bins[b].high) = interval_of(std::move(medians));
  }
  return curve;
}

const char* reached_name(Reached reached) {
  switch (reached) {
    case Reached::from: return "reached";
    case Reached::everywhere: return "everywhere";
    case Reached::never: return "not_reached";
    case Reached::not_distinguishable: return "not_distinguishable";
  }
  assert(false);
  return "";
}

ThresholdPlace threshold_place(const ScoreCurve& curve, const metrics::Score& score, double value) {
  ThresholdPlace out;
  out.reached = Reached::not_distinguishable;
  if (curve.bins.empty()) return out;
  const double sign = curve.far_is_low ? -1 : 1;
  const auto place = [&](double at) { return std::isfinite(at) ? std::optional(sign * at) : std::nullopt; };
  std::vector<double> medians;
  for (const CurveBin& bin : curve.bins) medians.push_back(bin.value);
  out.at = place(crossing(curve, medians, score, value));
  std::vector<double> crossings;
  for (const std::vector<double>& of : curve.resampled) crossings.push_back(crossing(curve, of, score, value));
  const auto [low, high] = interval_of(std::move(crossings));
  out.low = place(low);
  out.high = place(high);
  if (curve.agents < kLeastBinAgents) return out;
  if (low == kNever)
    out.reached = Reached::never;
  else if (high == kEverywhere)
    out.reached = Reached::everywhere;
  else if (high != kNever)
    out.reached = Reached::from;
  return out;
}

}  // namespace crowdbench::bench
