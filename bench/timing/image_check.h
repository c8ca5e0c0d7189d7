// The check that a timed representation did draw the crowd, and that the crowd moved.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "renderers/frame/capture.h"

namespace crowdbench::bench {

// Half a second of a walk lies between tick 0 and this one, the second of a check.
inline constexpr uint64_t kSecondTick = 15;

// Two pictures of one representation at two ticks, held against the reference's at the first.
struct ImageCheck {
  uint64_t covered_px = 0;  // pixels with an agent id, first tick
  uint64_t moved_px = 0;    // pixels whose colour differs between the ticks
  std::string fault;        // empty: passed
};
// A floor is allowed to cover more and to stand still: that is its work removed. All others must cover the
// reference's number of pixels within this fraction of it (what impostors lose or add at their outlines stays far
// below; a crowd that vanished into its mipmaps or a wrong camera does not), and must move where the reference moves.
inline constexpr double kCoverageBound = 0.15;
ImageCheck check_pictures(const renderers::Capture& first, const renderers::Capture& second, bool floor,
                          const std::optional<ImageCheck>& reference);

}  // namespace crowdbench::bench
