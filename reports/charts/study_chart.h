// Charts of what people answered: shares by condition, psychometric curves, items on one scale, scores.
#pragma once
#include <string>

#include "reports/model/study_model.h"

namespace crowdbench::reports {

// Each is a Vega-Lite specification as JSON text; empty where there is nothing to draw.
std::string study_shares_chart(const StudyTask& task);
std::string study_curves_chart(const StudyTask& task);
// A point with its interval for every row, the highest first. axis: what the value is.
std::string study_rows_chart(const std::vector<StudyPoint>& rows, const std::string& axis);

}  // namespace crowdbench::reports
