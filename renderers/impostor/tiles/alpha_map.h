// The alpha that a tile stores: coverage, mapped so that bilinear filtering passes one half over the area that is
// covered.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "renderers/impostor/tiles/tile.h"

namespace crowdbench::renderers {

struct StoredAlpha {
  std::vector<uint8_t> texels;  // rect.width x rect.height, bottom row first
  uint8_t empty = 0;            // of "nothing here", below one half
};

// coverage: [0, 1], rect.width x rect.height, bottom row first; beside it there is nothing. area: in texels, what is to
// pass the test `filtered alpha >= one half`. The coverage goes through one affine map, which commutes with bilinear
// filtering.
//   Where coverage is level, as patterns about as wide as a texel become, no contour encloses the area: those texels
//   are first roughened by a hash of their place, the same in every tile of a lattice.
// Coverage without any area, or an area of 0, gives the map of the identity.
StoredAlpha solve_stored_alpha(const TileRect& rect, std::span<const float> coverage, double area);

}  // namespace crowdbench::renderers
