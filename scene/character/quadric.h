// Quadrics: sums of squared distances to planes, and of squared errors of attributes that are linear over faces.
// Based on: M. Garland and P. Heckbert, "Surface simplification using quadric error metrics" (1997); H. Hoppe, "New
// quadric metric for simplifying meshes with appearance attributes" (1999).
#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <span>

namespace crowdbench::scene {

// q(p) = p.A p + 2 b.p + c.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  glm::dvec3 b{0.0};
  double c = 0;

  // Adds weight * (n.p + d)^2.
  void add_plane(const glm::dvec3& n, double d, double weight) {
    xx += weight * n.x * n.x;
    xy += weight * n.x * n.y;
    xz += weight * n.x * n.z;
    yy += weight * n.y * n.y;
    yz += weight * n.y * n.z;
    zz += weight * n.z * n.z;
    b += weight * d * n;
    c += weight * d * d;
  }
  void add(const Quadric& other) {
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    b += other.b;
    c += other.c;
  }
  double at(const glm::dvec3& p) const {
    return p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z + b.x)) + p.y * (yy * p.y + 2 * (yz * p.z + b.y)) +
           p.z * (zz * p.z + 2 * b.z) + c;
  }
};

// Normal, two texture coordinates and colour of a vertex, each already in the unit in which its error counts.
inline constexpr size_t kAttributes = 11;
using Attributes = std::array<float, kAttributes>;

// How far the attributes s at a place p are from what the faces have there: the sum over faces and attributes of
// weight * (g.p + d - s)^2, where g and d are an attribute's gradient and offset on the face.
struct AttributeQuadric {
  Quadric of_place;
  double weight = 0;
  std::array<glm::dvec3, kAttributes> gradient{};  // sums of weight * g
  std::array<double, kAttributes> offset{};        // sums of weight * d

  // A face with its corners' attributes; nothing where it has no area.
  void add_face(const std::array<glm::dvec3, 3>& p, const std::array<const Attributes*, 3>& s, double face_weight) {
    const glm::dvec3 e1 = p[1] - p[0];
    const glm::dvec3 e2 = p[2] - p[0];
    const double a = glm::dot(e1, e1);
    const double m = glm::dot(e1, e2);
    const double f = glm::dot(e2, e2);
    const double determinant = a * f - m * m;
    if (!(determinant > 1e-12 * a * f)) return;
    weight += face_weight;
    for (size_t j = 0; j < kAttributes; ++j) {
      const double s1 = double{(*s[1])[j]} - double{(*s[0])[j]};
      const double s2 = double{(*s[2])[j]} - double{(*s[0])[j]};
      const glm::dvec3 g = ((f * s1 - m * s2) * e1 + (a * s2 - m * s1) * e2) / determinant;
      const double d = double{(*s[0])[j]} - glm::dot(g, p[0]);
      of_place.add_plane(g, d, face_weight);
      gradient[j] += face_weight * g;
      offset[j] += face_weight * d;
    }
  }
  void add(const AttributeQuadric& other) {
    of_place.add(other.of_place);
    weight += other.weight;
    for (size_t j = 0; j < kAttributes; ++j) {
      gradient[j] += other.gradient[j];
      offset[j] += other.offset[j];
    }
  }
  double at(const glm::dvec3& p, const Attributes& s) const {
    double sum = of_place.at(p);
    for (size_t j = 0; j < kAttributes; ++j) {
      const auto value = static_cast<double>(s[j]);
      sum += value * (weight * value - 2 * (glm::dot(gradient[j], p) + offset[j]));
    }
    return sum;
  }
};

}  // namespace crowdbench::scene
