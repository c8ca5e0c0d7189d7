#include "scene/pose/skeleton_rest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

constexpr double kUprightCosine = 0.5;  // cosine between spine and legs: of four legs it is near 0

// Along the axes of the file: a figure that leans a little at rest goes on leaning.
glm::dvec3 nearest_axis(const glm::dvec3& v) {
  glm::dvec3 out(0.0);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(v[i]) > std::abs(v[axis])) axis = i;
  out[axis] = v[axis] < 0 ? -1 : 1;
  return out;
}

}  // namespace

SkeletonRest::SkeletonRest(const Character& character)
    : skeleton(character.skeleton),
      where(printable(character.source, 300)),
      world(node_matrices(character, -1, 0.0)),
      bones(find_human_bones(character.skeleton, bone_candidates(character.skeleton))) {
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (const glm::dmat4& m : world) {
    low = glm::min(low, place_of(m));
    high = glm::max(high, place_of(m));
  }
  const glm::dvec3 sides = high - low;
  size = world.empty() ? 0.0 : std::max({sides.x, sides.y, sides.z});
  upright = find_upright();
}

std::optional<glm::dvec3> SkeletonRest::place(BonePart part, BoneSide side) const {
  const auto found = bones.find({part, side, 0});
  return found == bones.end() ? std::nullopt : std::optional(place_of(world[at(found->second)]));
}

glm::dquat SkeletonRest::rotation(int node) const { return upright * rotation_of(world[at(node)]); }

glm::dvec3 SkeletonRest::position(int node) const { return upright * place_of(world[at(node)]); }

glm::dvec3 SkeletonRest::up_by_legs() const {
  glm::dvec3 up(0.0);
  for (const BoneSide side : {BoneSide::left, BoneSide::right}) {
    const auto hip = place(BonePart::upper_leg, side);
    auto below = place(BonePart::lower_leg, side);
    if (!below) below = place(BonePart::foot, side);
    if (!hip || !below) return glm::dvec3(0.0);
    up += *hip - *below;
  }
  return up / 2.0;
}

glm::dvec3 SkeletonRest::up_by_head() const {
  const auto hips = place(BonePart::hips);
  auto top = place(BonePart::neck);
  if (!top) top = place(BonePart::head);
  return hips && top ? *top - *hips : glm::dvec3(0.0);
}

bool SkeletonRest::is_human() const {
  if (!place(BonePart::hips) || !place(BonePart::upper_leg, BoneSide::left) ||
      !place(BonePart::upper_leg, BoneSide::right))
    return false;
  const glm::dvec3 legs = up_by_legs();
  const glm::dvec3 head = up_by_head();
  const double lengths = glm::length(legs) * glm::length(head);
  if (!(lengths > 0)) return glm::length(legs) + glm::length(head) > 0;
  return glm::dot(legs, head) > kUprightCosine * lengths;
}

std::optional<double> SkeletonRest::leg_length() const {
  const auto knee = place(BonePart::lower_leg, BoneSide::left);
  const auto hip = place(BonePart::upper_leg, BoneSide::left);
  const auto ankle = place(BonePart::foot, BoneSide::left);
  if (!hip || !knee || !ankle) return std::nullopt;
  return glm::length(*hip - *knee) + glm::length(*knee - *ankle);
}

glm::dquat SkeletonRest::find_upright() const {
  if (!is_human()) return {1, 0, 0, 0};
  const glm::dvec3 left_leg = *place(BonePart::upper_leg, BoneSide::left);
  const glm::dvec3 right_leg = *place(BonePart::upper_leg, BoneSide::right);
  const glm::dvec3 legs = up_by_legs();
  const glm::dvec3 up = nearest_axis(glm::length(legs) > 0 ? legs : up_by_head());
  glm::dvec3 across = left_leg - right_leg;
  across -= glm::dot(across, up) * up;
  if (!(glm::length(across) > 1e-9 * size)) return {1, 0, 0, 0};
  const glm::dvec3 left = nearest_axis(across);
  const glm::dmat3 from(left, up, glm::cross(left, up));
  return glm::normalize(glm::quat_cast(glm::transpose(from)));
}

glm::dquat rotation_of(const glm::dmat4& transform) {
  glm::dmat3 axes(transform);
  for (int i = 0; i < 3; ++i) axes[i] = glm::normalize(axes[i]);
  return glm::normalize(glm::quat_cast(axes));
}

bool is_above(const Skeleton& skeleton, int above, int node) {
  for (node = skeleton.nodes[at(node)].parent; node >= 0; node = skeleton.nodes[at(node)].parent)
    if (node == above) return true;
  return false;
}

std::optional<int> find_node(const Skeleton& skeleton, std::string_view name) {
  for (size_t i = 0; i < skeleton.nodes.size(); ++i)
    if (skeleton.nodes[i].name == name) return static_cast<int>(i);
  return std::nullopt;
}

}  // namespace crowdbench::scene
