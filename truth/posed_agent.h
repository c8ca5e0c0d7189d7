// An agent's mesh as it stands in a frame, in double.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/cast/cast.h"
#include "scene/frame/frame.h"

namespace crowdbench::truth {

// Linear blend skinning of one agent: the blend of its two samples, its scale, heading and place (what
// renderers/shaders/pose.comp and mesh.vert do in float).
class AgentPose {
 public:
  AgentPose(const scene::Character& character, const scene::PoseBank& bank, const scene::FrameAgent& agent);
  // Metres, world axes, relative to the eye.
  glm::dvec3 position(uint32_t vertex) const;
  // By the weighted upper 3 x 3: not unit.
  glm::dvec3 normal(uint32_t vertex) const;
  // How far apart a vertex's joints would put it, metres: the largest of any two with a weight.
  double spread(uint32_t vertex) const;

 private:
  using Rows = std::array<glm::dvec4, 3>;
  Rows blended(uint32_t vertex) const;
  const scene::Mesh& mesh_;
  std::vector<Rows> palette_;
};

// The corners of a character's triangles as the mesh draws them: those of mirrored primitives turned round, so that
// counter-clockwise is the front everywhere. Triangle i is Mesh::indices[3 * i ...].
std::vector<uint32_t> drawn_indices(const scene::Mesh& mesh);

// By triangle: the primitive that it is of; ~0: of none, and it is not drawn.
std::vector<uint32_t> primitives_of_triangles(const scene::Mesh& mesh);

}  // namespace crowdbench::truth
