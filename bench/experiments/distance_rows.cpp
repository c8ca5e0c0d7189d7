#include "bench/experiments/distance_rows.h"

#include <map>

#include "bench/experiments/cause_rows.h"
#include "bench/experiments/score_rows.h"

namespace crowdbench::bench {
namespace {

ComparisonRow agent_row(const DistanceScene& scene, const DistanceRequest& request, const DistanceResult& result,
                        const DistanceAgent& agent, size_t representation) {
  const AgentView& view = agent.view;
  ComparisonRow row;
  row.kind = "agent_in_crowd";
  row.representation = request.representations[representation].text();
  row.reference = request.reference.text();
  row.character = scene.cast;
  row.agents = scene.agents;
  row.requested_occupancy = scene.requested_occupancy;
  row.tick = view.tick;
  row.height_px = view.height_px;
  row.agent = view.id - 1;
  row.distance = view.distance;
  row.pixels_per_texel = pixels_per_texel(result, view, representation);
  row.alone_px = view.alone_px;
  row.visible_px = view.visible_px;
  row.state = state_name(view.state);
  put_display(row, request.display);
  const AgentValues& values = agent.values[representation];
  for (size_t s = 0; s < values.size(); ++s)
    row.scores.push_back({std::string(request.scores[s]->name), values[s],
                          values[s] ? "" : "it does not exist over the agent's pixels, or neither picture shows any"});
  return row;
}

CurveRow curve_row(const DistanceScene& scene, const DistanceRequest& request, const DistanceCurve& curve) {
  CurveRow row;
  row.representation = request.representations[curve.representation].text();
  row.reference = request.reference.text();
  row.character = scene.cast;
  row.score = request.scores[curve.score]->name;
  row.against = all_against()[static_cast<size_t>(curve.against)].name;
  row.points = curve.curve.points;
  row.agents = static_cast<uint32_t>(curve.curve.agents);
  row.rank_correlation = curve.curve.rank_correlation;
  row.display = metrics::display_text(request.display);
  row.display_given = request.display.given;
  for (const CurveBin& bin : curve.curve.bins)
    row.bins.push_back({static_cast<int>(row.bins.size()), bin.from, bin.to, bin.x, bin.value, bin.low, bin.high,
                        bin.points, static_cast<uint32_t>(bin.agents)});
  return row;
}

}  // namespace

StoreContents distance_rows(const DistanceScene& scene, const DistanceRequest& request, const DistanceResult& result,
                            const std::vector<DistanceCurve>& curves, int64_t run) {
  StoreContents rows;
  for (const DistanceAgent& agent : result.agents)
    for (size_t r = 0; r < agent.values.size(); ++r) {
      rows.comparisons.push_back(agent_row(scene, request, result, agent, r));
      rows.comparisons.back().run = run;
    }
  for (const DistanceCurve& curve : curves) {
    CurveRow& row = rows.curves.emplace_back(curve_row(scene, request, curve));
    row.run = run;
    row.id = static_cast<int64_t>(rows.curves.size());
    for (const auto& [value, place] : curve.thresholds)
      rows.thresholds.push_back({0, run, row.id, value, reached_name(place.reached), place.at, place.low, place.high});
  }
  for (size_t r = 0; request.causes && r < request.representations.size(); ++r)
    for (CauseRangeRow& row : cause_rows(run, {request.representations[r].text(), request.reference.text(), scene.cast},
                                         distance_causes(result, r, scene.seed), "agent"))
      rows.cause_ranges.push_back(std::move(row));
  return rows;
}

void write_distance_rows(StoreWriter& store, const StoreContents& rows) {
  store.begin();
  for (const ComparisonRow& row : rows.comparisons) store.write(row);
  std::map<int64_t, int64_t> ids;
  for (const CurveRow& row : rows.curves) ids[row.id] = store.write(row);
  for (ThresholdRow row : rows.thresholds) {
    row.curve = ids.at(row.curve);
    store.write(row);
  }
  for (const CauseRangeRow& row : rows.cause_ranges) store.write(row);
  store.commit();
}

}  // namespace crowdbench::bench
