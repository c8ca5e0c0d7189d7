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

}  // namespace crowdbench::reports
