// What a pose cache is worth and costs, reckoned without drawing.
#pragma once
#include <cstdint>

#include "renderers/posecache/key_choice.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// Key poses of every clip of a bank: `keys` of one that moves, 0: as many as the bank has samples of it.
std::vector<KeyCircle> key_circles(const scene::PoseBank& bank, uint32_t keys);
// How many there are of all clips.
uint32_t key_count(const std::vector<KeyCircle>& circles);

// Metres between a vertex where its own pose has it and where the blend of its two key poses has it, over vertices and
// poses: of agents spread evenly over every clip, between at most eight pairs of key poses, at four places in each. 0
// up to rounding where the key poses are all of the bank's samples: skinning is linear in the matrices.
struct BlendError {
  double rms = 0;
  double max = 0;
};
BlendError blend_error(const scene::Character& character, const scene::PoseBank& bank,
                       const std::vector<KeyCircle>& circles);

// Of `agents` agents, spread over clips and phases by a hash, at 60 frames a second: means over the second third of a
// second.
struct CacheTrade {
  double hits = 0;     // agents blended from the cache
  double skinned = 0;  // key poses
};
CacheTrade cache_trade(const scene::PoseBank& bank, const std::vector<KeyCircle>& circles, uint32_t slots,
                       KeyRule choice, double keep, uint32_t agents);

}  // namespace crowdbench::renderers
