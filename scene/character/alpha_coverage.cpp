#include "scene/character/alpha_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace crowdbench::scene {

float alpha_threshold(const Material& material) {
  if (material.alpha_cutoff <= 0) return 0;
  return material.base_colour.a > 0 ? std::min(material.alpha_cutoff / material.base_colour.a, 2.0F) : 2.0F;
}

double alpha_coverage(std::span<const uint8_t> rgba, float threshold) {
  size_t there = 0;
  for (size_t i = 3; i < rgba.size(); i += 4) there += static_cast<float>(rgba[i]) / 255.0F >= threshold ? 1 : 0;
  return static_cast<double>(there) / (0.25 * static_cast<double>(rgba.size()));
}

void scale_alpha_to(std::span<uint8_t> rgba, float threshold, double wanted) {
  const auto lowest = static_cast<int>(std::ceil(threshold * 255.0F));  // code that passes
  if (lowest > 255) return;
  std::array<size_t, 256> histogram{};
  for (size_t i = 3; i < rgba.size(); i += 4) ++histogram[rgba[i]];
  const double target = wanted * 0.25 * static_cast<double>(rgba.size());
  // The code from which on the nearest number of texels lies; code 0 never counts, as no scale lifts it.
  int from = 256;
  double above = 0;
  double nearest = target;
  for (int code = 255; code > 0; --code) {
    above += static_cast<double>(histogram[static_cast<size_t>(code)]);
    if (std::abs(above - target) >= nearest) continue;
    nearest = std::abs(above - target);
    from = code;
  }
  std::array<uint8_t, 256> scaled{};
  const double scale = static_cast<double>(lowest) / from;
  for (int code = 0; code < 256; ++code) {
    const int to = static_cast<int>(std::lround(code * scale));
    // Rounding must not carry a code across the threshold.
    scaled[static_cast<size_t>(code)] =
        static_cast<uint8_t>(code >= from ? std::clamp(to, lowest, 255) : std::clamp(to, 0, std::max(lowest - 1, 0)));
  }
  for (size_t i = 3; i < rgba.size(); i += 4) rgba[i] = scaled[rgba[i]];
}

}  // namespace crowdbench::scene
