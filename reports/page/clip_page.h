// The page of two clips: every score against time, what the whole scores, the worst frame of each score with its map.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/model/clip_series.h"

namespace crowdbench::reports {

struct ClipPage {
  std::string reference, test;  // what was compared, as the user named it
  size_t frames = 0;
  size_t equal = 0;  // of them, frames of which both pictures are the same
  double fps = 0;    // 0: not known; time is then in frames
  int width = 0, height = 0;
  std::string display;             // where it is looked at, for people
  std::vector<ClipSeries> scores;  // in the order in which people read them
};

// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string clip_page(const ClipPage& page);

}  // namespace crowdbench::reports
