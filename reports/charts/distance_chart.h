// A score of many agents against how far away they are, as a Vega-Lite specification (JSON text) with its data inside.
#pragma once
#include <string>

#include "reports/model/distance_series.h"

namespace crowdbench::reports {

// A line of medians a representation with its band, the agents as points behind it, thresholds dashed; near is on the
// left whatever is on the axis. Infinite values are gaps. Empty text where no median is finite.
std::string distance_chart(const ScoreDoc& doc, const DistanceGraph& graph);

}  // namespace crowdbench::reports
