// What a report's reader asks first: which representation from which distance on, at what cost, how sure.
#pragma once
#include <string>
#include <vector>

#include "reports/model/scene.h"
#include "reports/model/score_doc.h"

namespace crowdbench::reports {

struct LeadRow {
  std::string character;
  std::string representation;
  std::string score;  // "SSIM 0.9"
  std::string from;   // with its interval
  std::string cost;   // "0.42 of mesh's time (0.40 to 0.44), 1,000 agents"; "not timed in this file"
};
struct Lead {
  std::vector<LeadRow> rows;  // from tuned rules, then from the thresholds of curves against distance
  std::string silent;         // where there are none: what the file lacks, and which command adds it
  std::string basis;          // what the rows are read from
};
// scenes: scenes_of(contents).
Lead lead_of(const StoreContents& contents, const std::vector<Scene>& scenes, const std::vector<ScoreDoc>& docs);

}  // namespace crowdbench::reports
