// A ray against triangles, in double, so that nothing passes between two triangles that share an edge.
//
// Based on: S. Woop, C. Benthin and I. Wald, "Watertight ray/triangle intersection" (2013): vertices are sheared so
// that the ray runs along an axis, and 2D edge functions decide. Differs from the source: the sign of an edge function
// is exact and not that of its rounded value, so that what a fan of triangles round a vertex covers is one piece of the
// plane, whatever the rounding; and the distance is kept within that of the triangle's corners, so that boxes bound it
// to the last bit.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace crowdbench::truth {

// x * y - z * w as one rounding away from exact, and of the exact sign (or 0) for products that neither overflow nor
// fall below 1e-290. Products round monotonically: where they differ once rounded, they differ that way.
inline double edge_function(double x, double y, double z, double w) {
  const double p = x * y;
  const double q = z * w;
  if (p != q) return p - q;
  return std::fma(x, y, -p) - std::fma(z, w, -q);
}

// t: of origin + t * direction. weights: of the corners a, b, c; none below 0, sum 1 within rounding.
struct TriangleHit {
  double t = std::numeric_limits<double>::infinity();
  glm::dvec3 weights{0.0};
  bool back = false;  // the corners run clockwise as the ray sees them
};

class Ray {
 public:
  // direction: finite, of any length above 0. t counts from the origin in units of it, also below 0.
  Ray(const glm::dvec3& origin, const glm::dvec3& direction) : origin_(origin) {
    for (int k = 1; k < 3; ++k)
      if (std::abs(direction[k]) > std::abs(direction[z_])) z_ = k;
    x_ = (z_ + 1) % 3;
    y_ = (x_ + 1) % 3;
    if (direction[z_] < 0) std::swap(x_, y_);  // keeps the sense in which corners run
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    scale_ = 1.0 / direction[z_];
  }

  // A point on axes on which the ray is the line x = y = 0 and z is t. Monotonic in each coordinate of the point.
  glm::dvec3 sheared(const glm::dvec3& point) const {
    const glm::dvec3 p = point - origin_;
    return {p[x_] - shear_x_ * p[z_], p[y_] - shear_y_ * p[z_], scale_ * p[z_]};
  }

  // Edges and corners belong to all triangles that share them; a triangle that the ray sees edge-on is not hit.
  bool hits(const glm::dvec3& corner_a, const glm::dvec3& corner_b, const glm::dvec3& corner_c,
            TriangleHit& hit) const {
    const glm::dvec3 a = sheared(corner_a);
    const glm::dvec3 b = sheared(corner_b);
    const glm::dvec3 c = sheared(corner_c);
    const double u = edge_function(c.x, b.y, c.y, b.x);
    const double v = edge_function(a.x, c.y, a.y, c.x);
    const double w = edge_function(b.x, a.y, b.y, a.x);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (!(sum != 0)) return false;
    const auto [least, most] = std::minmax({a.z, b.z, c.z});
    hit.weights = glm::dvec3(u, v, w) / sum;
    hit.t = std::clamp(hit.weights.x * a.z + hit.weights.y * b.z + hit.weights.z * c.z, least, most);
    hit.back = sum < 0;
    return true;
  }

  // Whether a triangle with its corners in the box can be hit, and from which t on. Never a false no: the bounds are
  // the very operations of sheared() on the box's sides, and rounding keeps order.
  bool meets(const glm::dvec3& low, const glm::dvec3& high, double& from) const {
    const glm::dvec3 l = low - origin_;
    const glm::dvec3 h = high - origin_;
    const auto apart = [&](int axis, double shear) {
      const auto [least, most] = std::minmax({shear * l[z_], shear * h[z_]});
      return l[axis] - most > 0 || h[axis] - least < 0;
    };
    from = std::min(scale_ * l[z_], scale_ * h[z_]);
    return !apart(x_, shear_x_) && !apart(y_, shear_y_);
  }

 private:
  glm::dvec3 origin_;
  int x_ = 0, y_ = 0, z_ = 0;
  double shear_x_ = 0, shear_y_ = 0, scale_ = 0;
};

}  // namespace crowdbench::truth
