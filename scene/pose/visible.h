// Geometry that no pose shows.
#pragma once
#include <cstddef>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct Invisible {
  size_t removed = 0;  // triangles
  bool all = false;    // nothing can be seen, and nothing was removed
};

// Removes from the mesh what cannot be seen: triangles of which their material, texture or vertex colours leave
// nothing, and those without area in the bind pose and in every clip, at its ends, in its middle and at the keys by
// which it scales (collapsed triangles, nodes scaled to nothing for good).
Invisible drop_invisible(Character& character);

}  // namespace crowdbench::scene
