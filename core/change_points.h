// Where the level of a series changed for good: change points of a benchmark's history. Pure functions.
//
// Based on: D. S. Matteson and N. A. James, "A nonparametric approach for multiple change point analysis of
// multivariate data", Journal of the American Statistical Association 109 (2014): divergence Q of two neighbouring
// segments, here with exponent 1 of the distance; and the published behaviour of Apache Otava, which tests each split
// by Student's t instead of by permutations (no random numbers, so no run differs from the last), looks through
// overlapping windows and then merges what is weak. "Weak" points are those before merging. Differs from Otava: when a
// point is removed, both of its neighbours are judged anew. Otava leaves the left one with figures of segments that no
// longer exist, so that it may report a change below its own least magnitude. As in Otava, deviations inside the t test
// divide by n, not n - 1, which makes p of very short segments too small: keep the least p at 0.001 and a least
// magnitude.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace crowdbench {

struct ChangePoint {
  size_t index = 0;  // the first value of the new level
  double p = 1;      // two-sided, of the segments between neighbouring points; 1 where neither level nor noise differs
  double magnitude = 0;  // max(|after / before - 1|, |before / after - 1|); a division by 0 counts as 0
  double mean_before = 0, mean_after = 0;
};

struct ChangePointOptions {
  size_t window = 50;  // values looked at together, at least 2; the next window begins half a window later
  double max_p = 0.001;
  double min_magnitude = 0;  // changes up to this are removed
};

// By ascending index. values: any number, all finite. Time grows with window^2 for each of the windows.
std::vector<ChangePoint> weak_change_points(std::span<const double> values, const ChangePointOptions& options);
std::vector<ChangePoint> change_points(std::span<const double> values, const ChangePointOptions& options);

}  // namespace crowdbench
