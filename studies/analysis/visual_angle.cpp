// Based on: propagation of errors to first order, of logarithms.
#include "studies/analysis/visual_angle.h"

#include <cmath>

#include "core/probability.h"

namespace crowdbench::studies {

std::optional<AngleThreshold> threshold_in_degrees(double pixels, std::optional<double> low, std::optional<double> high,
                                                   std::span<const Calibration> calibrations, double confidence) {
  if (calibrations.empty() || !(pixels > 0)) return std::nullopt;
  double sum = 0;
  double squares = 0;
  for (const Calibration& c : calibrations) {
    const double degrees_per_pixel = 1 / c.pixels_per_degree;
    const double error = c.standard_error * degrees_per_pixel * degrees_per_pixel;
    sum += degrees_per_pixel;
    squares += error * error;
  }
  AngleThreshold out;
  out.calibrated = calibrations.size();
  out.degrees = pixels * sum / static_cast<double>(calibrations.size());
  out.calibration_share = std::sqrt(squares) / sum;
  const double z = normal_quantile(1 - (1 - confidence) / 2);
  const auto half_width = [&](double ratio) { return std::hypot(std::log(ratio), z * out.calibration_share); };
  if (low && *low > 0) out.low = out.degrees * std::exp(-half_width(pixels / *low));
  if (high && *high > 0) out.high = out.degrees * std::exp(half_width(*high / pixels));
  return out;
}

}  // namespace crowdbench::studies
