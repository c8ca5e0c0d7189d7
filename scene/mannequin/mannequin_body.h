// The measures and pieces that the built-in character is made of, shared by its mesh, its texture and its motion.
// Internal to scene.
#pragma once
#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "scene/character/character.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::scene::mannequin {

// Landmarks of an adult of 1.75 m, metres, bind pose: arms 45 degrees down, facing +Z, the left side at +X.
// Proportions after the segment lengths of D. A. Winter, "Biomechanics and Motor Control of Human Movement", 4th
// edition (2009), figure 4.1, rounded.
inline constexpr double kHeight = 1.75;
inline constexpr double kHipY = 0.925;
inline constexpr double kHipX = 0.092;
inline constexpr double kKneeY = 0.497;
inline constexpr double kAnkleY = 0.082;
inline constexpr double kAnkleZ = -0.012;
inline constexpr double kBallZ = 0.118;  // of the foot, ahead of the hips
inline constexpr double kBallY = 0.022;
inline constexpr double kHeelZ = -0.072;  // where the heel touches first
inline constexpr glm::dvec3 kShoulder{0.166, 1.412, -0.014};
inline constexpr double kHalfRoot = 0.70710678118654752;
inline constexpr glm::dvec3 kArmAxis{kHalfRoot, -kHalfRoot, 0.0};  // from the shoulder to the fingers
inline constexpr glm::dvec3 kArmUp{kHalfRoot, kHalfRoot, 0.0};     // away from the body; -kArmUp is the palm's side
inline constexpr double kUpperArm = 0.285;
inline constexpr double kForearm = 0.255;

enum Slot : uint8_t { skin, hair, shirt, trousers, shoes };
inline constexpr int kSlotCount = 5;

// Indices into Skeleton::joints, the same in both skeletons; the 53-joint one has more behind these. `side` is 0 for
// the left, 1 for the right.
enum JointId : uint8_t { hips, spine, chest, head, left_arm, right_arm = left_arm + 4, left_leg = 12, right_leg = 16 };
constexpr int clavicle(int side) { return left_arm + 4 * side; }
constexpr int upper_arm(int side) { return left_arm + 4 * side + 1; }
constexpr int forearm(int side) { return left_arm + 4 * side + 2; }
constexpr int hand(int side) { return left_arm + 4 * side + 3; }
constexpr int thigh(int side) { return left_leg + 4 * side; }
constexpr int shin(int side) { return left_leg + 4 * side + 1; }
constexpr int foot(int side) { return left_leg + 4 * side + 2; }
constexpr int toes(int side) { return left_leg + 4 * side + 3; }
inline constexpr int kBaseJoints = 20;
// Only in the 53-joint skeleton.
inline constexpr int kNeck = 20;
constexpr int forearm_twist(int side) { return 21 + side; }
constexpr int finger(int side, int digit, int bone) { return 23 + 15 * side + 3 * digit + bone; }  // digit 0: thumb
inline constexpr int kFullJoints = 53;

struct JointPlace {
  std::string name;
  int parent;           // joint index, -1 for the hips
  glm::dvec3 position;  // bind pose, world
};
// One for each joint, by joint index (a parent's index may be the higher one in the 53-joint skeleton).
std::vector<JointPlace> joint_places(int joints);

// A finger in the bind pose: where its three bones start and where it ends.
std::array<glm::dvec3, 4> finger_chain(int side, int digit);

// A rectangle of the texture, in texels of a 1024-texel side; surfaces use it inset by kGutter.
struct Chart {
  int x, y, width, height;
};
inline constexpr int kTextureSide = 1024;
inline constexpr int kGutter = 6;
enum ChartId : uint8_t {
  chart_head,
  chart_hair,
  chart_torso,
  chart_sleeve,
  chart_arm,
  chart_finger,
  chart_ear,
  chart_pelvis,
  chart_leg,
  chart_shoe,
  chart_sole,
  kCharts
};
const Chart& chart(int id);
// u, v in [0, 1] inside the chart, v = 0 at its top row -> texture coordinates.
glm::dvec2 chart_uv(int id, double u, double v);

// Surfaces that the painter looks at too. u in [0, 1] runs once around from the back over the left side, v from the
// bottom (0) to the top (1).
glm::dvec3 head_point(double u, double v);
glm::dvec3 hair_point(double u, double v);
glm::dvec3 torso_point(double u, double v);

// 0 before `from`, 1 after `to` (which may be the lower one), cubic in between.
inline double smooth(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// Positions, normals, uvs, joints, weights, indices and one primitive for each material.
Mesh make_mesh(int triangles, int joints);
Image8 make_texture();
// walk, run, idle, wave for a skeleton whose nodes 0..joints-1 are given by `node_of_joint`.
std::vector<Clip> make_clips(int joints, const std::vector<int>& node_of_joint);

}  // namespace crowdbench::scene::mannequin
