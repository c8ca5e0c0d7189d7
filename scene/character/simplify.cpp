#include "scene/character/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>

namespace crowdbench::scene {

Character simplified(const Character& character, size_t triangles) {
  Character out = character;
  const Mesh& mesh = character.mesh;
  out.mesh.indices.clear();
  for (Material& material : out.materials) material.double_sided = true;
  const size_t all = std::max<size_t>(1, character.triangles());
  for (Primitive& primitive : out.mesh.primitives) {
    const uint32_t* indices = mesh.indices.data() + primitive.first_index;
    const size_t count = primitive.index_count;
    const size_t share = std::max<size_t>(4, count / 3 * triangles / all) * 3;
    std::vector<uint32_t> kept(count);
    size_t left = count;
    if (share < count) {
      const float* positions = &mesh.positions[0].x;
      left = meshopt_simplify(kept.data(), indices, count, positions, mesh.positions.size(), sizeof(glm::vec3), share,
                              1e9F, 0U, nullptr);
      // Seams and loose pieces hold the careful simplifier up; the other one walks through them.
      if (left > share * 3 / 2)
        left = meshopt_simplifySloppy(kept.data(), indices, count, positions, mesh.positions.size(), sizeof(glm::vec3),
                                      share, 1e9F, nullptr);
    }
    if (share >= count || left == 0) {
      std::copy(indices, indices + count, kept.begin());
      left = count;
    }
    primitive.first_index = static_cast<uint32_t>(out.mesh.indices.size());
    primitive.index_count = static_cast<uint32_t>(left);
    out.mesh.indices.insert(out.mesh.indices.end(), kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(left));
  }
  return out;
}

}  // namespace crowdbench::scene
