// Vertices that are at one place, whatever else tells them apart.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// For each vertex the first one that is within `near` of it in every pose, itself where there is none.
// poses: positions by pose; all of the same vertices; at least one.
std::vector<uint32_t> weld(std::span<const std::vector<glm::vec3>> poses, float near);

}  // namespace crowdbench::scene
