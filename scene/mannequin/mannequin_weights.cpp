#include "scene/mannequin/mannequin_weights.h"

#include <cmath>
#include <tuple>

#include "scene/mannequin/mannequin_shape.h"

namespace crowdbench::scene::mannequin {

using glm::dvec3;

Influences torso_weights(const dvec3& p, bool sleeve) {
  const double lower = smooth(0.99, 1.13, p.y);
  const double upper = smooth(1.12, 1.28, p.y);
  const int side = p.x >= 0.0 ? 0 : 1;
  const double x = std::abs(p.x);
  double arm = smooth(0.110, 0.225, x) * (sleeve ? 1.0 : smooth(1.20, 1.34, p.y));
  const double t = glm::dot(dvec3(x, p.y, p.z) - kShoulder, kArmAxis);
  if (sleeve) arm = std::max(arm, smooth(-0.02, 0.09, t));
  const double collar = smooth(0.03, 0.13, x) * smooth(1.30, 1.43, p.y) * 0.8;
  const double neck = 0.35 * smooth(1.47, 1.51, p.y);
  Influences out{{upper_arm(side), arm}};
  const double body = 1.0 - arm;
  out.push_back({clavicle(side), body * collar});
  out.push_back({head, body * (1.0 - collar) * neck});
  const double rest = body * (1.0 - collar) * (1.0 - neck);
  out.push_back({hips, rest * (1.0 - lower)});
  out.push_back({spine, rest * lower * (1.0 - upper)});
  out.push_back({chest, rest * lower * upper});
  return out;
}

Influences leg_weights(const dvec3& p) {
  const double left = smooth(-0.035, 0.035, p.x);
  // The crease of the hip runs from the crotch up to the outer side.
  const double crease = 0.895 + 0.25 * (std::abs(p.x) - 0.09);
  double leg = smooth(crease + 0.075, crease - 0.075, p.y);
  leg *= 1.0 - 0.45 * (1.0 - std::abs(2.0 * left - 1.0));
  const double lower = smooth(kKneeY + 0.065, kKneeY - 0.065, p.y);
  const double up = smooth(0.99, 1.13, p.y);
  return {{hips, (1.0 - leg) * (1.0 - up)},       {spine, (1.0 - leg) * up},
          {thigh(0), leg * left * (1.0 - lower)}, {thigh(1), leg * (1.0 - left) * (1.0 - lower)},
          {shin(0), leg * left * lower},          {shin(1), leg * (1.0 - left) * lower}};
}

Influences shoe_weights(const dvec3& p) {
  const int side = p.x >= 0.0 ? 0 : 1;
  const double bend = smooth(kBallZ - 0.030, kBallZ + 0.030, p.z);
  const double above = 0.6 * smooth(0.075, 0.125, p.y);
  return {{toes(side), bend * (1.0 - above)}, {foot(side), (1.0 - bend) * (1.0 - above)}, {shin(side), above}};
}

Influences head_weights(const dvec3& p, bool full) {
  const double turn = smooth(1.455, 1.545, p.y);
  if (!full) return {{chest, 1.0 - turn}, {head, turn}};
  const double low = smooth(1.445, 1.490, p.y);
  const double high = smooth(1.490, 1.560, p.y);
  return {{chest, 1.0 - low}, {kNeck, low * (1.0 - high)}, {head, low * high}};
}

Influences arm_weights(const dvec3& p, bool full) {
  const int side = p.x >= 0.0 ? 0 : 1;
  const double t = glm::dot(dvec3(std::abs(p.x), p.y, p.z) - kShoulder, kArmAxis);
  const double bend = smooth(kUpperArm - 0.045, kUpperArm + 0.045, t);
  const double wrist = smooth(kWrist - 0.030, kWrist + 0.022, t);
  Influences out{{upper_arm(side), 1.0 - bend}, {hand(side), bend * wrist}};
  const double rest = bend * (1.0 - wrist);
  const double twist = full ? smooth(kUpperArm + 0.05, kWrist, t) : 0.0;
  out.push_back({forearm(side), rest * (1.0 - twist)});
  if (full) out.push_back({forearm_twist(side), rest * twist});
  return out;
}

Influences finger_weights(const dvec3& p, int digit) {
  const int side = p.x >= 0.0 ? 0 : 1;
  if (digit < 0) {
    double nearest = 1e9;
    for (int d = 1; d < 5; ++d) {
      const double distance = std::abs(finger_chain(side, d)[1].z - p.z);
      if (distance < nearest) std::tie(nearest, digit) = std::tuple{distance, d};
    }
  }
  const auto chain = finger_chain(side, digit);
  const auto past = [&](int bone) {
    const auto b = static_cast<size_t>(bone);
    const dvec3 along_bone = glm::normalize(chain[b + 1] - chain[b]);
    return smooth(-0.007, 0.007, glm::dot(p - chain[b], along_bone));
  };
  const double a = past(0);
  const double b = a * past(1);
  const double c = b * past(2);
  return {{hand(side), 1.0 - a},
          {finger(side, digit, 0), a - b},
          {finger(side, digit, 1), b - c},
          {finger(side, digit, 2), c}};
}

}  // namespace crowdbench::scene::mannequin
