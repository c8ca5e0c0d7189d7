// Clips of one skeleton played by another. The mannequin is given other names, another rest, another size, axes and
// hierarchy; whatever of that its own clips are carried to, it must move as it does.
#include "scene/pose/retarget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/load_cast.h"
#include "scene/cast/open_character.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/human_bones.h"
#include "scene/pose/normalise.h"
#include "scene/pose/pose.h"
#include "tests/scene/gltf_builder.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::scene {
namespace {

constexpr double kPi = 3.14159265358979323846;

const Character& mannequin() {
  static const Character made = make_mannequin({.triangles = 500, .joints = 20, .normalise = {.height = std::nullopt}});
  return made;
}

// Without clips of its own.
Character still_mannequin() {
  Character out = mannequin();
  out.clips.clear();
  out.motion.clear();
  return out;
}

int node_named(const Character& character, const std::string& name) {
  for (size_t i = 0; i < character.skeleton.nodes.size(); ++i)
    if (character.skeleton.nodes[i].name == name) return static_cast<int>(i);
  ADD_FAILURE() << "no node " << name;
  return 0;
}

Node& node(Character& character, const std::string& name) {
  return character.skeleton.nodes[static_cast<size_t>(node_named(character, name))];
}

void rename(Character& character, const std::function<std::string(const std::string&)>& name) {
  for (Node& n : character.skeleton.nodes) n.name = name(n.name);
}

// Puts a node above everything.
void put_on_top(Character& character, const Node& top) {
  Skeleton& skeleton = character.skeleton;
  for (Node& n : skeleton.nodes) ++n.parent;
  skeleton.nodes.insert(skeleton.nodes.begin(), top);
  for (Joint& joint : skeleton.joints) ++joint.node;
  ++skeleton.root_node;
  for (Primitive& primitive : character.mesh.primitives) ++primitive.node;
}

// The largest distance of a vertex from where the mannequin's own clip has it, metres. expected: what becomes of the
// mannequin's positions.
double worst_vertex(const Character& character, int clip, const std::string& own_clip,
                    const std::function<glm::dvec3(const glm::dvec3&)>& expected) {
  const int own = require_clip(mannequin(), own_clip);
  const Clip& curves = mannequin().clips[static_cast<size_t>(own)];
  double worst = 0;
  for (int i = 0; i <= 16; ++i) {
    const double time = curves.start + curves.duration() * i / 16;
    const auto is = skin_positions(character.mesh, joint_matrices(character, clip, time));
    const auto wanted = skin_positions(mannequin().mesh, joint_matrices(mannequin(), own, time));
    for (size_t v = 0; v < is.size(); ++v) worst = std::max(worst, glm::length(is[v] - expected(wanted[v])));
  }
  return worst;
}

double worst_of_all_clips(
    const Character& character,
    const std::function<glm::dvec3(const glm::dvec3&)>& expected = [](const glm::dvec3& v) { return v; }) {
  double worst = 0;
  for (const Clip& clip : mannequin().clips)
    worst = std::max(worst, worst_vertex(character, require_clip(character, clip.name), clip.name, expected));
  return worst;
}

const std::map<std::string, std::string>& mixamo_names() {
  static const std::map<std::string, std::string> names = {{"hips", "mixamorig:Hips"},
                                                           {"spine", "mixamorig:Spine"},
                                                           {"chest", "mixamorig:Spine1"},
                                                           {"head", "mixamorig:Head"},
                                                           {"clavicle_l", "mixamorig:LeftShoulder"},
                                                           {"upper_arm_l", "mixamorig:LeftArm"},
                                                           {"forearm_l", "mixamorig:LeftForeArm"},
                                                           {"hand_l", "mixamorig:LeftHand"},
                                                           {"thigh_l", "mixamorig:LeftUpLeg"},
                                                           {"shin_l", "mixamorig:LeftLeg"},
                                                           {"foot_l", "mixamorig:LeftFoot"},
                                                           {"toes_l", "mixamorig:LeftToeBase"}};
  return names;
}

std::string mixamo_name(const std::string& name) {
  const bool right = name.ends_with("_r");
  std::string left = name;
  if (right) left.back() = 'l';
  const auto found = mixamo_names().find(left);
  std::string out = found == mixamo_names().end() ? name : found->second;
  if (right) out.replace(out.find("Left"), 4, "Right");
  return out;
}

TEST(HumanBones, AreFoundByTheNamesOfCommonPrograms) {
  const Bone left_forearm{BonePart::lower_arm, BoneSide::left, 0};
  for (const char* name :
       {"mixamorig:LeftForeArm", "mixamorig7:LeftForeArm", "LeftForeArm", "LeftLowerArm", "J_Bip_L_LowerArm",
        "lowerarm_l", "DEF-forearm.L", "lowerarm.l", "LowerArm.L", "forearm_l", "Bip01 L Forearm",
        "Armature|LeftForeArm", "leftLowerArm", "CC_Base_L_Forearm", "b_LeftForeArm_07"})
    EXPECT_EQ(bone_of_name(name), left_forearm) << name;
  const Bone right_thigh{BonePart::upper_leg, BoneSide::right, 0};
  for (const char* name : {"mixamorig:RightUpLeg", "J_Bip_R_UpperLeg", "thigh_r", "DEF-thigh.R", "upperleg.r",
                           "UpperLeg.R", "RightUpperLeg", "R_Thigh", "RThigh"})
    EXPECT_EQ(bone_of_name(name), right_thigh) << name;
  EXPECT_EQ(bone_of_name("mixamorig:LeftLeg"), (Bone{BonePart::lower_leg, BoneSide::left, 0}));
  EXPECT_EQ(bone_of_name("mixamorig:RightToeBase"), (Bone{BonePart::toes, BoneSide::right, 0}));
  EXPECT_EQ(bone_of_name("ball_l"), (Bone{BonePart::toes, BoneSide::left, 0}));
  EXPECT_EQ(bone_of_name("pelvis"), (Bone{BonePart::hips}));
  EXPECT_EQ(bone_of_name("neck_01"), (Bone{BonePart::neck}));
  EXPECT_EQ(bone_of_name("J_Bip_C_Hips"), (Bone{BonePart::hips}));
  EXPECT_EQ(bone_of_name("J_Bip_C_Neck"), (Bone{BonePart::neck}));
  EXPECT_EQ(bone_of_name("J_Bip_C_Head"), (Bone{BonePart::head}));
  EXPECT_EQ(bone_of_name("LeftHandIndex2"), (Bone{BonePart::index_finger, BoneSide::left, 2}));
  EXPECT_EQ(bone_of_name("f_index.02.L"), (Bone{BonePart::index_finger, BoneSide::left, 2}));
  EXPECT_EQ(bone_of_name("pinky_03_r"), (Bone{BonePart::little_finger, BoneSide::right, 3}));
  EXPECT_EQ(bone_of_name("thumb1_l"), (Bone{BonePart::thumb, BoneSide::left, 1}));
  for (const char* name : {"IK-foot.l", "PoleTarget.L", "handslot.r", "forearm_twist_l", "LeftHandThumb4", "arm", "",
                           "left", "control-toe-roll.l", "Leg", "head.l", "LeftEye"})
    EXPECT_EQ(bone_of_name(name), std::nullopt) << name;
}

TEST(HumanBones, RigifyNumbersItsSpine) {
  Character c = still_mannequin();
  rename(c, [](const std::string& name) -> std::string {
    if (name == "hips") return "DEF-spine";
    if (name == "spine") return "DEF-spine.001";
    if (name == "chest") return "DEF-spine.003";
    if (name == "head") return "DEF-spine.006";
    return "DEF-" + name;
  });
  const auto bones = find_human_bones(c.skeleton, bone_candidates(c.skeleton));
  EXPECT_EQ(bones.at({BonePart::hips}), node_named(c, "DEF-spine"));
  EXPECT_EQ(bones.at({BonePart::head}), node_named(c, "DEF-spine.006"));
  EXPECT_EQ(bones.at({BonePart::spine, BoneSide::middle, 0}), node_named(c, "DEF-spine.001"));
  EXPECT_EQ(bones.at({BonePart::spine, BoneSide::middle, 1}), node_named(c, "DEF-spine.003"));
}

// Nodes by name, each with its parent's index.
Skeleton skeleton_of(const std::vector<std::pair<const char*, int>>& nodes) {
  Skeleton skeleton;
  for (const auto& [name, parent] : nodes) {
    Node node;
    node.name = name;
    node.parent = parent;
    skeleton.nodes.push_back(node);
  }
  return skeleton;
}

// Upwards on one arm, downwards on the other, as converters leave it.
TEST(HumanBones, LimbsOfOneNameAreToldApartByWhatHangsOnWhat) {
  const Skeleton skeleton = skeleton_of({{"Skeleton_torso_joint_1", -1},
                                         {"torso_joint_2", 0},
                                         {"Skeleton_neck_joint_1", 1},
                                         {"Skeleton_neck_joint_2", 2},
                                         {"Skeleton_arm_joint_L__4_", 1},
                                         {"Skeleton_arm_joint_L__3_", 4},
                                         {"Skeleton_arm_joint_L__2_", 5},
                                         {"leg_joint_L_1", 0},
                                         {"leg_joint_L_2", 7},
                                         {"leg_joint_L_3", 8},
                                         {"leg_joint_L_5", 9},
                                         {"leg_joint_R_1", 0}});
  const auto bones = find_human_bones(skeleton, std::vector<bool>(skeleton.nodes.size(), true));
  EXPECT_EQ(bones.at({BonePart::hips}), 0);
  EXPECT_EQ(bones.at({BonePart::spine}), 1);
  EXPECT_EQ(bones.at({BonePart::neck}), 2);
  EXPECT_EQ(bones.at({BonePart::head}), 3);
  EXPECT_EQ(bones.at({BonePart::upper_arm, BoneSide::left}), 4);
  EXPECT_EQ(bones.at({BonePart::lower_arm, BoneSide::left}), 5);
  EXPECT_EQ(bones.at({BonePart::hand, BoneSide::left}), 6);
  EXPECT_EQ(bones.at({BonePart::upper_leg, BoneSide::left}), 7);
  EXPECT_EQ(bones.at({BonePart::lower_leg, BoneSide::left}), 8);
  EXPECT_EQ(bones.at({BonePart::foot, BoneSide::left}), 9);
  EXPECT_EQ(bones.at({BonePart::toes, BoneSide::left}), 10);
  EXPECT_EQ(bones.at({BonePart::upper_leg, BoneSide::right}), 11) << "a single leg bone is the upper one";
  EXPECT_FALSE(bones.contains({BonePart::lower_leg, BoneSide::right}));
}

// Short figures have legs of one bone: they walk all the same.
TEST(Retarget, LegsOfOneBoneAreEnough) {
  Character figure = mannequin();
  for (Node& node : figure.skeleton.nodes)
    if (node.name.starts_with("shin") || node.name.starts_with("foot") || node.name.starts_with("toes"))
      node.name = "boot part of " + node.name.substr(0, 2) + node.name.back();
  figure.clips.clear();
  add_clips_of(mannequin(), figure);
  EXPECT_FALSE(figure.clips.empty());
  const bool swings = std::ranges::any_of(figure.clips.front().channels, [&](const Channel& channel) {
    return figure.skeleton.nodes[static_cast<size_t>(channel.node)].name == "thigh_l";
  });
  EXPECT_TRUE(swings);
}

TEST(HumanBones, AFileThatNamesThemIsBelieved) {
  Character c = still_mannequin();
  c.skeleton.human_bones = {{"leftUpperArm", node_named(c, "hand_r")}, {"leftIndexProximal", node_named(c, "head")}};
  const auto bones = find_human_bones(c.skeleton, bone_candidates(c.skeleton));
  EXPECT_EQ(bones.at({BonePart::upper_arm, BoneSide::left, 0}), node_named(c, "hand_r"));
  EXPECT_EQ(bones.at({BonePart::index_finger, BoneSide::left, 1}), node_named(c, "head"));
}

TEST(HumanBones, VrmFilesNameThem) {
  const auto bones_of = [](const nlohmann::json& extensions) {
    test::Builder card = test::bending_card();
    card.doc["extensions"] = extensions;
    const auto bytes = card.glb();
    std::map<std::string, std::string> out;  // bone to node
    const Character c = load_character(bytes, "card.glb", {});
    for (const HumanBone& bone : c.skeleton.human_bones)
      out[bone.name] = c.skeleton.nodes[static_cast<size_t>(bone.node)].name;
    return out;
  };
  using Named = std::map<std::string, std::string>;
  const nlohmann::json vrm0 = {
      {"VRM",
       {{"humanoid", {{"humanBones", {{{"bone", "hips"}, {"node", 1}}, {{"bone", "leftHand"}, {"node", 2}}}}}}}}};
  EXPECT_EQ(bones_of(vrm0), (Named{{"hips", "hips"}, {"leftHand", "arm"}}));
  const nlohmann::json vrm1 = {
      {"VRMC_vrm", {{"humanoid", {{"humanBones", {{"hips", {{"node", 1}}}, {"leftHand", {{"node", 2}}}}}}}}}};
  EXPECT_EQ(bones_of(vrm1), (Named{{"hips", "hips"}, {"leftHand", "arm"}}));
  // What is not as it should be is passed over, and the file is loaded.
  for (const char* wrong :
       {R"({"VRM": 3})", R"({"VRM": {"humanoid": []}})", R"({"VRM": {"humanoid": {"humanBones": {"hips": 1}}}})",
        R"({"VRM": {"humanoid": {"humanBones": [1, {"bone": 2, "node": 1}, {"bone": "hips", "node": 99}]}}})",
        R"({"VRM": {"humanoid": {"humanBones": [{"bone": "hips", "node": -1}, {"bone": "hips"}]}}})",
        R"({"VRMC_vrm": {"humanoid": {"humanBones": {"hips": 1, "head": {"node": "2"}, "neck": {"node": 1e30}}}}})",
        R"({"VRMC_vrm": {"humanoid": {"humanBones": [{"node": 1}]}}})"})
    EXPECT_EQ(bones_of(nlohmann::json::parse(wrong)), Named{}) << wrong;
}

TEST(Retarget, TheSameSkeletonGetsTheSameCurves) {
  Character c = still_mannequin();
  add_clips_of(mannequin(), c);
  ASSERT_EQ(c.clips.size(), mannequin().clips.size());
  for (size_t i = 0; i < c.clips.size(); ++i) {
    ASSERT_EQ(c.clips[i].channels.size(), mannequin().clips[i].channels.size());
    for (size_t k = 0; k < c.clips[i].channels.size(); ++k) {
      EXPECT_EQ(c.clips[i].channels[k].values, mannequin().clips[i].channels[k].values);
      EXPECT_EQ(c.clips[i].channels[k].times, mannequin().clips[i].channels[k].times);
    }
    EXPECT_TRUE(c.clips[i].borrowed);
  }
  EXPECT_TRUE(c.warnings.empty()) << c.warnings.front();
}

TEST(Retarget, OtherNamesOfBonesMoveAlike) {
  Character c = still_mannequin();
  rename(c, mixamo_name);
  add_clips_of(mannequin(), c);
  EXPECT_LT(worst_of_all_clips(c), 2e-4);  // curves between their keys: the rests are the same
  EXPECT_GT(worst_vertex(c, require_clip(c, "walk"), "run", [](const glm::dvec3& v) { return v; }), 0.1);
}

TEST(Retarget, AnotherUnitAnotherUpAxisAndAnotherFrontMoveAlike) {
  // A skeleton in centimetres with z up below an armature, and one that faces -Z, as exporters write them.
  Character c = still_mannequin();
  rename(c, mixamo_name);
  Node armature;
  armature.name = "Armature";
  armature.rotation = glm::angleAxis(-kPi / 2, glm::dvec3(1, 0, 0));
  armature.scale = glm::dvec3(0.02);
  put_on_top(c, armature);
  Node& hips = node(c, "mixamorig:Hips");
  const glm::dquat to_z_up = glm::angleAxis(kPi / 2, glm::dvec3(1, 0, 0));
  hips.translation = to_z_up * hips.translation * 100.0;
  hips.rotation = to_z_up * hips.rotation;
  for (Node& n : c.skeleton.nodes)
    if (n.name != "Armature" && n.name != "mixamorig:Hips") n.translation *= 100.0;
  for (Joint& joint : c.skeleton.joints)
    joint.inverse_bind = glm::scale(glm::dmat4(1.0), glm::dvec3(100.0)) * joint.inverse_bind;
  Character twice = c;
  add_clips_of(mannequin(), twice);
  EXPECT_LT(worst_of_all_clips(twice, [](const glm::dvec3& v) { return 2.0 * v; }), 4e-4);

  Node turned;
  turned.name = "turned";
  turned.rotation = glm::angleAxis(kPi, glm::dvec3(0, 1, 0));
  put_on_top(c, turned);
  add_clips_of(mannequin(), c);
  EXPECT_LT(worst_of_all_clips(c, [](const glm::dvec3& v) { return glm::dvec3(-2 * v.x, 2 * v.y, -2 * v.z); }), 4e-4);
}

// Names by themselves, or told by the user bone by bone, where they say nothing.
class RetargetRest : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Bones, RetargetRest, testing::Bool(),
                         [](const auto& test) { return test.param ? "Told" : "Named"; });

TEST_P(RetargetRest, ArmsAndLegsPointWhereTheSourcesDo) {
  // The rest has its arms raised by 40 degrees and its legs apart.
  Character c = still_mannequin();
  rename(c, mixamo_name);
  const auto turn = [&](const std::string& name, double degrees) {
    Node& n = node(c, name);
    n.rotation = glm::angleAxis(degrees * kPi / 180, glm::dvec3(0, 0, 1)) * n.rotation;
  };
  turn("mixamorig:LeftArm", 40);
  turn("mixamorig:RightArm", -40);
  turn("mixamorig:LeftUpLeg", 15);
  turn("mixamorig:RightUpLeg", -15);
  RetargetOptions options;
  if (GetParam()) {
    for (Node& n : c.skeleton.nodes) n.name = "joint " + std::to_string(&n - c.skeleton.nodes.data());
    for (size_t i = 0; i < c.skeleton.nodes.size(); ++i)
      options.bones.push_back(c.skeleton.nodes[i].name + "=" + mannequin().skeleton.nodes[i].name);
  }
  add_clips_of(mannequin(), c, options);
  const auto direction = [](const Character& of, int clip, double time, int a, int b) {
    const auto world = node_matrices(of, clip, time);
    return glm::normalize(glm::dvec3(world[static_cast<size_t>(b)][3] - world[static_cast<size_t>(a)][3]));
  };
  const int walk = require_clip(c, "walk");
  const int own = require_clip(mannequin(), "walk");
  for (const auto& [upper, lower] : {std::pair{"upper_arm_l", "forearm_l"},
                                     {"forearm_l", "hand_l"},
                                     {"upper_arm_r", "forearm_r"},
                                     {"thigh_l", "shin_l"},
                                     {"shin_r", "foot_r"}})
    for (const double time : {0.0, 0.2, 0.5, 0.9}) {
      const glm::dvec3 is = direction(c, walk, time, node_named(mannequin(), upper), node_named(mannequin(), lower));
      const glm::dvec3 wanted =
          direction(mannequin(), own, time, node_named(mannequin(), upper), node_named(mannequin(), lower));
      EXPECT_LT(glm::length(is - wanted), 1e-3) << upper << " at " << time;
    }
}

TEST(Retarget, FeetThatHangOnTheRootFollowTheShins) {
  // As in rigs that were driven by inverse kinematics.
  Character c = still_mannequin();
  rename(c, mixamo_name);
  const auto rest = node_matrices(c, -1, 0.0);
  for (const char* foot : {"mixamorig:LeftFoot", "mixamorig:RightFoot"}) {
    const int index = node_named(c, foot);
    Node& n = c.skeleton.nodes[static_cast<size_t>(index)];
    const glm::dmat4& world = rest[static_cast<size_t>(index)];
    n.parent = -1;
    n.translation = glm::dvec3(world[3]);
    n.rotation = glm::quat_cast(glm::dmat3(world));
  }
  add_clips_of(mannequin(), c);
  // Between keys, 1/60 s apart, a foot that swings goes along a line in place of an arc.
  EXPECT_LT(worst_of_all_clips(c), 5e-4);
}

TEST(Retarget, MeshesNamedLikeBonesAreNone) {
  Character c = still_mannequin();
  rename(c, mixamo_name);
  for (const char* name : {"hips", "LeftLeg", "mixamorig:RightArm"}) {
    Node mesh;
    mesh.name = name;
    c.skeleton.nodes.push_back(mesh);
  }
  add_clips_of(mannequin(), c);
  EXPECT_LT(worst_of_all_clips(c), 2e-4);
}

TEST(Retarget, GoesAsFastAsItsLegsAreLong) {
  Character c = still_mannequin();
  rename(c, mixamo_name);
  for (Node& n : c.skeleton.nodes) n.translation *= 0.5;
  for (Joint& joint : c.skeleton.joints)
    joint.inverse_bind = glm::scale(glm::dmat4(1.0), glm::dvec3(0.5)) * joint.inverse_bind;
  add_clips_of(mannequin(), c);
  normalise(c, {.height = std::nullopt});
  const ClipMotion& own = mannequin().motion[static_cast<size_t>(require_clip(mannequin(), "walk"))];
  const ClipMotion& lent = c.motion[static_cast<size_t>(require_clip(c, "walk"))];
  ASSERT_GT(own.ground_speed, 0.5);
  EXPECT_NEAR(lent.ground_speed, 0.5 * own.ground_speed, 0.01);
  EXPECT_EQ(lent.direction, own.direction);
}

TEST(Retarget, WhoFacesBackwardGoesWhereItLooks) {
  // As VRM 0.x files do; their clips stay in place.
  Character c = still_mannequin();
  rename(c, mixamo_name);
  Node turned;
  turned.name = "turned";
  turned.rotation = glm::angleAxis(kPi, glm::dvec3(0, 1, 0));
  put_on_top(c, turned);
  add_clips_of(mannequin(), c);
  const size_t walk = static_cast<size_t>(require_clip(c, "walk"));
  ASSERT_TRUE(c.clips[walk].ground_velocity);
  EXPECT_LT(c.clips[walk].ground_velocity->y, -0.5) << "along -Z of its file";
  normalise(c, {.height = std::nullopt});
  EXPECT_EQ(c.warnings.size(), 1U) << "turned by a guess, which is said";
  const glm::dvec2 direction = c.motion[walk].direction;
  EXPECT_NEAR(direction.x, 0, 1e-6);
  EXPECT_NEAR(direction.y, 1, 1e-6);
}

TEST(Retarget, NamesThatTheUserGivesComeFirst) {
  Character c = still_mannequin();
  rename(c, [](const std::string& name) { return "part_" + std::to_string(std::hash<std::string>{}(name) % 100000); });
  Character again = c;
  EXPECT_THROW(add_clips_of(mannequin(), again), Error);  // nothing in common
  RetargetOptions options;
  for (const Node& n : mannequin().skeleton.nodes)
    options.bones.push_back("part_" + std::to_string(std::hash<std::string>{}(n.name) % 100000) + "=" + n.name);
  add_clips_of(mannequin(), c, options);
  EXPECT_LT(worst_of_all_clips(c), 2e-4);
}

TEST(Retarget, SaysWhatHasNoCounterpart) {
  Character c = still_mannequin();
  rename(c, mixamo_name);
  node(c, "mixamorig:LeftHand").name = "hook";
  add_clips_of(mannequin(), c);
  ASSERT_EQ(c.warnings.size(), 1U);
  EXPECT_NE(c.warnings[0].find("1 that it moves have no counterpart here: hand_l"), std::string::npos) << c.warnings[0];
}

TEST(Retarget, NamesOfClipsStayApartAndTheDefaultIsABorrowedOne) {
  Character c = mannequin();
  add_clips_of(mannequin(), c);
  const size_t own = mannequin().clips.size();
  ASSERT_EQ(c.clips.size(), 2 * own);
  EXPECT_EQ(c.clips[own].name, mannequin().clips[0].name + " (mannequin)");
  normalise(c, {});
  EXPECT_GE(c.placement.default_clip, static_cast<int>(own));
  EXPECT_NE(c.clips[static_cast<size_t>(c.placement.default_clip)].name.find("walk"), std::string::npos);
}

void expect_refused(const Character& source, Character target, const RetargetOptions& options, const char* text) {
  const size_t clips = target.clips.size();
  try {
    add_clips_of(source, target, options);
    ADD_FAILURE() << "not refused: " << text;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    EXPECT_FALSE(error.advice.empty());
  }
  EXPECT_EQ(target.clips.size(), clips);
}

TEST(Retarget, RefusesWithAReason) {
  const Character target = still_mannequin();
  expect_refused(still_mannequin(), target, {}, "has no clip");
  expect_refused(mannequin(), target, {.bones = {"hips"}}, "'hips' is not a pair");
  expect_refused(mannequin(), target, {.bones = {"hips=hipss"}}, "no node named hipss");
  expect_refused(mannequin(), target, {.bones = {"hipz=hips"}}, "no node named hipz");
  expect_refused(mannequin(), target, {.bones = {}, .keys = 10'000'000, .clips = 3}, "the limit is 3");
  Character named = still_mannequin();
  rename(named, mixamo_name);
  expect_refused(mannequin(), named, {.bones = {}, .keys = 1000}, "over 1000 numbers");
  Character mirrored = named;
  mirrored.skeleton.nodes[0].scale.x = -1;
  expect_refused(mannequin(), mirrored, {}, "is mirrored");
}

void write(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
  write_file(path, bytes.data(), bytes.size());
}

void rename_card_node(test::Builder& card, const std::filesystem::path& path) {
  card.doc["nodes"][2]["name"] = "wing";
  write(path, card.glb());
}

TEST(Retarget, AFileOfBonesAndClipsAloneIsEnough) {
  // The card's skeleton and clip, without its mesh; the card plays it as its own.
  const support::ScratchFolder folder;
  test::Builder whole = test::bending_card();
  write(folder.path() / "card.glb", whole.glb());
  whole.doc.erase("meshes");
  whole.doc["nodes"][0].erase("mesh");
  whole.doc["nodes"][0].erase("skin");
  whole.doc.erase("skins");
  whole.doc["animations"][0]["name"] = "from elsewhere";
  write(folder.path() / "bones.glb", whole.glb());
  Scenario scenario;
  scenario.characters[0].source = "card.glb";
  scenario.characters[0].animations = {"bones.glb"};
  scenario.characters[0].clips = {"from elsewhere"};
  const Cast cast = load_cast(scenario, folder.path());
  const Character& card = *cast.characters.front();
  const auto own = skin_positions(card.mesh, joint_matrices(card, require_clip(card, "wave"), 0.7));
  const auto lent = skin_positions(card.mesh, joint_matrices(card, require_clip(card, "from elsewhere"), 0.7));
  for (size_t v = 0; v < own.size(); ++v) EXPECT_LT(glm::length(own[v] - lent[v]), 1e-12);

  EXPECT_THROW(open_character((folder.path() / "bones.glb").string()), Error);  // nothing to draw
  // A pair is about the file that has its node.
  rename_card_node(whole, folder.path() / "other.glb");
  const Character both =
      open_character((folder.path() / "card.glb").string(), {},
                     {.animations = {(folder.path() / "bones.glb").string(), (folder.path() / "other.glb").string()},
                      .bones = {"arm=wing"}});
  EXPECT_EQ(both.clips.size(), 3U);
  EXPECT_THROW(open_character("mannequin", {}, {.animations = {}, .bones = {"a=b"}}), Error);
}

}  // namespace
}  // namespace crowdbench::scene
