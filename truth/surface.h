// What a ray meets, shaded: renderers/mesh/mesh.frag, shaders/shading.glsl and shaders/ground.frag over again, in
// double. tests/renderers/truth_test.cpp holds both together.
#pragma once
#include <optional>
#include <vector>

#include "scene/cast/cast.h"
#include "scene/frame/frame.h"
#include "truth/posed_agent.h"
#include "truth/ray.h"
#include "truth/texture.h"
#include "truth/view.h"

namespace crowdbench::truth {

// linear = albedo * outfit * (ambient + diffuse * max(0, N.L)) + emissive; unlit: albedo * outfit. normal: any length
// but 0.
glm::dvec3 shade(const scene::Light& light, const glm::dvec3& albedo, const glm::dvec3& normal, bool unlit,
                 const glm::dvec3& emissive);

// The share of [x - width / 2, x + width / 2] within half_width of a whole number.
double line_coverage(double x, double width, double half_width);

// One character's surfaces.
class Surface {
 public:
  explicit Surface(const scene::Character& character);

  const std::vector<uint32_t>& indices() const { return indices_; }
  const scene::Material& material(uint32_t triangle) const;
  uint32_t material_index(uint32_t triangle) const;
  bool masked(uint32_t triangle) const { return threshold_[material_index(triangle)] > 0; }
  // Whether what faces the eye so is drawn at all.
  bool drawn(uint32_t triangle, bool back) const {
    return primitive_of_[triangle] != ~0U && (!back || material(triangle).double_sided);
  }
  // Alpha over the material's test, in alpha: below 0 it is not there. posed: the corners, relative to the eye.
  // step: of the footprint, pixels.
  double above_cutoff(uint32_t triangle, const glm::dvec3 posed[3], const glm::dvec3& weights, const View& view,
                      const glm::dvec3& direction, double step) const;

  struct Shaded {
    glm::dvec3 normal;  // unit; 0 where the file's is
    glm::dvec3 linear;
  };
  Shaded shaded(uint32_t triangle, const TriangleHit& hit, const AgentPose& pose, uint32_t outfit,
                const scene::Frame& frame, const View& view, const glm::dvec3& direction, double step) const;

 private:
  glm::dvec4 texel(int image, const std::vector<glm::vec2>& uvs, uint32_t triangle, const glm::dvec3 posed[3],
                   const glm::dvec3& weights, const View& view, const glm::dvec3& direction, double step) const;
  const scene::Character& character_;
  std::vector<uint32_t> indices_, primitive_of_;
  std::vector<double> threshold_;  // by material
  std::vector<TruthTexture> textures_;
};

// The ground along a ray: its depth; nothing where the ray does not meet it between near and far, or there is none.
std::optional<double> ground_depth(const scene::Frame& frame, const View& view, const glm::dvec3& direction);
// Its colour there, linear.
glm::dvec3 ground_colour(const scene::Frame& frame, const View& view, const glm::dvec3& direction, double depth,
                         double step);

}  // namespace crowdbench::truth
