// What a mask leaves of a triangle: where alpha (texture times vertex colour) passes the material's test, as the mesh
// draws it near by.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// A place within a triangle: the weights of its corners, sum 1.
using TrianglePlace = glm::dvec3;

class CutOut {
 public:
  // Of a material's triangles. Refers to the character.
  CutOut(const Character& character, const Material& material);

  // Whether the test can fail anywhere; where it cannot, every triangle is there as a whole.
  bool cuts() const { return cuts_; }
  // corners: three vertices of the mesh.
  bool there(const uint32_t* corners, const TrianglePlace& at) const;
  // Places whose convex hull is that of what is there, within half a texel or a 2048th of the triangle, whichever is
  // more; three corners for a whole triangle, empty where nothing is there. A linear function over the triangle, such
  // as a posed point's height, is largest at one of them.
  std::vector<TrianglePlace> outline(const uint32_t* corners) const;
  // The mean over the triangle of the place where it is there and of zero elsewhere, from 64 samples: the sum of the
  // three is the share of its area that is drawn, and they share out its mass on its corners.
  TrianglePlace moment(const uint32_t* corners) const;

 private:
  double alpha_of_texel(int64_t x, int64_t y) const;
  double texture_alpha(const glm::dvec2& uv) const;
  double inset(const uint32_t* corners) const;
  TrianglePlace edge(const uint32_t* corners, TrianglePlace inside, TrianglePlace outside) const;

  const Mesh& mesh_;
  const Texture* texture_ = nullptr;  // null: none that has a say
  double threshold_ = 0;
  bool cuts_ = false;
};

// How far what is drawn of a mesh reaches: vertices that masks cut away have no say, what is left within their
// triangles has. Triangles are looked at when they reach farther than all that was found, and once.
class DrawnExtent {
 public:
  // Refers to the character's mesh, materials and images.
  explicit DrawnExtent(const Character& character);

  // Whether masks may cut anything: else what is drawn reaches as far as the vertices do.
  bool cuts() const { return !cut_.empty(); }
  // The largest value over what is drawn of a function that is linear over every triangle, such as a coordinate of a
  // posed mesh. values: one a vertex. Where masks leave nothing at all: over all vertices.
  double most(std::span<const double> values);
  // Points that reach, up and down, as far as what is drawn does, from any eye that is level with it: vertices, and of
  // triangles that masks may cut and that end within a fifth of the height from top or bottom what is left of them.
  // posed: one a vertex.
  std::vector<glm::dvec3> outer_points(std::span<const glm::dvec3> posed);

 private:
  struct Triangle {
    std::array<uint32_t, 3> corners;
    size_t cut_out;
    bool looked_at = false;
    std::vector<TrianglePlace> outline;
  };
  const std::vector<TrianglePlace>& outline(Triangle& triangle);

  std::vector<CutOut> cut_outs_;         // by material
  std::vector<const Primitive*> whole_;  // those that nothing cuts
  std::vector<Triangle> cut_;
};

}  // namespace crowdbench::scene
