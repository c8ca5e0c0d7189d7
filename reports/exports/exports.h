// The result file in other tools' forms.
#pragma once
#include <string>

#include "store/store.h"

namespace crowdbench::reports {

// The report's tables in Markdown, without charts and pictures. Throws Error when the file holds no measurement.
std::string report_markdown(const StoreContents& contents, const std::string& source);

// RFC 4180, one row a measurement with its provenance, a header of column names that carry the units; an absent value
// is an empty field. Lines end in CR LF.
std::string results_csv(const StoreContents& contents);

// The same as JSON: {"runs": [...], "measurements": [...], "ratios": [...], "comparisons": [...]}, null where absent,
// the string "inf" for infinity. Samples are included where they were read.
std::string results_json(const StoreContents& contents);

// Google Benchmark's JSON (context, benchmarks), which its compare.py and the usual trackers read: one "iteration"
// entry a timed frame (real_time = wall, cpu_time = process CPU, nanoseconds), then aggregates (mean, median, stddev
// and the 5th, 95th and 99th percentile), counters beside them. A point without a time has error_occurred and its
// message. Rows of several runs keep their place: names are "crowd/representation:R/agents:N/occupancy:F/WxH". Read
// with samples.
std::string google_benchmark_json(const StoreContents& contents);

}  // namespace crowdbench::reports
