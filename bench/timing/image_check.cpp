#include "bench/timing/image_check.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "bench/stage/coverage.h"

namespace crowdbench::bench {

ImageCheck check_pictures(const renderers::Capture& first, const renderers::Capture& second, bool floor,
                          const std::optional<ImageCheck>& reference) {
  ImageCheck check;
  check.covered_px = coverage_of(first.ids).covered_px;
  for (size_t i = 0; i < first.colour.pixels(); ++i)
    if (std::memcmp(first.colour.data.data() + 4 * i, second.colour.data.data() + 4 * i, 3) != 0) ++check.moved_px;
  if (check.covered_px == 0) {
    check.fault = "nothing was drawn";
    return check;
  }
  if (floor) return check;
  if (reference) {
    const auto wanted = static_cast<double>(reference->covered_px);
    const double off = (static_cast<double>(check.covered_px) - wanted) / wanted;
    if (std::abs(off) > kCoverageBound)
      check.fault = fmt::format("covers {} pixels where the reference covers {} ({:+.1f} %, allowed are {:.0f} %)",
                                check.covered_px, reference->covered_px, 100 * off, 100 * kCoverageBound);
  }
  if (check.fault.empty() && check.moved_px == 0) check.fault = "two ticks look the same: the crowd does not move";
  return check;
}

}  // namespace crowdbench::bench
