// A score of many agents against how far away they are, as the page and the charts of `distance` show it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reports/model/score_doc.h"
#include "store/rows.h"

namespace crowdbench::reports {

// What a curve is drawn against.
struct DistanceAxis {
  const char* name;   // in the result store and in JSON
  const char* title;  // for people
  const char* unit;   // for people; may be empty
  bool far_is_low;    // what is far away has low x
};
// Distance, height, pixels a texel.
std::span<const DistanceAxis> distance_axes();

struct DistanceBin {
  double x = 0;
  double value = 0, low = 0, high = 0;  // median and its 95 % interval; may be infinite
  size_t agents = 0;
};
struct DistancePoint {
  double x = 0, value = 0;  // value: may be infinite
  uint32_t agent = 0;
};
struct DistanceThresholdText {
  double value = 0;
  std::string place;   // for people: "from 12.3 m on (95 %: 10.1 to 14)"
  std::string status;  // "reached", "everywhere", "not_reached", "not_distinguishable"
};

// One representation.
struct DistanceSeries {
  std::string representation;
  std::vector<DistanceBin> bins;      // from near to far
  std::vector<DistancePoint> points;  // may be empty: the bins alone are drawn
  std::vector<DistanceThresholdText> thresholds;
};

// One axis.
struct DistanceGraph {
  std::string against;      // "distance from the eye"
  std::string unit;         // "m"; may be empty
  bool far_is_low = false;  // what is far away has low x
  std::vector<DistanceSeries> series;
};

struct DistanceScore {
  ScoreDoc doc;
  std::vector<DistanceGraph> graphs;
};

// For people: "from 12.3 m on (95 %: 10.1 to 14)". curve: of the row, with its bins.
std::string threshold_text(const ThresholdRow& row, const CurveRow& curve);

// The curves of one run: scores as `docs` order them, each against what it was drawn against.
std::vector<DistanceScore> distance_scores(const StoreContents& contents, int64_t run,
                                           const std::vector<ScoreDoc>& docs);

}  // namespace crowdbench::reports
