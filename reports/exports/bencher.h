// The result file in Bencher's metric format: a summary by point that trackers of benchmarks take, intervals included.
#pragma once
#include <string>

#include "store/store.h"

namespace crowdbench::reports {

// {"crowd/representation:flat/...": {"cpu-time": {"value": ns, "lower_value": ns, "upper_value": ns},
// "times-as-slow-as-reference": {...}, "score-ssim": {"value": ...}}, ...}: of each point that was timed the latest
// row's times (nanoseconds, median and 95 % interval), its time over the reference's of the same rounds, and the finite
// scores of its crowd.
// Based on: the published JSON schema of the Bencher Metric Format, {benchmark: {measure: {value, lower_value,
// upper_value}}}.
std::string bencher_json(const StoreContents& contents);

}  // namespace crowdbench::reports
