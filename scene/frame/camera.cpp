// Based on: the look-at and reversed, infinite projection as textbooks have them (depth = near / distance).
#include "scene/frame/camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace crowdbench::scene {

glm::dmat3 view_rotation(const Camera& camera) {
  const glm::dvec3 towards = camera.target - camera.eye;
  const double length = glm::length(towards);
  const glm::dvec3 forward = length > 0 ? towards / length : glm::dvec3{0.0, 0.0, -1.0};
  glm::dvec3 right = glm::cross(forward, camera.up);
  // Below this sine the cross product is rounding noise and the picture would spin with the last bits of the target.
  if (!(glm::length(right) > 1e-9 * glm::length(camera.up)) || glm::length(camera.up) == 0) {
    const glm::dvec3 replacement{0.0, 0.0, forward.y > 0 ? 1.0 : -1.0};
    right = glm::cross(forward, replacement);
    // Only a view along Z with an up along Z comes here: the world's own up is free then.
    if (!(glm::length(right) > 1e-9)) right = glm::cross(forward, glm::dvec3{0.0, 1.0, 0.0});
  }
  right = glm::normalize(right);
  const glm::dvec3 up = glm::cross(right, forward);
  return glm::transpose(glm::dmat3{right, up, -forward});
}

glm::dmat4 projection(const Camera& camera, double aspect) {
  assert(camera.near > 0 && aspect > 0 && camera.fov_y > 0 && camera.fov_y < 3.141592653589793);
  const double scale = 1.0 / std::tan(camera.fov_y / 2);
  glm::dmat4 matrix{0.0};
  matrix[0][0] = scale / aspect;
  matrix[1][1] = scale;
  matrix[2][3] = -1.0;
  if (camera.far > 0) {
    assert(camera.far > camera.near);
    matrix[2][2] = camera.near / (camera.far - camera.near);
    matrix[3][2] = camera.far * camera.near / (camera.far - camera.near);
  } else {
    matrix[3][2] = camera.near;
  }
  return matrix;
}

double pixel_size_at(const Camera& camera, double depth, int rows) {
  return 2.0 * depth * std::tan(camera.fov_y / 2) / rows;
}

Camera CameraPath::at(double seconds) const {
  assert(!keys.empty());
  if (!(seconds > keys.front().time)) return keys.front().camera;
  const auto after = std::upper_bound(keys.begin(), keys.end(), seconds,
                                      [](double time, const CameraKey& key) { return time < key.time; });
  if (after == keys.end()) return keys.back().camera;
  const CameraKey& a = *(after - 1);
  const CameraKey& b = *after;
  const double t = (seconds - a.time) / (b.time - a.time);
  Camera camera = a.camera;  // up, near and far hold until the next key
  camera.eye += t * (b.camera.eye - a.camera.eye);
  camera.target += t * (b.camera.target - a.camera.target);
  camera.fov_y += t * (b.camera.fov_y - a.camera.fov_y);
  return camera;
}

}  // namespace crowdbench::scene
