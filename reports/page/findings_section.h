// The sections of the report that tell of causes and of switches. Empty where the run has none.
#pragma once
#include <vector>

#include "reports/model/score_doc.h"
#include "reports/page/html_template.h"
#include "store/rows.h"

namespace crowdbench::reports {

// What dominates and how switches look, of all runs, in words.
Html findings_section(const StoreContents& contents, const std::vector<ScoreDoc>& pop_scores);
Html causes_section(const StoreContents& contents, int64_t run);
Html pops_section(const StoreContents& contents, const RunRow& run, const std::vector<ScoreDoc>& pop_scores);

}  // namespace crowdbench::reports
