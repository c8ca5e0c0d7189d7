// The rows of the result store that `distance` becomes: no OpenGL, no clock.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/experiments/distance.h"
#include "store/store.h"

namespace crowdbench::bench {

// What is compared, as rows call it.
struct DistanceScene {
  std::string cast;
  uint32_t agents = 0;
  double requested_occupancy = 0;  // 0: the scenario's own camera
  uint64_t seed = 1;               // of what is drawn anew for intervals
};

// A comparison an agent, frame and representation; curves with their bins; thresholds; causes where they were asked
// for. All of run `run`; curves are numbered from 1, and thresholds name them so.
StoreContents distance_rows(const DistanceScene& scene, const DistanceRequest& request, const DistanceResult& result,
                            const std::vector<DistanceCurve>& curves, int64_t run = 0);

// Adds such rows to a file, in one transaction. Throws Error.
void write_distance_rows(StoreWriter& store, const StoreContents& rows);

}  // namespace crowdbench::bench
