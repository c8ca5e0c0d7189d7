// Thresholds that are sizes in pixels of the clip, in degrees of visual angle: what the eye saw, with the error of the
// calibration that says it.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

namespace crowdbench::studies {

// Of one participant: how many pixels of the clip were one degree, and the standard error of that. It holds the error
// of measuring (rounds of the blind spot) and that of the eye, which no number of rounds averages away: the blind spot
// lies 13.5 degrees from fixation, with a standard deviation of 1.1 degrees between people.
struct Calibration {
  double pixels_per_degree = 0;  // above 0
  double standard_error = 0;     // at least 0; 0: known exactly (a chin rest)
};

struct AngleThreshold {
  double degrees = 0;
  std::optional<double> low, high;  // an end that is nothing is open
  double calibration_share = 0;     // standard deviation of the calibration's part, as a share of `degrees`
  size_t calibrated = 0;            // participants
};

// t pixels with the interval low to high, and participants i = 1 ... N of p_i pixels a degree with standard errors s_i:
//
//   degrees   d = t m, with m the mean over participants of 1 / p_i
//   variance  V = sum over i of (s_i / p_i^2)^2 / (sum over i of 1 / p_i)^2, that of ln m to first order
//   interval  exp(ln d - sqrt(ln(t / low)^2 + z^2 V)) to exp(ln d + sqrt(ln(high / t)^2 + z^2 V))
//
// s_i is whole for each participant, whatever they answered, and independent between participants, each having one eye
// of their own: with N alike V is (s / p)^2 / N. Errors of calibration and of answers are independent, so that half
// widths of logarithms add in squares. Not in V: that 13.5 degrees may be wrong for all people alike.
//
// Nothing without calibrations, or where t is not above 0. An end at or below 0 is open. confidence: that of low, high.
std::optional<AngleThreshold> threshold_in_degrees(double pixels, std::optional<double> low, std::optional<double> high,
                                                   std::span<const Calibration> calibrations, double confidence);

}  // namespace crowdbench::studies
