// Where a character faces, by what it looks like.
#pragma once
#include <cstdint>
#include <span>

#include "scene/character/character.h"

namespace crowdbench::scene {

enum class Facing : uint8_t { unclear, plus_z, minus_z };

// From the bind pose: toes reach farther from the ankle than heels; where feet do not tell, a nose stands out from the
// head. posed: the mesh in that pose, what no clip shows put aside (scene/pose/hidden.h); soles: vertices that can
// touch the ground.
Facing compute_facing(const Character& character, std::span<const glm::dvec3> posed, std::span<const uint32_t> soles);

}  // namespace crowdbench::scene
