// What `bench` measured as a table for a terminal.
#pragma once
#include <string>

#include "store/store.h"

namespace crowdbench::bench {

// The latest rows of this run's scenario, curve by curve.
std::string bench_table(const StoreContents& contents, const RunRow& run);

}  // namespace crowdbench::bench
