// From how many agents on a representation is cheaper than the reference, and how sure that is.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// What the paired ratios of two representations say about a range of agents. Between the numbers that were measured a
// ratio and the ends of its interval are straight in (log agents, log ratio).
struct CrossoverLine {
  double occupancy = 0;
  std::string first, second;  // the reference and the other
  // Where the order changes: the ratio is 1, and the 95 % interval in agents, where the interval of the ratio leaves 1
  // on either side. std::nullopt: nowhere that the intervals carry.
  std::optional<double> agents;
  double agents_low = 0, agents_high = 0;
  std::string cheaper_below;   // with a crossing; else empty
  std::string cheaper_beyond;  // without a crossing: the cheaper one wherever they can be told apart; empty: nowhere
  uint32_t from = 0, to = 0;   // the range of agents that both were timed with
  uint32_t told_from = 0,
           told_to = 0;  // of those the least and the most where they can be told apart; without a crossing
  double time_ns = 0;    // of the reference at the crossing
};
// Every representation against the reference at every occupancy, from the ratios "speed" of interleaved rounds, never
// from two medians; pairs with fewer than two common points are left out. Several lines where the order changes more
// than once.
std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric);

// "from about 163 agents on (95 % interval 120 to 250), flat is the cheaper one", "mesh is the cheaper one from 1 to
// 1,000 agents", "not distinguishable from 100 to 2,000 agents".
std::string crossover_text(const CrossoverLine& line);

}  // namespace crowdbench::reports
