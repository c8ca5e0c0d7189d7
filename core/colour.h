// The sRGB transfer curve (IEC 61966-2-1), for single values; only linear_to_srgb8() clamps its
// value to [0, 1].
#pragma once
#include <cmath>
#include <cstdint>

namespace crowdbench {

inline double srgb_to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
inline double linear_to_srgb(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}
inline uint8_t linear_to_srgb8(double linear) {
  const double encoded = linear_to_srgb(linear < 0 ? 0 : linear > 1 ? 1 : linear);
  return static_cast<uint8_t>(encoded * 255.0 + 0.5);
}

}  // namespace crowdbench
