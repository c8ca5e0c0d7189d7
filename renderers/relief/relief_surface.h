// A point of the skin, as what captures a relief finds it, and what a face of a box stores of it: colour, normal, slot
// and the light given off.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "renderers/relief/relief_capture.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

// Where a triangle is met, and how deep.
struct Winner {
  uint32_t triangle = UINT32_MAX;
  double b1 = 0;  // barycentric weights of the second and third corner
  double b2 = 0;
  double depth = 0;
};

// Four bytes each; emission may be null.
struct FaceTexel {
  uint8_t* colour;
  uint8_t* normal;
  uint8_t* emission;
};

// A point of a triangle, by the weights of its corners.
struct SurfacePoint {
  std::array<uint32_t, 3> v;
  double b0, b1, b2;

  SurfacePoint(const scene::Mesh& mesh, const Winner& winner)
      : v{mesh.indices[3 * winner.triangle], mesh.indices[3 * winner.triangle + 1],
          mesh.indices[3 * winner.triangle + 2]},
        b0(1.0 - winner.b1 - winner.b2),
        b1(winner.b1),
        b2(winner.b2) {}
  template <typename Vector, typename Value>
  Vector mixed(const std::vector<Value>& of_vertex) const {
    return Vector(of_vertex[v[0]]) * b0 + Vector(of_vertex[v[1]]) * b1 + Vector(of_vertex[v[2]]) * b2;
  }
};

// What a texel spans of the surface around it.
struct TexelSpan {
  std::array<glm::dvec3, 3>
      corners;        // of the triangle, in texels; over the picture plane alone, or as they lie in space
  double texels = 1;  // that the span is wide
};

// What masks of the triangle's material are asked with: the texels of its skin that a texel of a map spans along the
// surface, however steep it stands, so that places are a texel of the map apart. corners: in texels of the map, depth
// in [0, 1] of n.
double alpha_footprint(const CaptureSource& source, uint32_t triangle, const std::array<glm::dvec3, 3>& corners,
                       size_t n);
// Whether a mask leaves the surface there.
bool is_there(const CaptureSource& source, const Winner& winner, double footprint);

const scene::Material& material_of(const CaptureSource& source, uint32_t triangle);

// Into four bytes: sRGB, and whether it is unlit.
void store_colour(const CaptureSource& source, const Winner& winner, const TexelSpan& of, uint8_t* texel);
// What a face stores of a point. toward: where from it is seen, a direction of bind space.
void shade(const CaptureSource& source, const BoxSpace& space, const Winner& winner, const glm::dvec3& toward,
           const TexelSpan& of, const FaceTexel& texel);

}  // namespace crowdbench::renderers
