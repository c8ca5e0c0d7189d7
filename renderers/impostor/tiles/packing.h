// Packing of rectangles into the layers of an array texture.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace crowdbench::renderers {

struct PackSize {
  int width = 0;  // texels, gutters included; 0 in either: nothing is placed
  int height = 0;
};
struct PackPlace {
  int x = 0;  // texels
  int y = 0;
  int layer = -1;  // -1: nothing was placed
};
struct Packing {
  int width = 0;   // of every layer, texels
  int height = 0;  // smaller than asked when everything fits in one lower layer
  int layers = 0;
  std::vector<PackPlace> places;  // one a size, no two overlap
};

// Shelves of falling height, deterministic. Layers are `side` texels square, larger where a rectangle needs it, smaller
// where everything fits in less; sides are multiples of four, for block compression.
Packing pack_tiles(std::span<const PackSize> sizes, int side);

// The same in layers of the size, from 256 to 1024 texels square, that takes the fewest texels in all.
Packing pack_tightly(std::span<const PackSize> sizes);

// Shelves in the order given, and a new layer wherever the group changes: what belongs together lies in few layers, and
// where a rectangle lies does not depend on what follows its group. groups: one a size, ascending. Layers are
// width x height (rounded up to multiples of four), larger where a rectangle needs it.
Packing pack_in_order(std::span<const PackSize> sizes, std::span<const int> groups, int width, int height);

}  // namespace crowdbench::renderers
