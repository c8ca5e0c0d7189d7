#include "scene/character/take_apart.h"

#include <cmath>

namespace crowdbench::scene {

bool take_apart(Node& node) {
  if (!node.has_matrix) return true;
  glm::dmat3 axes(node.matrix);
  glm::dvec3 scale(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]));
  if (glm::determinant(axes) < 0) scale.x = -scale.x;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(scale[i]) < 1e-12) return false;
    axes[i] /= scale[i];
  }
  for (int i = 0; i < 3; ++i)
    if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > 1e-4) return false;
  node.translation = glm::dvec3(node.matrix[3]);
  node.rotation = glm::normalize(glm::quat_cast(axes));
  node.scale = scale;
  node.has_matrix = false;
  node.matrix = glm::dmat4(1.0);
  return true;
}

}  // namespace crowdbench::scene
