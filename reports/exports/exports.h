// The result file in other tools' forms. What they hold is the description of the columns (store/columns.h) walked: a
// new column is in all of them.
#pragma once
#include <string>
#include <vector>

#include "reports/model/score_doc.h"
#include "store/store.h"

namespace crowdbench::reports {

// The report's tables in Markdown, without charts and pictures; then every score, every column of the largest crowds,
// and of the run. Throws Error when the file holds neither measurement nor tuned rule. Contents of several files
// (store/joined.h) begin with what they have in common.
// scores: what is known of scores, in the order in which they are shown.
std::string report_markdown(const StoreContents& contents, const std::string& source,
                            const std::vector<ScoreDoc>& scores = {});

// RFC 4180, one row a measurement with its provenance, a header of column names that carry the units; an absent value
// is an empty field. Lines end in CR LF.
std::string results_csv(const StoreContents& contents);

// The same of scores: one row a score (name, value, reason) with its comparison and provenance.
std::string scores_csv(const StoreContents& contents);

// All tables but the pictures as JSON: {"runs": [...], "measurements": [...], "ratios": [...], "comparisons": [...],
// "scores": [...]}, null where absent, the string "inf" for infinity. Samples are included where they were read. docs:
// becomes "scores", what each name means; none: no such list.
std::string results_json(const StoreContents& contents, const std::vector<ScoreDoc>& docs = {});

// Google Benchmark's JSON (context, benchmarks), which its compare.py and the usual trackers read: one "iteration"
// entry a timed frame (real_time = wall, cpu_time = process CPU, nanoseconds), then aggregates (mean, median, stddev
// and the 5th, 95th and 99th percentile), counters beside them. A point without a time has error_occurred and its
// message. The context holds what the machine said, and nothing where it said nothing. Rows of several runs keep their
// place: names are "crowd/representation:R/agents:N/occupancy:F/WxH". Read with samples.
std::string google_benchmark_json(const StoreContents& contents);

}  // namespace crowdbench::reports
