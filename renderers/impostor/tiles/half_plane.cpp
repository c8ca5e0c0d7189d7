#include "renderers/impostor/tiles/half_plane.h"

namespace crowdbench::renderers {

std::vector<glm::dvec2> cut_by_half_plane(const std::vector<glm::dvec2>& polygon, const glm::dvec2& outward,
                                          double reach) {
  std::vector<glm::dvec2> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2& a = polygon[i];
    const glm::dvec2& b = polygon[(i + 1) % polygon.size()];
    const double da = glm::dot(a, outward) - reach;
    const double db = glm::dot(b, outward) - reach;
    if (da <= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) kept.push_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

}  // namespace crowdbench::renderers
