// A point's time over the reference's, run after run, as a Vega-Lite specification (JSON text) with its data inside.
#pragma once
#include <string>

#include "reports/model/history.h"

namespace crowdbench::reports {

// A point a run with its 95 % interval, the level between changes as a line, a rule with the revision at each change.
std::string history_chart(const HistorySeries& series);

}  // namespace crowdbench::reports
