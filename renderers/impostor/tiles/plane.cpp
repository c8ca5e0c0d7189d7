#include "renderers/impostor/tiles/plane.h"

#include <algorithm>

namespace crowdbench::renderers {

SurfaceMoments surface_moments(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices) {
  SurfaceMoments moments;
  double area = 0;
  glm::dmat3 second(0.0);
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const glm::dvec3 a(positions[indices[i]]);
    const glm::dvec3 b(positions[indices[i + 1]]);
    const glm::dvec3 c(positions[indices[i + 2]]);
    const double weight = glm::length(glm::cross(b - a, c - a)) / 6;
    // The middles of the edges, a third of the area each, are exact for second moments.
    for (const glm::dvec3& p : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)}) {
      area += weight;
      moments.mean += weight * p;
      second += weight * glm::outerProduct(p, p);
    }
  }
  if (area <= 0) return {};
  moments.mean /= area;
  moments.covariance = second / area - glm::outerProduct(moments.mean, moments.mean);
  return moments;
}

TilePlane fit_plane(const SurfaceMoments& moments, const glm::dvec3& centre, const ViewBasis& basis) {
  const auto spread = [&](const glm::dvec3& u, const glm::dvec3& v) { return glm::dot(u, moments.covariance * v); };
  // A body thin as a line across the view has no slope there: a little is added to what both axes spread over.
  const double thin = 1e-4 * (spread(basis.right, basis.right) + spread(basis.up, basis.up)) + 1e-12;
  const double xx = spread(basis.right, basis.right) + thin;
  const double yy = spread(basis.up, basis.up) + thin;
  const double xy = spread(basis.right, basis.up);
  const double xz = spread(basis.right, basis.to_eye);
  const double yz = spread(basis.up, basis.to_eye);
  const double determinant = xx * yy - xy * xy;
  constexpr double kSteepest = 2;
  TilePlane plane;
  plane.slope_x = std::clamp((xz * yy - yz * xy) / determinant, -kSteepest, kSteepest);
  plane.slope_y = std::clamp((yz * xx - xz * xy) / determinant, -kSteepest, kSteepest);
  const glm::dvec3 mean = moments.mean - centre;
  plane.height = glm::dot(mean, basis.to_eye) - plane.slope_x * glm::dot(mean, basis.right) -
                 plane.slope_y * glm::dot(mean, basis.up);
  return plane;
}

}  // namespace crowdbench::renderers
