#include "truth/posed_agent.h"

#include <algorithm>

namespace crowdbench::truth {
namespace {

glm::dvec3 times(const std::array<glm::dvec4, 3>& rows, const glm::dvec4& p) {
  return {glm::dot(rows[0], p), glm::dot(rows[1], p), glm::dot(rows[2], p)};
}

}  // namespace

AgentPose::AgentPose(const scene::Character& character, const scene::PoseBank& bank, const scene::FrameAgent& agent)
    : mesh_(character.mesh) {
  const auto joints = static_cast<size_t>(bank.joints());
  const scene::Mat3x4* a = bank.matrices().data() + agent.pose.a * joints;
  const scene::Mat3x4* b = bank.matrices().data() + agent.pose.b * joints;
  const auto blend = static_cast<double>(agent.pose.blend);
  const auto scale = static_cast<double>(agent.scale);
  const double s = static_cast<double>(agent.heading.x) * scale;
  const double c = static_cast<double>(agent.heading.y) * scale;
  const glm::dvec3 place(agent.position);
  palette_.resize(joints);
  for (size_t j = 0; j < joints; ++j) {
    Rows rows;
    for (size_t r = 0; r < 3; ++r)
      rows[r] = glm::dvec4(a[j].rows[r]) * (1.0 - blend) + glm::dvec4(b[j].rows[r]) * blend;
    palette_[j] = {c * rows[0] + s * rows[2] + glm::dvec4(0, 0, 0, place.x),
                   scale * rows[1] + glm::dvec4(0, 0, 0, place.y),
                   c * rows[2] - s * rows[0] + glm::dvec4(0, 0, 0, place.z)};
  }
}

AgentPose::Rows AgentPose::blended(uint32_t vertex) const {
  Rows rows{};
  double sum = 0;
  for (int i = 0; i < scene::kInfluences; ++i) {
    const auto weight = static_cast<double>(mesh_.weights[vertex][i]);
    if (weight == 0) continue;
    const Rows& joint = palette_[mesh_.joints[vertex][i]];
    for (size_t r = 0; r < 3; ++r) rows[r] += weight * joint[r];
    sum += weight;
  }
  // Floats sum to 1 within 1e-6, which of a place a kilometre from the eye would be a millimetre.
  if (sum > 0)
    for (glm::dvec4& row : rows) row /= sum;
  return rows;
}

glm::dvec3 AgentPose::position(uint32_t vertex) const {
  return times(blended(vertex), glm::dvec4(mesh_.positions[vertex], 1.0));
}

glm::dvec3 AgentPose::normal(uint32_t vertex) const {
  return times(blended(vertex), glm::dvec4(mesh_.normals[vertex], 0.0));
}

double AgentPose::spread(uint32_t vertex) const {
  const glm::dvec4 p(mesh_.positions[vertex], 1.0);
  double most = 0;
  for (int i = 0; i < scene::kInfluences; ++i)
    for (int k = 0; k < i; ++k)
      if (mesh_.weights[vertex][i] != 0.0F && mesh_.weights[vertex][k] != 0.0F)
        most = std::max(most, glm::length(times(palette_[mesh_.joints[vertex][i]], p) -
                                          times(palette_[mesh_.joints[vertex][k]], p)));
  return most;
}

std::vector<uint32_t> drawn_indices(const scene::Mesh& mesh) {
  std::vector<uint32_t> out = mesh.indices;
  for (const scene::Primitive& p : mesh.primitives)
    if (p.mirrored)
      for (uint32_t i = p.first_index; i + 2 < p.first_index + p.index_count; i += 3) std::swap(out[i + 1], out[i + 2]);
  return out;
}

std::vector<uint32_t> primitives_of_triangles(const scene::Mesh& mesh) {
  std::vector<uint32_t> out(mesh.indices.size() / 3, ~0U);
  for (size_t p = 0; p < mesh.primitives.size(); ++p)
    std::fill_n(out.begin() + mesh.primitives[p].first_index / 3, mesh.primitives[p].index_count / 3,
                static_cast<uint32_t>(p));
  return out;
}

}  // namespace crowdbench::truth
