// How far apart two samples are, or how far pairs differ, as a median of differences with an interval: the estimate
// that belongs to a rank test. Pure functions.
#pragma once
#include <cstddef>
#include <span>

#include "core/statistics.h"

namespace crowdbench {

struct Shift {
  double estimate = 0;
  Interval interval;
  double achieved = 0;  // the interval's confidence: at least what was asked for, less only where the samples are so
                        // small that even their extremes do not carry it
};

// Hodges and Lehmann's shift of x against y: the median of all differences x - y, the interval between two of them in
// order, chosen by the law of Mann and Whitney's U without ties (with ties it covers more): exact for up to about 65
// values of each, then normal. Holds all differences in memory: x.size() * y.size() at most some ten millions. Both: at
// least one value, all finite.
Shift hodges_lehmann(std::span<const double> x, std::span<const double> y, double confidence = 0.95);

// The same of paired differences: the median of the means of every two of them, each with itself too (Walsh averages).
Shift hodges_lehmann(std::span<const double> differences, double confidence = 0.95);

}  // namespace crowdbench
