// What `study analyze` prints and writes of an analysis.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/plan_standing.h"

namespace crowdbench::bench {

struct StudyReport {
  studies::Analysis analysis;
  std::optional<studies::PlanStanding> standing;  // with --plan
};

// analysis_json(), with "plan": {"standing", "sentences"}, or null.
Json study_report_json(const StudyReport& report);
std::string study_report_markdown(const StudyReport& report);
std::string study_report_plain(const StudyReport& report);  // for a terminal
// One self-contained page. Throws Error (reports::page_frame).
std::string study_report_page(const StudyReport& report);

}  // namespace crowdbench::bench
