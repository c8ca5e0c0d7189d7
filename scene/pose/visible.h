// Geometry that no pose shows.
#pragma once
#include <cstddef>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Removes from the mesh what cannot be seen: triangles of which their material, texture or vertex colours leave
// nothing, and those without area in the bind pose and in every clip, at its ends, in its middle and at the keys by
// which it scales (collapsed triangles, nodes scaled to nothing for good). Returns how many. Where nothing would be
// left, nothing is removed.
size_t drop_invisible(Character& character);
// Whether the materials alone leave nothing to see.
bool nothing_seen(const Character& character);

}  // namespace crowdbench::scene
