// How far a pose that stands for others is from them.
#pragma once
#include <cstdint>

#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// Metres between a vertex where its own pose has it and where the shown one has it, over vertices and poses.
struct PoseError {
  double rms = 0;
  double max = 0;
};

// Of agents whose phases spread evenly over every clip of the bank, where each shows the nearest of `poses` phases of
// its clip: at most eight of those, at four distances from each on either side. A tenth of a second for long banks.
PoseError even_pose_error(const scene::Character& character, const scene::PoseBank& bank, uint32_t poses);

}  // namespace crowdbench::renderers
