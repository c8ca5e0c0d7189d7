#include "scene/pose/reach.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace crowdbench::scene {
namespace {

// A bound of the spectral norm that is exact for rotations: the root of the largest row sum of |M^T M|.
double most_stretch(const glm::dmat3& m) {
  double most = 0;
  for (int i = 0; i < 3; ++i)
    most = std::max(most,
                    std::abs(glm::dot(m[i], m[0])) + std::abs(glm::dot(m[i], m[1])) + std::abs(glm::dot(m[i], m[2])));
  return std::sqrt(most);
}

}  // namespace

std::optional<size_t> node_beyond_reach(const Character& character, double limit) {
  const auto& nodes = character.skeleton.nodes;
  std::vector<double> scale(nodes.size());
  std::vector<double> offset(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Node& n = nodes[i];
    const auto largest = [](const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
    scale[i] = n.has_matrix ? most_stretch(glm::dmat3(n.matrix)) : largest(n.scale);
    offset[i] = largest(n.has_matrix ? glm::dvec3(n.matrix[3]) : n.translation);
  }
  for (const Clip& clip : character.clips) {
    for (const Channel& channel : clip.channels) {
      if (channel.target == Target::rotation) continue;
      double most = 0;
      for (const double v : channel.values) most = std::max(most, std::abs(v));
      // The tangents of a spline count by the time between keys.
      if (channel.interpolation == Interpolation::cubic_spline) most *= 1.0 + clip.duration();
      double& bound = (channel.target == Target::scale ? scale : offset)[static_cast<size_t>(channel.node)];
      bound = std::max(bound, most);
    }
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent >= 0) {
      const auto parent = static_cast<size_t>(nodes[i].parent);
      offset[i] = offset[parent] + 2.0 * scale[parent] * offset[i];
      scale[i] *= scale[parent];
    }
    if (!(scale[i] <= limit && offset[i] <= limit)) return i;
  }
  return std::nullopt;
}

}  // namespace crowdbench::scene
