// The page of `distance`, and the same within a report: every score of the agents of a crowd against how far away they
// are.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "reports/model/distance_series.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

struct DistancePage {
  std::string scene;      // "200 agents of mannequin, 640 x 480 pixels, tick 0"
  std::string reference;  // what others are held against
  std::string counts;     // how many agents count, and why others do not
  std::string display;    // where it is looked at, for people
  std::string renderer;
  std::vector<std::pair<std::string, std::string>> causes;  // by representation: what its error is dominated by
  std::vector<DistanceScore> scores;                        // in the order in which people read them
};

// Charts of the scores and where thresholds are reached. last_chart: the number of the page's last chart, counted up.
Html distance_section(const std::vector<DistanceScore>& scores, int& last_chart);

// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string distance_page(const DistancePage& page);

}  // namespace crowdbench::reports
