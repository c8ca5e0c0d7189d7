// The ground that a view sees between two depths: where the stages `view` and `frustum` put agents. Internal to
// scene/.
#pragma once
#include <glm/glm.hpp>

#include "scene/crowd/crowd.h"

namespace crowdbench::scene {

struct GroundPoint {
  double x = 0;
  double z = 0;
};

// A fraction of a body's height. The point at this height is kept in the picture, so that feet are cut rather than
// faces.
inline constexpr double kKeptInView = 0.8;

// The cast's mean height, by share, rounded so that the last bits of a machine's sine do not enter a crowd.
double stage_height(const Cast& cast);
// Tangent of half the vertical field of view; the same bits on every machine.
double half_tangent(const Camera& camera);

// A patch of the plane at kKeptInView of the bodies' height. Its coordinates: `across` from -1 (left edge of the
// picture) to 1, `along` from -1 (nearest) to 1 (farthest), uniform in depth; in a view so steep that the ground has
// hardly any depth, `along` is the picture's own vertical from bottom to top instead.
class ViewGround {
 public:
  ViewGround(const StageView& view, double rise);
  GroundPoint at(double across, double along) const;
  // The larger of |across| and |along| of a point: 0 in the middle, 1 at the edge, infinite behind the eye.
  double norm(const GroundPoint& point) const;
  double area() const;  // square metres

 private:
  glm::dmat3 rotation_;
  glm::dmat3 axes_;  // columns: right, up, backward
  double tall_, wide_;
  double rise_;  // metres: the plane above the eye
  bool steep_;
  double near_, far_;  // depths, within the picture
};

}  // namespace crowdbench::scene
