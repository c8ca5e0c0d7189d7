// How notes, remarks and tables call a point of a sweep.
#pragma once
#include <cstdint>
#include <string>

namespace crowdbench::bench {

// "1 agent", "250 agents".
std::string agents_text(uint32_t agents);
// "15 %", at most four digits.
std::string percent_text(double fraction);
// "15 %", or "the scenario's camera" for 0.
std::string view_name(double occupancy);

}  // namespace crowdbench::bench
