// What every chart begins with, so that all of a page look alike.
#pragma once
#include <nlohmann/json_fwd.hpp>

namespace crowdbench::reports {

// Of the page's width, `height` pixels high: colours of axes and grid, sizes of text, place of the legend.
nlohmann::ordered_json chart_frame(int height);

inline constexpr const char* kChartInk = "#1f2933";

}  // namespace crowdbench::reports
