// Where two representations cost the same, over agents and occupancy, from models of both; and which one is the
// cheapest where. Pure functions.
//
// The models are of what is known before a frame is drawn (agents, covered pixels). How sure a ratio of two predictions
// is comes from the ratios that both predict without having seen them: its 95 % prediction interval, of logarithms,
// normal with an unknown deviation (Student's t). Nothing is said of a pair outside of what both were measured at, nor
// on the map outside of what all were: beyond the convex hull of those points over the logarithm of the agents and the
// occupancy, for which ranges of both by themselves would not do (a large crowd may be timed at one occupancy alone).
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/cost_model.h"

namespace crowdbench::reports {

struct BreakEvenPoint {
  double occupancy = 0;
  std::string cheaper_below, cheaper_beyond;  // names; equal where the order does not change; empty: cannot be told
  // Where the predicted times are equal, and between which the interval of their ratio holds 1. Nothing where the order
  // does not change within what was measured.
  std::optional<double> agents, low, high;
  bool low_open = false, high_open = false;  // the band reaches the end of what was measured
  uint32_t from = 0, to = 0;                 // agents between which both were measured at this occupancy
};
struct BreakEven {
  std::string first, second;
  double ratio_bias = 1;                // a measured ratio over the predicted one, in the geometric mean
  double ratio_factor = 1;              // a predicted ratio times the bias, times or over this: 95 % of measured ones
  std::vector<BreakEvenPoint> contour;  // by occupancy
};
struct CheapestCell {
  double agents = 0, occupancy = 0;
  std::string cheapest;
  std::vector<std::string> not_told_apart;  // whose ratio to the cheapest has 1 in its interval
};
struct BreakEvenMap {
  std::vector<CostModel> models;  // of what is known beforehand; those that are absent say why
  std::vector<BreakEven> pairs;   // of the models that there are; the reference first
  std::vector<CheapestCell> cells;
};
BreakEvenMap break_even_map(const Scene& scene);

// "flat is the cheaper one from about 120 agents on (80 to 190, the most timed) at 15 % occupancy".
std::string break_even_text(const BreakEven& pair, const BreakEvenPoint& point);

}  // namespace crowdbench::reports
