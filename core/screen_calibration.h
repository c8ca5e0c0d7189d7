// Which calibration of a participant's screen can be one: whoever finds, keeps or reads one holds it to these bounds
// (studies/page/screen.js has them as numbers of its own, which a test compares).
#pragma once

namespace crowdbench {

// CSS pixels by degree of visual angle: 5 is a monitor of 96 pixels by inch at 8 cm, 500 the same at 7.6 m.
inline constexpr double kLeastPixelsPerDegree = 5;
inline constexpr double kMostPixelsPerDegree = 500;

// standard_error: of pixels_per_degree, in the same unit; 0: known exactly. False of what is not a number.
constexpr bool is_screen_calibration(double pixels_per_degree, double standard_error) {
  return pixels_per_degree >= kLeastPixelsPerDegree && pixels_per_degree <= kMostPixelsPerDegree &&
         standard_error >= 0 && standard_error <= pixels_per_degree;
}

}  // namespace crowdbench
