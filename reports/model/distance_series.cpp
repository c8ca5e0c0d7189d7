#include "reports/model/distance_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <map>
#include <set>

namespace crowdbench::reports {
namespace {

constexpr DistanceAxis kAxes[] = {{"distance_m", "distance from the eye", "m", false},
                                  {"height_px", "height", "pixels", true},
                                  {"pixels_per_texel", "pixels a texel", "", true}};

// "12.3 m", "0.45 pixels a texel".
std::string with_unit(double value, const DistanceAxis& axis) {
  return fmt::format("{:.4g} {}", value, *axis.unit == '\0' ? axis.title : axis.unit);
}

std::string interval_text(const ThresholdRow& row) {
  return fmt::format("95 %: {} to {}", row.low ? fmt::format("{:.4g}", *row.low) : "nearer than any",
                     row.high ? fmt::format("{:.4g}", *row.high) : "farther than any");
}

// The agents that a curve against distance is made of.
std::vector<DistancePoint> points_of(const StoreContents& contents, const CurveRow& curve) {
  std::vector<DistancePoint> points;
  for (const ComparisonRow& row : contents.comparisons) {
    if (row.run != curve.run || row.kind != "agent_in_crowd" || row.representation != curve.representation) continue;
    if (row.state != "counted" || !row.distance || !row.agent) continue;
    for (const ScoreRow& score : row.scores)
      if (score.name == curve.score && score.value) points.push_back({*row.distance, *score.value, *row.agent});
  }
  return points;
}

DistanceSeries series_of(const StoreContents& contents, const CurveRow& curve) {
  DistanceSeries series;
  series.representation = curve.representation;
  for (const CurveBinRow& bin : curve.bins) series.bins.push_back({bin.x, bin.median, bin.low, bin.high, bin.agents});
  if (curve.against == kAxes[0].name) series.points = points_of(contents, curve);
  if (curve.bins.empty()) return series;
  for (const ThresholdRow& row : contents.thresholds)
    if (row.curve == curve.id) series.thresholds.push_back({row.value, threshold_text(row, curve), row.status});
  return series;
}

}  // namespace

std::span<const DistanceAxis> distance_axes() { return kAxes; }

std::string threshold_text(const ThresholdRow& row, const CurveRow& curve) {
  const auto* axis =
      std::find_if(std::begin(kAxes), std::end(kAxes), [&](const DistanceAxis& a) { return curve.against == a.name; });
  assert(axis != std::end(kAxes) && !curve.bins.empty());
  const std::string at = row.at ? with_unit(*row.at, *axis) : "";
  if (row.status == "reached")
    return fmt::format("from {} on ({})", at.empty() ? "the nearest" : at, interval_text(row));
  if (row.status == "everywhere") return "already at the nearest, " + with_unit(curve.bins.front().x, *axis);
  if (row.status == "not_reached") return "not reached at the farthest, " + with_unit(curve.bins.back().x, *axis);
  return fmt::format("not distinguishable with {} agents; by the medians {} ({})", curve.agents,
                     at.empty() ? "not reached" : "from " + at + " on", interval_text(row));
}

std::vector<DistanceScore> distance_scores(const StoreContents& contents, int64_t run,
                                           const std::vector<ScoreDoc>& docs) {
  const auto place = [&](const std::string& name) {
    return std::find_if(docs.begin(), docs.end(), [&](const ScoreDoc& doc) { return doc.name == name; }) - docs.begin();
  };
  std::set<std::pair<std::ptrdiff_t, std::string>> names;
  for (const CurveRow& curve : contents.curves)
    if (curve.run == run) names.emplace(place(curve.score), curve.score);
  std::vector<DistanceScore> out;
  for (const auto& [order, name] : names) {
    DistanceScore of{doc_of(docs, name), {}};
    for (const DistanceAxis& axis : kAxes) {
      DistanceGraph graph{axis.title, axis.unit, axis.far_is_low, {}};
      for (const CurveRow& curve : contents.curves)
        if (curve.run == run && curve.score == name && curve.against == axis.name)
          graph.series.push_back(series_of(contents, curve));
      if (!graph.series.empty()) of.graphs.push_back(std::move(graph));
    }
    out.push_back(std::move(of));
  }
  return out;
}

}  // namespace crowdbench::reports
