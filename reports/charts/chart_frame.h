// What every chart begins with, so that all of a page look alike.
#pragma once
#include <string>
#include <vector>

#include "core/json.h"

namespace crowdbench::reports {

// Colours of axes and grid, sizes of text, place of the legend; what is drawn has sizes of its own.
Json chart_frame();
// The same of the page's width, `height` pixels high.
Json chart_frame(int height);

inline constexpr const char* kChartInk = "#1f2933";
// A condition in Vega's expressions: of a phone, where neither names beside lines nor a row of a legend fit.
inline constexpr const char* kNarrowScreen = "windowSize()[0] < 600";
// About what a name takes in a legend or beside a line, pixels.
double name_px(const std::string& name);
// "columns" of a legend: as many names in a row as a chart of half the page's width holds, on a phone one.
Json legend_columns(const std::vector<std::string>& names);

}  // namespace crowdbench::reports
