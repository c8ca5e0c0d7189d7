// A skeleton at rest, as clips are carried from one to another. Internal to retarget.cpp and counterparts.cpp.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/human_bones.h"

namespace crowdbench::scene {

// A node that there is as a place in Skeleton::nodes.
inline size_t at(int node) { return static_cast<size_t>(node); }

// Rest: the nodes' own transforms. Refers to the character's skeleton, whose rest must stay as it is.
struct SkeletonRest {
  const Skeleton& skeleton;
  std::string where;               // for errors
  std::vector<glm::dmat4> world;   // by node
  std::map<Bone, int> bones;       // nodes
  glm::dquat upright{1, 0, 0, 0};  // turns it to stand along +Y and face +Z
  double size = 0;                 // of the box around its nodes: the longest side

  explicit SkeletonRest(const Character& character);

  std::optional<glm::dvec3> place(BonePart part, BoneSide side = BoneSide::middle) const;
  // Of a node, turned upright.
  glm::dquat rotation(int node) const;
  glm::dvec3 position(int node) const;
  // Has hips and two legs, of a bone or more each, and stands on them: the neck or head, where it is known, lies where
  // the legs do not.
  bool is_human() const;
  // From the left hip over the knee to the ankle.
  std::optional<double> leg_length() const;
  // From the left leg to the right one is its width, from the knees to the hips its height; along the file's axes.
  glm::dquat find_upright() const;

 private:
  // From the legs' lower ends to the hips, else from the hips to the head; neither: zero.
  glm::dvec3 up_by_legs() const;
  glm::dvec3 up_by_head() const;
};

inline glm::dvec3 place_of(const glm::dmat4& transform) { return glm::dvec3(transform[3]); }
// The rotation of a transform without shear or mirroring.
glm::dquat rotation_of(const glm::dmat4& transform);
// Whether one node is an ancestor of the other.
bool is_above(const Skeleton& skeleton, int above, int node);
// The first node of that name.
std::optional<int> find_node(const Skeleton& skeleton, std::string_view name);

}  // namespace crowdbench::scene
