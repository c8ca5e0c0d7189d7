// How tall a character stands, found from its posed vertices.
#pragma once
#include <algorithm>
#include <limits>

#include "scene/pose/pose.h"

namespace crowdbench::scene::test {

// Metres, of a clip's first pose.
inline double posed_height(const Character& c, int clip) {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (const glm::dvec3& p : skin_positions(c.mesh, model_matrices(c, clip, 0.0))) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  return high - low;
}

}  // namespace crowdbench::scene::test
