// The rows that a measured point becomes, from what was measured: no OpenGL, no clock.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/stage/stage_facts.h"
#include "bench/timing/timing.h"
#include "store/store.h"

namespace crowdbench::bench {

// Fills in what is known of the stage: the occupancy as achieved and who is on screen.
void put_stage(MeasurementRow& row, const StageFacts& facts);

// The ratios of one representation in every metric that all its times have, in the order cpu, wall, gpu:
//   "speed": t(reference) / t(of), above 1 `of` is the faster; with `reference_times`
//   "floor": t(of) / t(its floor); with `floor_times`
// null, dropped, or without a round in common: no such row. times: not dropped.
std::vector<RatioRow> ratio_rows(int64_t run, const PointKey& of, const VariantTimes& times,
                                 const std::string& reference, const VariantTimes* reference_times,
                                 const VariantTimes* floor_times);

}  // namespace crowdbench::bench
