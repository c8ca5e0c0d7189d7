#include "renderers/relief/relief_clip.h"

namespace crowdbench::renderers {

Skirt whole(uint32_t triangle) { return {triangle, {}, 1}; }

Polygon taken(const std::array<glm::dvec3, 3>& p, const Skirt& skirt) {
  Polygon polygon;
  const auto add = [&](const glm::dvec3& corner) { polygon.corners[polygon.count++] = corner; };
  for (size_t k = 0; k < 3; ++k) {
    const size_t before = (k + 2) % 3;
    const size_t after = (k + 1) % 3;
    if (skirt.reach >= 1) {
      add(p[k]);
    } else if (skirt.shared[k]) {
      if (!skirt.shared[before]) add(p[k] + skirt.reach * (p[before] - p[k]));
      add(p[k]);
      if (!skirt.shared[after]) add(p[k] + skirt.reach * (p[after] - p[k]));
    }
  }
  return polygon;
}

Polygon clipped(Polygon polygon, const glm::dvec3& low, const glm::dvec3& high) {
  const auto cut = [&](int axis, double sign, double limit) {  // keeps sign * coordinate <= limit
    Polygon kept;
    for (size_t k = 0; k < polygon.count; ++k) {
      const glm::dvec3& a = polygon.corners[k];
      const glm::dvec3& b = polygon.corners[(k + 1) % polygon.count];
      const double da = sign * a[axis] - limit;
      const double db = sign * b[axis] - limit;
      if (da <= 0) kept.corners[kept.count++] = a;
      if ((da < 0 && db > 0) || (da > 0 && db < 0)) kept.corners[kept.count++] = a + (b - a) * (da / (da - db));
    }
    polygon = kept;
  };
  for (int axis = 0; axis < 3; ++axis) {
    cut(axis, -1, -low[axis]);
    cut(axis, 1, high[axis]);
  }
  return polygon;
}

std::array<glm::dvec3, 3> corners_of(const scene::Mesh& mesh, uint32_t triangle,
                                     const std::vector<glm::dvec3>& positions, const glm::dmat4& matrix) {
  std::array<glm::dvec3, 3> p;
  for (uint32_t corner = 0; corner < 3; ++corner)
    p[corner] = glm::dvec3(matrix * glm::dvec4(positions[mesh.indices[3 * triangle + corner]], 1.0));
  return p;
}

}  // namespace crowdbench::renderers
