#include "reports/exports/point_path.h"

#include <fmt/format.h>

namespace crowdbench::reports {

std::string point_path(const PointKey& key) {
  return fmt::format("crowd/representation:{}/character:{}/agents:{}/occupancy:{}/{}x{}", key.representation,
                     key.character, key.agents, key.requested_occupancy, key.width, key.height);
}

}  // namespace crowdbench::reports
