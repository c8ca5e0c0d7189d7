// How far two surfaces are apart.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>

namespace crowdbench::scene {

struct Surface {
  std::span<const glm::vec3> positions;
  std::span<const uint32_t> indices;  // triangles
};

// Where a surface is looked at.
struct SurfacePlaces {
  size_t by_area = 2000;  // evenly over its triangles
  // And the corners of its triangles: so many at most. Where there are more, every second, third, ... of them; which,
  // `turn` says: as many turns as that, and each has been looked at.
  size_t most_corners = std::numeric_limits<size_t>::max();
  size_t turn = 0;
};

// Both ways: from places on each surface to the nearest place of the other.
struct SurfaceDistance {
  double max = 0;     // the largest, over places by area and corners: the Hausdorff distance as sampled
  double rms = 0;     // over places by area, the two ways counting alike
  size_t places = 0;  // from which a distance was measured, corners among them
};

// In the unit of the positions; the same every time. 0 where a surface has no triangles.
SurfaceDistance surface_distance(const Surface& a, const Surface& b, const SurfacePlaces& places = {});

}  // namespace crowdbench::scene
