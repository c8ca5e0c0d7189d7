#include "reports/model/pop_model.h"

#include <fmt/format.h>

namespace crowdbench::reports {

const std::array<const char*, kPopSwitchKinds> kPopSwitchTitles = {
    "own pose, cut", "own pose, cross-fade step", "stored frame's pose, cut", "stored frame's pose, cross-fade step"};

std::string pop_size_text(const PopPoint& point) {
  return point.ratio > 0 ? fmt::format("{:.3g} px a texel, {:.0f} px tall", point.ratio, point.height_px)
                         : fmt::format("{:.0f} px tall", point.height_px);
}

}  // namespace crowdbench::reports
