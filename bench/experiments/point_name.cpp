#include "bench/experiments/point_name.h"

#include <fmt/format.h>

namespace crowdbench::bench {

std::string agents_text(uint32_t agents) { return fmt::format("{} {}", agents, agents == 1 ? "agent" : "agents"); }

std::string percent_text(double fraction) { return fmt::format("{:.4g} %", 100 * fraction); }

std::string view_name(double occupancy) {
  return occupancy > 0 ? percent_text(occupancy) : std::string("the scenario's camera");
}

}  // namespace crowdbench::bench
