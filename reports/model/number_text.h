// Numbers as text for people.
#pragma once
#include <cstdint>
#include <string>

namespace crowdbench::reports {

std::string count_text(uint64_t count);        // "1,000"
std::string agents_text(uint64_t count);       // "1 agent", "1,000 agents"
std::string time_text(double nanoseconds);     // "12.3 ms"
std::string bytes_text(uint64_t bytes);        // "4.2 MiB"
std::string percent_text(double fraction);     // "15 %", "12.3 %"
std::string factor_text(double factor);        // "12.5", without the sign of multiplication
std::string occupancy_text(double occupancy);  // "15 %"; "–" for 0, where the scenario's own camera looks

}  // namespace crowdbench::reports
