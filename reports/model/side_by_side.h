// The same points of several result files beside each other: by ratios to the reference of the same rounds, since times
// of different runs are never compared. Pure functions of the store's rows.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

struct SideCell {
  const RatioRow* ratio = nullptr;  // of the file's own metric; nullptr: not timed in this file
  std::string scores;               // the headline scores of the crowd's picture; empty without any
};
struct SideRow {
  std::string representation;
  uint32_t agents = 0;
  double occupancy = 0;
  std::vector<SideCell> cells;  // by file
};
// Scenes of several files that show the same.
struct SideGroup {
  const Scene* scene = nullptr;     // the first of them
  std::vector<SideRow> rows;        // points that at least two files have, by representation, occupancy and agents
  std::vector<std::string> metric;  // by file: "cpu"; empty where the file has none of it
};
struct SideBySide {
  std::vector<std::string> files;  // in the order given
  std::vector<SideGroup> groups;
};
// Without files where the scenes are of one.
SideBySide side_by_side(const std::vector<Scene>& scenes);

// "1.23× (1.10 to 1.30)"; "–" where the file has none.
std::string side_text(const SideCell& cell);

}  // namespace crowdbench::reports
