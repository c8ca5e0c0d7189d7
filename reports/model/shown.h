// How much of a scene of very many points a page shows at once: the rest is folded, or told by fewer points.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// The crowds that curves are drawn through: all, or kMostOnACurve of them from end to end.
std::vector<uint32_t> shown_agents(const Scene& scene);
inline constexpr size_t kMostOnACurve = 40;
// Tables of more rows are folded.
inline constexpr size_t kMostRowsOpen = 200;

}  // namespace crowdbench::reports
