// Planes for tiles: where an impostor's polygon lies so that, seen from beside its view, the figure stays where it
// stands.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderers/impostor/views/view_grid.h"

namespace crowdbench::renderers {

// Mean and covariance of a posed surface, by area: front and back alike, so that what is fitted to them runs through
// the middle of the body.
struct SurfaceMoments {
  glm::dvec3 mean{0.0};
  glm::dmat3 covariance{0.0};
};
// positions: of all vertices; indices: triangles.
SurfaceMoments surface_moments(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices);

// The plane over a view's capture plane that lies nearest to the body: the least-squares regression of the height
// towards the eye on x and y. Seen from the view itself it looks as the capture plane does; seen from beside it the
// figure stays where it stands instead of leaning with the plane. Metres; slopes are held within 2.
struct TilePlane {
  double slope_x = 0, slope_y = 0, height = 0;
};
TilePlane fit_plane(const SurfaceMoments& moments, const glm::dvec3& centre, const ViewBasis& basis);

}  // namespace crowdbench::renderers
