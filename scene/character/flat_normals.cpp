#include "scene/character/flat_normals.h"

#include <vector>

namespace crowdbench::scene {
namespace {

constexpr float kSameNormal = 1.0F - 1e-6F;  // cosine: faces of one plane share their vertices

uint32_t double_vertex(Mesh& mesh, uint32_t vertex, const glm::vec3& normal) {
  const auto again = [vertex](auto& array) {
    const auto value = array[vertex];
    array.push_back(value);
  };
  again(mesh.positions);
  again(mesh.uvs);
  again(mesh.joints);
  again(mesh.weights);
  if (!mesh.emissive_uvs.empty()) again(mesh.emissive_uvs);
  if (!mesh.colours.empty()) again(mesh.colours);
  mesh.normals.push_back(normal);
  return static_cast<uint32_t>(mesh.positions.size() - 1);
}

}  // namespace

bool add_flat_normals(Mesh& mesh, const Primitive& primitive, size_t most) {
  const size_t first = primitive.first_vertex;
  const size_t count = mesh.positions.size() - first;
  mesh.normals.resize(mesh.positions.size(), glm::vec3(0.0F));
  std::vector<uint32_t> latest(count);  // the last copy made of each vertex
  for (size_t i = 0; i < count; ++i) latest[i] = static_cast<uint32_t>(first + i);
  for (size_t t = primitive.first_index; t + 2 < mesh.indices.size(); t += 3) {
    const glm::dvec3 a(mesh.positions[mesh.indices[t]]);
    const glm::dvec3 b(mesh.positions[mesh.indices[t + 1]]);
    const glm::dvec3 c(mesh.positions[mesh.indices[t + 2]]);
    const glm::dvec3 cross = glm::cross(b - a, c - a);
    const double length = glm::length(cross);
    const glm::vec3 normal = length > 1e-300 ? glm::vec3(cross / length) : glm::vec3(0.0F, 1.0F, 0.0F);
    for (size_t k = t; k < t + 3; ++k) {
      const uint32_t vertex = mesh.indices[k];
      uint32_t& copy = latest[vertex - first];
      if (mesh.normals[copy] == glm::vec3(0.0F)) mesh.normals[copy] = normal;
      if (glm::dot(mesh.normals[copy], normal) < kSameNormal) {
        if (mesh.positions.size() >= most) return false;
        copy = double_vertex(mesh, vertex, normal);
      }
      mesh.indices[k] = copy;
    }
  }
  for (size_t i = first; i < mesh.normals.size(); ++i)
    if (mesh.normals[i] == glm::vec3(0.0F)) mesh.normals[i] = glm::vec3(0.0F, 1.0F, 0.0F);
  return true;
}

}  // namespace crowdbench::scene
