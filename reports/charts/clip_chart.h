// A score of frames against time, as a Vega-Lite specification (JSON text) with its data inside.
#pragma once
#include <string>

#include "reports/model/clip_series.h"

namespace crowdbench::reports {

// A line with the worst frame marked; values that are infinite or absent are gaps. fps: 0 draws against the frame's
// number. Empty text where no frame has a finite value.
std::string clip_chart(const ClipSeries& series, double fps);

}  // namespace crowdbench::reports
