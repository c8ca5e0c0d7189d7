// What of a mesh can be seen. The rest has no say: not in a character's height, ground, bounds or bakes.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Removes the triangles for which `seen` is false (three vertices each, and the primitive they are of), then the
// vertices that no triangle names and the primitives without triangles. Returns how many triangles it removed. Where
// none would be left it removes nothing.
size_t keep_drawn(Mesh& mesh, const std::function<bool(const uint32_t* corners, const Primitive& primitive)>& seen);

// Vertices, of which those that primitives share count once: alike in everything, each in another primitive.
size_t count_vertices(const Mesh& mesh);

}  // namespace crowdbench::scene
