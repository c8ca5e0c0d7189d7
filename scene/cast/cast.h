// Cast: the characters of a scenario, loaded, with the banks that pose them.
#pragma once
#include <memory>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::scene {

struct Cast {
  std::vector<std::shared_ptr<const Character>> characters;
  std::vector<std::shared_ptr<const PoseBank>> banks;
  std::vector<double> shares;  // of the crowd, by character; they sum to 1
};

}  // namespace crowdbench::scene
