// What a sweep will take, before it is begun.
#pragma once
#include <cstdint>
#include <string>

#include "bench/sweep/sweep_run.h"

namespace crowdbench::bench::sweep {

struct Estimate {
  size_t conditions = 0, repetitions = 1, points = 0;  // of the shard
  size_t held = 0;                                     // conditions and repetitions that the file has already
  double seconds = 0;                                  // for the rest
  bool measured = false;  // from conditions that the file holds; else the most that the plan allows, roughly
  uint64_t bytes = 0;     // of the whole file, roughly
};
// Looks at `out` and what was begun of it, where they are there. Throws Error.
Estimate estimate(const Plan& plan, const Shard& shard, const std::filesystem::path& out);

// Every point of the shard, a line each: "condition 3: crowd.agents = 10, representation = flat", then the estimate.
std::string dry_run_text(const Plan& plan, const Shard& shard, const Estimate& estimate);

}  // namespace crowdbench::bench::sweep
