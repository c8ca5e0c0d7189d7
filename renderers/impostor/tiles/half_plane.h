// Convex polygons cut by half-planes.
#pragma once
#include <glm/glm.hpp>
#include <vector>

namespace crowdbench::renderers {

// What of a convex polygon lies where dot(p, outward) <= reach, in the same order of corners; empty when nothing does.
// outward need not be of unit length.
std::vector<glm::dvec2> cut_by_half_plane(const std::vector<glm::dvec2>& polygon, const glm::dvec2& outward,
                                          double reach);

}  // namespace crowdbench::renderers
