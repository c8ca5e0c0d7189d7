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
// A condition in Vega's expressions: of a phone, where names beside lines do not fit.
inline constexpr const char* kNarrowScreen = "windowSize()[0] < 600";
// About what a name takes beside a line, pixels.
double name_px(const std::string& name);

}  // namespace crowdbench::reports
