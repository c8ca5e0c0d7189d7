// What a point took over many runs, and where that changed.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/change_points.h"
#include "store/store.h"

namespace crowdbench::reports {

struct HistoryValue {
  double value = 0;  // time over the reference's of the same rounds (median), so that runs of other days compare
  double low = 0, high = 0;
  std::string revision;
  std::string started;
};
struct HistoryChange {
  ChangePoint point;              // index: of the first value of the new level
  std::string revision, started;  // of that value
  std::string revision_before;    // of the value before it: what changed lies between the two
};
struct HistorySeries {
  std::string scenario;
  PointKey key;
  std::string metric;
  std::vector<HistoryValue> values;  // by time of start
  std::vector<HistoryChange> changes;
};

// One series a scenario, point and device; those with a single value are left out. Runs are put in order by their
// start; equal starts keep the files' order. files: any number, in any order, without samples.
std::vector<HistorySeries> history_of(std::span<const StoreContents> files, const ChangePointOptions& options);

// "flat, mannequin, 250 agents, 15 %, 640 × 480"
std::string series_name(const HistorySeries& series);

}  // namespace crowdbench::reports
