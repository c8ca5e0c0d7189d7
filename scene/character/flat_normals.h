// Normals for meshes that come without.
#pragma once
#include <cstddef>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Gives the vertices of a mesh's last primitive (first_vertex and first_index to the ends) the normals of their faces;
// a vertex whose faces point apart is doubled at the end. False when that takes more than `most` vertices in the mesh,
// which is then unfinished.
bool add_flat_normals(Mesh& mesh, const Primitive& primitive, size_t most);

}  // namespace crowdbench::scene
