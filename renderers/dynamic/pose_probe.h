// The pose test of dynamic impostors: how much the distances between a few points of the body have changed.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// A point of a joint: the mean of the vertices that the joint moves, by their weights; bind space.
struct JointPoint {
  uint32_t joint = 0;
  glm::vec3 place{0.0F};
};

// At most `count` points: that of the joint that moves most of the body, then always the one whose distances from all
// before it change most over the poses of the bank, by the one that changes least. Fewer where no other moves so.
std::vector<JointPoint> choose_joint_points(const scene::Character& character, const scene::PoseBank& bank,
                                            size_t count);

// The distances of all pairs of a character's points in any pose of its bank.
class PoseProbe {
 public:
  PoseProbe(const scene::PoseBank& bank, const std::vector<JointPoint>& points);
  // Metres, pair by pair, in the order (1, 0), (2, 0), (2, 1), (3, 0), ...
  std::vector<float> distances(const scene::PoseSample& pose) const;

 private:
  size_t points_ = 0;
  std::vector<glm::vec3> places_;  // by sample of the bank and point: a pose's are the blend of two samples'
};

// The largest change of a distance, metres. Both of the same probe.
float largest_change(const std::vector<float>& a, const std::vector<float>& b);

// What a threshold of the pose test means for one agent that plays the bank's clips at 60 frames a second and is seen
// from the same side: how often its tile is drawn anew, and how far what it shows is from its own pose.
struct PoseStaleness {
  double refreshes = 0;  // a second
  double rms = 0;        // metres, over vertices and frames
  double max = 0;
};
PoseStaleness pose_staleness(const scene::Character& character, const scene::PoseBank& bank, const PoseProbe& probe,
                             double threshold);

}  // namespace crowdbench::renderers
