// The section of the report that sets several result files beside each other.
#pragma once
#include "reports/model/side_by_side.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

// Empty where there is one file. last_chart: the number of the page's last chart, counted up by each new one.
Html side_section(const SideBySide& sides, int& last_chart);

}  // namespace crowdbench::reports
