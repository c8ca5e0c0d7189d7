// The bones that human skeletons have in common, found by the names that programs give them.
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

enum class BonePart : uint8_t {
  hips,
  spine,  // Bone::number from the hips upwards; found by its place between hips and neck, not by its name
  neck,
  head,
  shoulder,
  upper_arm,
  lower_arm,
  hand,
  upper_leg,
  lower_leg,
  foot,
  toes,
  thumb,  // fingers: Bone::number 1 to 3 from the palm outwards
  index_finger,
  middle_finger,
  ring_finger,
  little_finger
};
enum class BoneSide : uint8_t { middle, left, right };

struct Bone {
  BonePart part = BonePart::hips;
  BoneSide side = BoneSide::middle;
  int number = 0;  // of spines and fingers; 0 elsewhere
  auto operator<=>(const Bone&) const = default;
};
// "left lower arm"
std::string bone_text(const Bone& bone);

// The bone that a node of this name is in the skeletons of Mixamo and Ready Player Me (mixamorig:LeftForeArm), VRoid
// (J_Bip_L_LowerArm), Unreal (lowerarm_l), Blender's Rigify (DEF-forearm.L), KayKit (lowerarm.l), Quaternius
// (LowerArm.L), Maya's joints (L_elbow_jnt) and the mannequin (forearm_l), whatever their case and prefix. Never a
// spine.
std::optional<Bone> bone_of_name(std::string_view name);

// The node of each bone, among those whose `candidates` is true (one a node). Where several nodes have a bone's name,
// the one nearest the root. Where the bones of a leg, an arm or a neck differ by number alone (leg_joint_L_1, ..._2),
// which hangs on which says what they are; a single leg bone is the upper one; hips that have no such name are what
// both legs hang on. A file that says itself which node is what (Skeleton::human_bones, VRM) is believed.
std::map<Bone, int> find_human_bones(const Skeleton& skeleton, const std::vector<bool>& candidates);

// Nodes that can be bones: the joints of skins and what they hang on; without a skin every node. Meshes are often
// called what the bone beside them is called.
std::vector<bool> bone_candidates(const Skeleton& skeleton);

// The bone that this one hangs on in a body: the hand on the lower arm. nullopt: hips.
std::optional<Bone> bone_above(const Bone& bone);

}  // namespace crowdbench::scene
