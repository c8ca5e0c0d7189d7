// Intervals of a median that keep their coverage where successive values are alike: frame times drift, throttle and
// come in bursts. Pure functions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/statistics.h"

namespace crowdbench {

// The correlation of each value's rank with the next one's, in [-1, 1], its bias of small samples corrected; 0 for
// fewer than four values or equal ones. values: in the order in which they were measured.
double serial_correlation(std::span<const double> values);

// How many successive values are drawn together: 1 where the serial correlation is not above what independent values
// of this number show one time in five, at most a third of the values.
size_t block_length(std::span<const double> values);

// The circular block bootstrap's interval of the median: blocks of block_length(values) successive values (those of
// successive rounds) are drawn with replacement. Where blocks are longer than 1 the percentile interval is widened
// about the median by what is known to be lacking: sqrt(n / (n - b)), as blocks of b see less than the whole variance,
// and Student's t with n / b - 1 degrees of freedom over the normal quantile, as no more than n / b values are
// independent; it ends where the values do. With blocks of 1 it is bootstrap_median(). values: at least one, in the
// order measured. A function of its arguments.
Interval block_bootstrap_median(std::span<const double> values, uint64_t seed, double confidence = 0.95,
                                size_t resamples = kBootstrapResamples);

// The variance of a mean of these values over that of as many independent ones, (1 + r) / (1 - r) of a first-order
// autoregression; 1 where the serial correlation r is not above what independent values of this number show one time in
// twenty: a test that took more for correlation would come short of its level where there is none.
double serial_inflation(std::span<const double> values);
// A one-sided p value of a rank test, whose law asks for independent values, where the variance is that many times
// larger: the normal deviate that it stands for is divided by the root of it. p in [0, 1]; inflation at least 1.
double inflated_p(double p, double inflation);

}  // namespace crowdbench
