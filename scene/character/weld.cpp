#include "scene/character/weld.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace crowdbench::scene {
namespace {

struct CellHash {
  size_t operator()(const glm::i64vec3& c) const {
    const glm::u64vec3 u(c);  // whose products wrap
    return static_cast<size_t>(u.x * 73856093 ^ u.y * 19349663 ^ u.z * 83492791);
  }
};

}  // namespace

std::vector<uint32_t> weld(std::span<const std::vector<glm::vec3>> poses, float near) {
  const std::vector<glm::vec3>& first = poses.front();
  std::vector<uint32_t> out(first.size());
  const auto same_place = [&](uint32_t a, uint32_t b) {
    return std::ranges::all_of(poses, [&](const std::vector<glm::vec3>& pose) {
      const glm::vec3 apart = glm::abs(pose[a] - pose[b]);
      return std::max({apart.x, apart.y, apart.z}) <= near;
    });
  };
  // Cells of twice the distance: whatever is near lies in the cell or in the next one on its side, each way.
  const double cell = std::max(2.0 * static_cast<double>(near), 1e-30);
  std::unordered_map<glm::i64vec3, std::vector<uint32_t>, CellHash> cells;
  for (uint32_t v = 0; v < first.size(); ++v) {
    out[v] = v;
    glm::i64vec3 own;
    glm::i64vec3 side;
    for (int i = 0; i < 3; ++i) {
      const double at = static_cast<double>(first[v][i]) / cell;
      own[i] = static_cast<int64_t>(std::clamp(std::floor(at), -9e18, 9e18));
      side[i] = at - std::floor(at) < 0.5 ? -1 : 1;
    }
    for (int corner = 0; corner < 8 && out[v] == v; ++corner) {
      glm::i64vec3 there = own;
      for (int i = 0; i < 3; ++i)
        if ((corner >> i & 1) != 0) there[i] += side[i];
      const auto found = cells.find(there);
      if (found == cells.end()) continue;
      for (const uint32_t other : found->second)
        if (same_place(other, v)) {
          out[v] = other;
          break;
        }
    }
    if (out[v] == v) cells[own].push_back(v);
  }
  return out;
}

}  // namespace crowdbench::scene
