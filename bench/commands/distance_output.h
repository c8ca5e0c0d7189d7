// What `distance` prints and writes of a measurement.
#pragma once
#include <string>
#include <vector>

#include "bench/experiments/distance.h"
#include "core/json.h"
#include "store/rows.h"

namespace crowdbench::bench {

struct DistanceReport {
  scene::Scenario scenario;  // as staged
  std::string cast;          // for people
  std::string renderer;
  DistanceRequest request;
  DistanceResult result;
  std::vector<DistanceCurve> curves;
  bool list_all = false;  // print every score, not only those of tables (metrics::kInTables)
};

// bench/experiments/distance_rows.h
StoreContents rows_of(const DistanceReport& report, int64_t run = 0);
// {"scenario", "cast", "seed", "width", "height", "renderer", "reference", "representations", "ticks", "display",
//  "least_visible": share, "agents": {"scenario", "counted", "occluded", "cut_off", "no_pixel", "out_of_view"},
//  "scores": [name],
//  "curves": [{"representation", "score", "against": "distance_m" | "height_px" | "pixels_per_texel", "points",
//              "agents", "rank_correlation",
//              "bins": [{"from", "to", "x", "median", "low", "high", "points", "agents"}] from near to far,
//              "thresholds": [{"value", "status": reached_name(), "at", "low", "high"}]}],
//  "rows": [{"tick", "agent", "character", "distance_m", "height_px", "alone_px", "visible_px", "state": state_name(),
//            "scores": {representation: {score: value}}, "pixels_per_texel": {representation: ratio}}],
//  "causes": [{"representation", "by_height", "words", "frames": [{"tick", as causes_json}]}]}, with --causes
Json distance_json(const DistanceReport& report);
// The rows: one record an agent, tick and representation.
std::string distance_csv(const DistanceReport& report);
void print_distance(const DistanceReport& report);
// One self-contained page of charts. Throws Error (reports::page_frame).
std::string distance_page_of(const DistanceReport& report);

}  // namespace crowdbench::bench
