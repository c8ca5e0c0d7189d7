// The page of a pop map: what a switch from the mesh to another representation would show, over views, phases and
// sizes.
#pragma once
#include <string>
#include <vector>

#include "reports/model/pop_model.h"
#include "reports/model/score_doc.h"

namespace crowdbench::reports {

struct PopPage {
  std::string representation, character, clip, renderer, program;  // program: name, version and revision
  bool software = false;                                           // drawn by a software rasteriser
  int fade = 0;                                                    // ticks
  std::vector<ScoreDoc> scores;                                    // of the points and summaries, in their order
  size_t ranking = 0;                                              // into scores: by which the worst is found
  std::vector<PopSize> sizes;
  std::string display;  // where it is looked at, for people
};

// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string pop_page(const PopPage& page);

}  // namespace crowdbench::reports
