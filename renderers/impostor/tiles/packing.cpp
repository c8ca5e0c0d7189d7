// Based on: first-fit decreasing height (Coffman, Garey, Johnson and Tarjan 1980): tiles of one character are nearly
// equal in height, which is where shelves waste least.
#include "renderers/impostor/tiles/packing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace crowdbench::renderers {

Packing pack_tiles(std::span<const PackSize> sizes, int side) {
  Packing packing;
  packing.places.resize(sizes.size());
  std::vector<uint32_t> order(sizes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::erase_if(order, [&](uint32_t i) { return sizes[i].width <= 0 || sizes[i].height <= 0; });
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    if (sizes[a].height != sizes[b].height) return sizes[a].height > sizes[b].height;
    if (sizes[a].width != sizes[b].width) return sizes[a].width > sizes[b].width;
    return a < b;
  });
  const auto multiple_of_four = [](int v) { return (v + 3) / 4 * 4; };
  // A few tiles fill less than a layer: it is no wider than makes them a square.
  double area = 0;
  for (const uint32_t i : order) area += static_cast<double>(sizes[i].width) * sizes[i].height;
  packing.width = multiple_of_four(std::min(side, static_cast<int>(std::sqrt(1.1 * area)) + 1));
  packing.height = multiple_of_four(side);
  for (const uint32_t i : order) {
    packing.width = std::max(packing.width, multiple_of_four(sizes[i].width));
    packing.height = std::max(packing.height, multiple_of_four(sizes[i].height));
  }
  struct Shelf {
    int layer, y, height, used;
  };
  std::vector<Shelf> shelves;
  std::vector<int> filled;  // height used, by layer
  for (const uint32_t i : order) {
    auto shelf = std::find_if(shelves.begin(), shelves.end(),
                              [&](const Shelf& s) { return s.used + sizes[i].width <= packing.width; });
    if (shelf == shelves.end()) {
      auto layer = std::find_if(filled.begin(), filled.end(),
                                [&](int used) { return used + sizes[i].height <= packing.height; });
      if (layer == filled.end()) layer = filled.insert(filled.end(), 0);
      shelf = shelves.insert(shelves.end(), {static_cast<int>(layer - filled.begin()), *layer, sizes[i].height, 0});
      *layer += sizes[i].height;
    }
    packing.places[i] = {shelf->used, shelf->y, shelf->layer};
    shelf->used += sizes[i].width;
  }
  packing.layers = static_cast<int>(filled.size());
  if (packing.layers == 1) packing.height = multiple_of_four(filled[0]);
  return packing;
}

Packing pack_in_order(std::span<const PackSize> sizes, std::span<const int> groups, int width, int height) {
  const auto multiple_of_four = [](int v) { return (v + 3) / 4 * 4; };
  Packing packing;
  packing.places.resize(sizes.size());
  for (const PackSize& s : sizes) {
    width = std::max(width, s.width);
    height = std::max(height, s.height);
  }
  packing.width = multiple_of_four(width);
  packing.height = multiple_of_four(height);
  int x = 0;
  int y = 0;
  int shelf = 0;
  int group = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    const PackSize& s = sizes[i];
    if (s.width <= 0 || s.height <= 0) continue;
    if (x + s.width > packing.width) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    if (packing.layers == 0 || groups[i] != group || y + std::max(shelf, s.height) > packing.height) {
      ++packing.layers;
      group = groups[i];
      x = y = shelf = 0;
    }
    packing.places[i] = {x, y, packing.layers - 1};
    x += s.width;
    shelf = std::max(shelf, s.height);
  }
  return packing;
}

Packing pack_tightly(std::span<const PackSize> sizes) {
  constexpr int kSmallest = 256;
  constexpr int kLargest = 1024;
  constexpr int kStep = 32;
  Packing best;
  uint64_t least = std::numeric_limits<uint64_t>::max();
  for (int side = kLargest; side >= kSmallest; side -= kStep) {
    Packing tried = pack_tiles(sizes, side);
    const uint64_t texels =
        static_cast<uint64_t>(tried.width) * static_cast<uint64_t>(tried.height) * static_cast<uint64_t>(tried.layers);
    if (texels >= least) continue;
    least = texels;
    best = std::move(tried);
  }
  return best;
}

}  // namespace crowdbench::renderers
