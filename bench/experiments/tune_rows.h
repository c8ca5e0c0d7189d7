// The rows of the result store that `tune` becomes: no OpenGL, no clock.
#pragma once
#include <cstdint>

#include "bench/experiments/tune_report.h"
#include "store/store.h"

namespace crowdbench::bench {

// A comparison of kind "agent" for every candidate but the reference, height and view that was scored; the rule for all
// characters, and where there are several the rule of each by itself. All of run `run`.
StoreContents tune_rows(const TuneReport& report, int64_t run = 0);

// Adds such rows to a file, in one transaction. Throws Error.
void write_tune_rows(StoreWriter& store, const StoreContents& rows);

}  // namespace crowdbench::bench
