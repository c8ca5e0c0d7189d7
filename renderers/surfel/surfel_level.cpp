#include "renderers/surfel/surfel_level.h"

#include <algorithm>

namespace crowdbench::renderers {

std::vector<SurfelLevel> surfel_levels(std::span<const float> radius) {
  constexpr size_t kFewest = 64;
  std::vector<SurfelLevel> out;
  for (size_t points = kFewest; points < radius.size(); points *= 2)
    out.push_back({static_cast<uint32_t>(points), static_cast<double>(radius[points - 1])});
  if (!radius.empty()) out.push_back({static_cast<uint32_t>(radius.size()), static_cast<double>(radius.back())});
  return out;
}

size_t surfel_level(std::span<const SurfelLevel> levels, const SurfelRule& rule, double metre, double tall) {
  const double whole = std::clamp((tall * metre - kFewPixels[0]) / (kFewPixels[1] - kFewPixels[0]), 0.0, 1.0);
  const auto found = std::find_if(levels.begin(), levels.end(), [&](const SurfelLevel& level) {
    if (level.uneven > kEven && level.points < kPointsEnough) return false;
    return level.over * whole <= kOver && level.radius * rule.cover * level.closed * metre <= rule.size;
  });
  return found == levels.end() ? levels.size() - 1 : static_cast<size_t>(found - levels.begin());
}

}  // namespace crowdbench::renderers
