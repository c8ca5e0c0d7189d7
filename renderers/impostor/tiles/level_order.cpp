#include "renderers/impostor/tiles/level_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "scene/frame/camera.h"

namespace crowdbench::renderers {
namespace {

// A level is drawn where its texels are at most this many pixels; coarser ones would blur, finer ones alias.
constexpr double kPixelsPerTexel = std::numbers::sqrt2;

}  // namespace

void LevelOrder::sort(const scene::Frame& frame, const std::vector<scene::FrameAgent>& all,
                      std::span<const uint32_t> chosen, const glm::vec3& centre, double texel, int levels) {
  const glm::vec3 forward = -glm::vec3(glm::transpose(scene::view_rotation(frame.camera))[2]);
  // Pixels a metre at depth 1, times the texel: texel pixels = this * scale / depth.
  const auto pixels = static_cast<float>(texel * frame.height / (2 * std::tan(frame.camera.fov_y / 2)));
  constexpr uint32_t kBuckets = 2048;
  constexpr uint32_t kShift = 17;  // keeps the exponent and six bits of the mantissa
  constexpr uint32_t kLowest = std::bit_cast<uint32_t>(0x1p-10F) >> kShift;
  counts_.assign(static_cast<size_t>(levels) * kBuckets + 1, 0);
  keys_.resize(chosen.size());
  for (size_t i = 0; i < chosen.size(); ++i) {
    const scene::FrameAgent& a = all[chosen[i]];
    const glm::vec3 middle = a.position + a.scale * glm::vec3(a.heading.y * centre.x + a.heading.x * centre.z, centre.y,
                                                              a.heading.y * centre.z - a.heading.x * centre.x);
    const float depth = std::max(glm::dot(middle, forward), 0x1p-10F);
    const float coarser = static_cast<float>(kPixelsPerTexel) * depth / (pixels * a.scale);
    const int level = static_cast<int>(std::bit_cast<uint32_t>(coarser) >> 23) - 127;  // floor(log2)
    const auto l = static_cast<uint32_t>(std::clamp(level, 0, levels - 1));
    const uint32_t bucket = std::min((std::bit_cast<uint32_t>(depth) >> kShift) - kLowest, kBuckets - 1);
    keys_[i] = l * kBuckets + bucket;
    ++counts_[keys_[i] + 1];
  }
  for (size_t k = 1; k < counts_.size(); ++k) counts_[k] += counts_[k - 1];
  first_.resize(static_cast<size_t>(levels) + 1);
  for (size_t l = 0; l < first_.size(); ++l) first_[l] = counts_[l * kBuckets];
  sorted_.resize(chosen.size());
  for (size_t i = 0; i < chosen.size(); ++i) sorted_[counts_[keys_[i]]++] = chosen[i];
}

std::span<const uint32_t> LevelOrder::at_level(int level) const {
  const auto l = static_cast<size_t>(level);
  return std::span(sorted_).subspan(first_[l], first_[l + 1] - first_[l]);
}

}  // namespace crowdbench::renderers
