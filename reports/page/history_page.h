// The page of many runs: each point's time over the reference's, run after run, with the revisions at which it changed.
#pragma once
#include <string>
#include <vector>

#include "reports/model/history.h"

namespace crowdbench::reports {

// One self-contained HTML page that opens without a network. method: how changes were looked for, a sentence. Throws
// Error when the program was built without the chart library.
std::string history_page(const std::vector<HistorySeries>& all, const std::string& method);

}  // namespace crowdbench::reports
