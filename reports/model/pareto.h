// The representations of one condition that no other beats in time, bytes and error together. Pure functions.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

struct ParetoEntry {
  std::string representation;
  // Its time over the reference's, from the paired ratios; 1 without width for the reference.
  double time = 1, low = 1, high = 1;
  std::optional<uint64_t> bytes;  // of textures and buffers on the GPU
  std::optional<double> error;    // the score's value
  // One that is faster by intervals that do not meet, and in bytes and error no worse. Empty: on the front, as far as
  // the intervals tell.
  std::string beaten_by;
};
struct ParetoFront {
  uint32_t agents = 0;
  double occupancy = 0;
  ScoreDoc score;           // of `error`; without a name where nothing was scored
  std::string scored_over;  // "single agents 64 pixels tall, mean of 12 views"; "the crowd"
  std::vector<ParetoEntry> entries;
};
// Of each occupancy at the largest of the crowds that most were timed with, two at least.
std::vector<ParetoFront> pareto_fronts(const Scene& scene);

}  // namespace crowdbench::reports
