#include "scene/pose/facing.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

constexpr double kAnkle = 0.2;     // of the height above the soles: a foot's joints lie below
constexpr double kHead = 0.12;     // of the height below the top: that much is the head
constexpr double kFarther = 1.25;  // times: one side reaches farther than the other
constexpr double kClearly = 0.01;  // of the height: and by more than this

struct Reach {
  double front = 0;
  double back = 0;
  void take(double z) {
    front = std::max(front, z);
    back = std::max(back, -z);
  }
  Facing facing(double height) const {
    if (front > kFarther * back && front - back > kClearly * height) return Facing::plus_z;
    if (back > kFarther * front && back - front > kClearly * height) return Facing::minus_z;
    return Facing::unclear;
  }
};

int strongest_joint(const Mesh& mesh, uint32_t v) {
  int best = 0;
  for (int i = 1; i < kInfluences; ++i)
    if (mesh.weights[v][i] > mesh.weights[v][best]) best = i;
  return mesh.joints[v][best];
}

// Where the ankle above a sole's joint is: toes hang from a foot, which hangs from it.
glm::dvec3 ankle_of(const Character& character, const std::vector<glm::dmat4>& world, int joint, double highest) {
  int node = character.skeleton.joints[static_cast<size_t>(joint)].node;
  const auto at = [&](int n) { return glm::dvec3(world[static_cast<size_t>(n)][3]); };
  const auto is_joint = [&](int n) {
    return std::ranges::any_of(character.skeleton.joints, [n](const Joint& j) { return j.node == n; });
  };
  for (int up = character.skeleton.nodes[static_cast<size_t>(node)].parent;
       up >= 0 && is_joint(up) && at(up).y < highest && at(up).y > at(node).y;
       up = character.skeleton.nodes[static_cast<size_t>(up)].parent)
    node = up;
  return at(node);
}

}  // namespace

Facing compute_facing(const Character& character, std::span<const glm::dvec3> posed, std::span<const uint32_t> soles) {
  const auto world = node_matrices(character, -1, 0.0);
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (const glm::dvec3& p : posed) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  const double height = high - low;
  Reach feet;
  for (const uint32_t v : soles)
    feet.take(posed[v].z - ankle_of(character, world, strongest_joint(character.mesh, v), low + kAnkle * height).z);
  if (const Facing facing = feet.facing(height); facing != Facing::unclear) return facing;

  // From the middle of the head's surface: a nose has few square centimetres but may have many vertices.
  const auto& indices = character.mesh.indices;
  double area = 0;
  double middle = 0;
  const auto visit_head = [&](const auto& see) {
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
      const glm::dvec3& p = posed[indices[i]];
      const glm::dvec3& q = posed[indices[i + 1]];
      const glm::dvec3& r = posed[indices[i + 2]];
      if ((p.y + q.y + r.y) / 3 > high - kHead * height) see(p, q, r);
    }
  };
  visit_head([&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    const double own = glm::length(glm::cross(q - p, r - p));
    area += own;
    middle += own * (p.z + q.z + r.z) / 3;
  });
  if (!(area > 0)) return Facing::unclear;
  middle /= area;
  Reach nose;
  visit_head([&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    for (const double z : {p.z, q.z, r.z}) nose.take(z - middle);
  });
  return nose.facing(height);
}

}  // namespace crowdbench::scene
