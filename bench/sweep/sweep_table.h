// What a sweep ends in: Markdown tables of its axes against its measures.
//
// Measures, of a point: time_ms (the headline's), frame_ms, cpu_ms, gpu_ms; speed (times as fast as the reference, with
// its 95 % interval); aa (the same of the reference's A/A twin, in the row of the reference); occupancy; triangles;
// texture_mb, buffer_mb; bake_s; every score by its name. agents_at_ms needs `at`: how many agents are drawn in so many
// milliseconds, between the points of the axis crowd.agents along a power law.
//
// Numbers of an axis are written as short as tells them apart (core/short_numbers.h); the store has all digits.
//
// Where several points fall into one cell (repetitions, axes that are neither rows nor columns), it holds their median
// and how many they are; one value where all are equal.
#pragma once
#include <string>
#include <vector>

#include "bench/sweep/plan.h"
#include "store/store.h"

namespace crowdbench::bench::sweep {

// Throws Error naming the table's line: an axis or measure that there is not, with the nearest.
void check_table(const TableRequest& request, const std::vector<std::string>& axes, const Measures& measures);

// One table, with its title.
std::string table_text(const TableRequest& request, const Plan& plan, const StoreContents& contents);
// All that the plan asks for; where it asks for none, one row a point with all axes and measures. What to look for goes
// first; at the end, where speeds have no level of detail beside them, that, the A/A pairs and what was not done.
std::string sweep_text(const Plan& plan, const StoreContents& contents);

}  // namespace crowdbench::bench::sweep
