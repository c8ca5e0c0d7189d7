// Every timed frame as a line, under the column names of PresentMon where these mean the same.
#pragma once
#include <string>

#include "store/store.h"

namespace crowdbench::reports {

// RFC 4180, lines end in CR LF, an absent value is an empty field. Columns of PresentMon's: Application (the point,
// point_path()), MsBetweenPresents (wall time of the frame: frames of one representation are drawn one after the other
// and nothing is presented, so that it is what lies between two finished frames), MsCPUBusy (CPU time of the drawing
// thread), MsGPUTime. Ours: Run, Round, Tick, MsProcessCPU (CPU time of all threads), Agents, OccupiedPx. No column of
// frames a second: an average rate is 1000 / mean(MsBetweenPresents), a percentile is of the times, and a "1 % low" is
// 1000 / the mean of the slowest 1 %. contents: read with samples.
std::string frame_log_csv(const StoreContents& contents);

}  // namespace crowdbench::reports
