// Points and polygons of the plane, turned.
#pragma once
#include <cmath>

#include "renderers/polypostor/polypostor_contour.h"

namespace crowdbench::renderers::testing {

// angle: radians, counter-clockwise about the origin.
inline glm::dvec2 turned(const glm::dvec2& p, double angle) {
  return {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y};
}
inline Polyline turned(const Polyline& line, double angle) {
  Polyline out;
  for (const glm::dvec2& p : line) out.push_back(turned(p, angle));
  return out;
}

}  // namespace crowdbench::renderers::testing
