// A score of a sequence of frames, as its page and its chart show it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/score_doc.h"

namespace crowdbench::reports {

struct ClipPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> png;  // empty: no picture
};

struct ClipSeries {
  ScoreDoc doc;
  std::optional<double> whole;                  // of the whole sequence; nothing: `reason` says why
  std::string pooling;                          // "mean over frames"
  std::string conditions;                       // "67.0206 pixels/degree"; may be empty
  std::string reason;                           //
  std::vector<std::optional<double>> by_frame;  // empty where the score is over time alone
  std::optional<size_t> worst_frame;            //
  ClipPicture map;                              // of the worst frame
};

}  // namespace crowdbench::reports
