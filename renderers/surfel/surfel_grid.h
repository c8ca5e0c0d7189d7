// Places of a surface, found by where they are.
#pragma once
#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "renderers/surfel/surfel_order.h"

namespace crowdbench::renderers {

// Places by the cubes that they lie in, `cell` metres wide.
class SurfaceGrid {
 public:
  SurfaceGrid(std::span<const SurfacePlace> places, float cell) : cell_(std::max(cell, 1e-6F)) {
    for (size_t i = 0; i < places.size(); ++i)
      cells_[key(cube(places[i].position))].push_back(static_cast<uint32_t>(i));
  }
  float cell() const { return cell_; }
  // Every place within a cell's width of a position, and others.
  template <typename Visit>
  void near(const glm::vec3& position, const Visit& visit) const {
    const glm::ivec3 at = cube(position);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (const auto found = cells_.find(key(at + glm::ivec3(x, y, z))); found != cells_.end())
            for (const uint32_t i : found->second) visit(i);
  }

 private:
  glm::ivec3 cube(const glm::vec3& p) const { return glm::ivec3(glm::floor(p / cell_)); }
  static uint64_t key(const glm::ivec3& c) {
    const auto bits = [](int v) { return static_cast<uint64_t>(static_cast<uint32_t>(v) & 0x1fffffU); };
    return bits(c.x) | bits(c.y) << 21U | bits(c.z) << 42U;
  }
  float cell_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

}  // namespace crowdbench::renderers
