// The page of a study's answers: verdicts first, then charts and tables, then what they cannot tell.
#pragma once
#include <string>

#include "reports/model/study_model.h"

namespace crowdbench::reports {

// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string study_page(const StudyPageModel& model);

}  // namespace crowdbench::reports
