// A score of many agents against how far away they are, as the page and the charts of `distance` show it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "reports/model/score_doc.h"

namespace crowdbench::reports {

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

}  // namespace crowdbench::reports
