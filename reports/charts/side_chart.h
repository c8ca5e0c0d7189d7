// The same points of several result files in one chart, as a Vega-Lite specification.
#pragma once
#include <string>

#include "reports/model/side_by_side.h"

namespace crowdbench::reports {

// How many times as fast as the reference of the same rounds a representation is, against agents, log-log, one line a
// file with the band of the ratio's interval. occupancy: of the rows that are drawn. Empty text without any.
std::string side_chart(const SideBySide& sides, const SideGroup& group, const std::string& representation,
                       double occupancy);

}  // namespace crowdbench::reports
