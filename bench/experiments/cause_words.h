// What dominates an error by cause, by height in pixels: said only where it is clear over agents or views.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "metrics/causes.h"

namespace crowdbench::bench {

// One figure in one picture.
struct CauseUnit {
  double height_px = 0;
  uint64_t unit = 0;  // what is drawn anew as a whole: an agent through all frames, or a view
  metrics::CauseRow row;
};

inline constexpr size_t kLeastCauseUnits = 5;  // fewer say nothing about others

// The figures of heights from `from` up to `below`, pixels.
struct CauseRange {
  double from = 0, below = 0;
  double least = 0, most = 0;  // heights that there are
  size_t units = 0;
  int64_t total = 0;
  std::array<double, metrics::kCauses> shares{};  // of the total; 0 where that is 0
  double residue = 0;
  // The cause of the largest sum, and of the second largest.
  std::optional<metrics::Cause> first, second;
  // The first, where it has the largest sum in 95 % of the sets of units that are drawn with replacement; and the
  // interval that 95 % of its shares lie in.
  std::optional<metrics::Cause> dominant;
  Interval share;
};

// By ascending height; bounds at 15, 30, 60, 120, 240 and 480 pixels. Neighbours that are dominated by the same cause
// are one range. Ranges without a figure are left out.
std::vector<CauseRange> causes_by_height(std::span<const CauseUnit> units, uint64_t seed);

// "below 60 pixels: the stored view (62 % of the squared error, 95 % interval 55 to 70 %); from 60 pixels on: not
// distinguishable (the silhouette or the stored view)". unit: "view" or "agent".
// The same of the range at `i` alone.
std::string cause_range_words(std::span<const CauseRange> ranges, size_t i, const std::string& unit);
std::string cause_words(std::span<const CauseRange> ranges, const std::string& unit);

}  // namespace crowdbench::bench
