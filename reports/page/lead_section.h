// The section that a report begins with.
#pragma once
#include "reports/model/lead.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

Html lead_section(const Lead& lead);

}  // namespace crowdbench::reports
