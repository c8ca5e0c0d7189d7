#include "truth/view.h"

#include <cmath>

namespace crowdbench::truth {

View::View(const scene::Frame& frame) {
  const glm::dmat3 rotation = scene::view_rotation(frame.camera);
  const glm::dmat3 back = glm::transpose(rotation);
  const double tangent = std::tan(frame.camera.fov_y / 2);
  pixel_ = 2 * tangent / frame.height;
  // A pixel is as wide as it is high: the projection's aspect is the picture's own.
  right_ = back * glm::dvec3(pixel_, 0, 0);
  down_ = back * glm::dvec3(0, -pixel_, 0);
  corner_ = back * glm::dvec3(-pixel_ * frame.width / 2, tangent, -1);
  forward_ = back * glm::dvec3(0, 0, -1);
  near_ = frame.camera.near;
  far_ = frame.camera.far > 0 ? frame.camera.far : std::numeric_limits<double>::infinity();
}

glm::dvec2 View::place(const glm::dvec3& point) const {
  const glm::dvec3 from_corner = point / depth(point) - corner_;
  return glm::dvec2(glm::dot(from_corner, right_), glm::dot(from_corner, down_)) / (pixel_ * pixel_);
}

}  // namespace crowdbench::truth
