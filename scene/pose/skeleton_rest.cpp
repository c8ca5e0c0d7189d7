#include "scene/pose/skeleton_rest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

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

bool SkeletonRest::is_human() const {
  for (const BoneSide side : {BoneSide::left, BoneSide::right})
    if (!place(BonePart::upper_leg, side) || !place(BonePart::lower_leg, side)) return false;
  return place(BonePart::hips).has_value();
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
  const glm::dvec3 knees =
      (*place(BonePart::lower_leg, BoneSide::left) + *place(BonePart::lower_leg, BoneSide::right)) / 2.0;
  const glm::dvec3 up = nearest_axis((left_leg + right_leg) / 2.0 - knees);
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
