// A small character from any bytes: boxes' worth of triangles on a few joints, often degenerate, always of the shape
// that loading leaves (Mesh and Skeleton of scene/character/character.h).
#pragma once
#include <cstddef>
#include <cstdint>

#include "scene/character/character.h"

namespace crowdbench::fuzz {

// 1 to 5 joints in a random tree, 3 to 24 vertices of up to 4 influences, 1 to 16 triangles of which some have no area,
// one or two materials, up to one clip of translations, rotations and scales (0 and negative ones too). Places lie on a
// coarse lattice within a metre, times 1e-3, 1 or 1e3. Not normalised yet.
scene::Character random_character(const uint8_t* data, size_t size);

}  // namespace crowdbench::fuzz
