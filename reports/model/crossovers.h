// Where the curves of time against agents cross.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// Where two curves of time against agents cross, by log-log interpolation between measured points.
struct CrossoverLine {
  double occupancy = 0;
  std::string first, second;
  std::optional<double> agents;  // std::nullopt: they do not cross within the range that both cover
  std::string cheaper_below;     // with a crossing; else empty
  std::string cheaper_beyond;    // without a crossing: the cheaper one everywhere
  uint32_t from = 0, to = 0;     // the range of agents that both cover
  double time_ns = 0;            // at the crossing
};
// Every pair of representations at every occupancy; pairs with fewer than two common points are left out.
std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric);

}  // namespace crowdbench::reports
