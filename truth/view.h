// A frame's camera as rays through places of its picture, in double.
#pragma once
#include <glm/glm.hpp>
#include <limits>

#include "scene/frame/frame.h"

namespace crowdbench::truth {

// Pixels count from the upper left corner of the picture. The eye is the origin, on world axes; a ray's parameter is
// the depth along the view axis, metres.
class View {
 public:
  explicit View(const scene::Frame& frame);
  glm::dvec3 direction(const glm::dvec2& place) const { return corner_ + place.x * right_ + place.y * down_; }
  const glm::dvec3& right() const { return right_; }  // by how much a direction changes a pixel to the right
  const glm::dvec3& down() const { return down_; }
  double near() const { return near_; }
  double far() const { return far_; }  // infinity where there is none
  double depth(const glm::dvec3& point) const { return glm::dot(point, forward_); }
  // Of a point before the eye.
  glm::dvec2 place(const glm::dvec3& point) const;
  // Metres of a pixel at a depth of one.
  double pixel() const { return pixel_; }

 private:
  glm::dvec3 corner_, right_, down_, forward_;
  double near_ = 0, far_ = 0, pixel_ = 0;
};

}  // namespace crowdbench::truth
