// How far two surfaces are apart.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace crowdbench::scene {

struct Surface {
  std::span<const glm::vec3> positions;
  std::span<const uint32_t> indices;  // triangles
};

struct SurfaceDistance {
  double max = 0;  // the largest of all samples', either way: the Hausdorff distance as sampled
  double rms = 0;  // over all samples of both surfaces
};

// From `samples` places on each of the two surfaces, evenly by area and the same every time, and from the corners of
// their triangles, to the nearest place on the other. In the unit of the positions. 0 where a surface has no triangles.
SurfaceDistance surface_distance(const Surface& a, const Surface& b, size_t samples);

}  // namespace crowdbench::scene
