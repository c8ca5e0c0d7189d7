#include "scene/mannequin/mannequin_shape.h"

namespace crowdbench::scene::mannequin {

using glm::dvec3;

std::array<dvec3, 4> finger_chain(int side, int digit) {
  std::array<dvec3, 4> chain{};
  std::array<dvec3, 3> directions{};
  std::array<double, 3> lengths{};
  if (digit == 0) {
    chain[0] = arm_point(kWrist + 0.030) + kForward * 0.028 + kPalm * 0.010;
    directions = {glm::normalize(kArmAxis * 0.72 + kForward * 0.58 + kPalm * 0.38),
                  glm::normalize(kArmAxis * 0.84 + kForward * 0.30 + kPalm * 0.45),
                  glm::normalize(kArmAxis * 0.90 + kForward * 0.12 + kPalm * 0.42)};
    lengths = {0.038, 0.030, 0.026};
  } else {
    constexpr double kSpread[] = {0.0, 0.0305, 0.0105, -0.0100, -0.0290};
    constexpr double kStart[] = {0.0, 0.094, 0.097, 0.094, 0.086};
    constexpr double kLength[] = {0.0, 0.074, 0.082, 0.076, 0.060};
    chain[0] = arm_point(kWrist + kStart[digit]) + kForward * kSpread[digit] + kPalm * 0.006;
    const double fan = kSpread[digit] * 1.2;
    directions = {glm::normalize(kArmAxis * 0.95 + kPalm * 0.31 + kForward * fan),
                  glm::normalize(kArmAxis * 0.80 + kPalm * 0.60 + kForward * fan * 0.5),
                  glm::normalize(kArmAxis * 0.64 + kPalm * 0.77)};
    lengths = {0.46 * kLength[digit], 0.31 * kLength[digit], 0.23 * kLength[digit]};
  }
  for (size_t i = 0; i < 3; ++i) chain[i + 1] = chain[i] + directions[i] * lengths[i];
  for (dvec3& p : chain) p = mirrored(p, side);
  return chain;
}

std::vector<JointPlace> joint_places(int joints) {
  std::vector<JointPlace> out(static_cast<size_t>(joints));
  const bool full = joints == kFullJoints;
  const auto put = [&](int id, const std::string& name, int parent, const dvec3& position) {
    out[static_cast<size_t>(id)] = {name, parent, position};
  };
  put(hips, "hips", -1, {0.0, 0.955, -0.005});
  put(spine, "spine", hips, {0.0, 1.070, -0.010});
  put(chest, "chest", spine, {0.0, 1.210, -0.016});
  put(head, "head", full ? kNeck : chest, {0.0, full ? 1.540 : 1.480, full ? -0.012 : -0.018});
  if (full) put(kNeck, "neck", chest, {0.0, 1.465, -0.020});
  for (int side = 0; side < 2; ++side) {
    const std::string end = side == 0 ? "_l" : "_r";
    const auto at = [&](const dvec3& p) { return mirrored(p, side); };
    put(clavicle(side), "clavicle" + end, chest, at({0.022, 1.425, -0.006}));
    put(upper_arm(side), "upper_arm" + end, clavicle(side), at(kShoulder));
    put(forearm(side), "forearm" + end, upper_arm(side), at(arm_point(kUpperArm)));
    put(hand(side), "hand" + end, forearm(side), at(arm_point(kWrist)));
    put(thigh(side), "thigh" + end, hips, at({kHipX, kHipY, -0.006}));
    put(shin(side), "shin" + end, thigh(side), at({kHipX + 0.004, kKneeY, 0.002}));
    put(foot(side), "foot" + end, shin(side), at({kHipX + 0.006, kAnkleY, kAnkleZ}));
    put(toes(side), "toes" + end, foot(side), at({kHipX + 0.012, kBallY, kBallZ}));
    if (!full) continue;
    put(forearm_twist(side), "forearm_twist" + end, forearm(side), at(arm_point(kUpperArm + 0.5 * kForearm)));
    constexpr const char* kDigits[] = {"thumb", "index", "middle", "ring", "little"};
    for (int digit = 0; digit < 5; ++digit) {
      const auto chain = finger_chain(side, digit);
      for (int bone = 0; bone < 3; ++bone) {
        put(finger(side, digit, bone), std::string(kDigits[digit]) + std::to_string(bone + 1) + end,
            bone == 0 ? hand(side) : finger(side, digit, bone - 1), chain[static_cast<size_t>(bone)]);
      }
    }
  }
  return out;
}

}  // namespace crowdbench::scene::mannequin
