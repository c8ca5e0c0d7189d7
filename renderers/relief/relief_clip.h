// Triangles cut to what a box, a part of one or a texel's column holds of them.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderers/relief/relief_pieces.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

// What lies farther outside the box, in its own units, is another part's; nearer, it is rounding.
inline constexpr double kOutside = 1e-9;

// A triangle that a piece carries wholly.
Skirt whole(uint32_t triangle);

// The part of a triangle between two corners of a box: its own corners; at most ten.
struct Polygon {
  std::array<glm::dvec3, 10> corners;
  size_t count = 0;
};
// What a skirt takes of its triangle p.
Polygon taken(const std::array<glm::dvec3, 3>& p, const Skirt& skirt);
Polygon clipped(Polygon polygon, const glm::dvec3& low, const glm::dvec3& high);

std::array<glm::dvec3, 3> corners_of(const scene::Mesh& mesh, uint32_t triangle,
                                     const std::vector<glm::dvec3>& positions, const glm::dmat4& matrix);

}  // namespace crowdbench::renderers
