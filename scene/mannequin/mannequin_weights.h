// Skin weights of the built-in character's surface, by position in the bind pose. Internal to scene.
#pragma once
#include <vector>

#include "scene/mannequin/mannequin_body.h"

namespace crowdbench::scene::mannequin {

struct Influence {
  int joint;
  double weight;
};
using Influences = std::vector<Influence>;

// Weights sum to 1. full: of the 53-joint skeleton.
Influences torso_weights(const glm::dvec3& p, bool sleeve);
Influences leg_weights(const glm::dvec3& p);
Influences shoe_weights(const glm::dvec3& p);
Influences head_weights(const glm::dvec3& p, bool full);
Influences arm_weights(const glm::dvec3& p, bool full);
// Along one finger, or over the mitten (digit -1) by the nearest finger.
Influences finger_weights(const glm::dvec3& p, int digit);

}  // namespace crowdbench::scene::mannequin
