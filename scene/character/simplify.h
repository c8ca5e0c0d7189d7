// A character with fewer triangles: a cheap stand-in where only its outline counts.
#pragma once
#include <cstddef>

#include "scene/character/character.h"

namespace crowdbench::scene {

// The same skeleton, clips, placement and vertices, with about `triangles` triangles over all primitives in proportion
// to their own (at least four each, at most what they had). Everything is double-sided and the outline is kept within a
// few percent; textures and normals are not looked after. Deterministic.
Character simplified(const Character& character, size_t triangles);

}  // namespace crowdbench::scene
