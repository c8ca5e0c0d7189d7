// Based on: the hierarchy of median splits along the longest axis of the triangles' middles, as textbooks have it.
#include "truth/bvh.h"

#include <algorithm>
#include <numeric>

namespace crowdbench::truth {
namespace {

constexpr uint32_t kLeaf = 4;  // triangles

}  // namespace

Bvh::Bvh(std::span<const glm::dvec3> positions, std::span<const uint32_t> indices)
    : positions_(positions), indices_(indices), order_(indices.size() / 3) {
  if (order_.empty()) return;
  std::iota(order_.begin(), order_.end(), 0U);
  std::vector<glm::dvec3> middles(order_.size());
  for (size_t i = 0; i < middles.size(); ++i)
    middles[i] = positions[indices[3 * i]] + positions[indices[3 * i + 1]] + positions[indices[3 * i + 2]];
  nodes_.reserve(order_.size());
  build(0, static_cast<uint32_t>(order_.size()), middles);
}

void Bvh::build(uint32_t first, uint32_t count, std::span<const glm::dvec3> middles) {
  const size_t at = nodes_.size();
  nodes_.emplace_back();
  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high = -low;
  glm::dvec3 least = low;
  glm::dvec3 most = high;
  for (uint32_t i = first; i < first + count; ++i) {
    const uint32_t* corners = indices_.data() + size_t{3} * order_[i];
    for (int k = 0; k < 3; ++k) {
      low = glm::min(low, positions_[corners[k]]);
      high = glm::max(high, positions_[corners[k]]);
    }
    least = glm::min(least, middles[order_[i]]);
    most = glm::max(most, middles[order_[i]]);
  }
  nodes_[at].low = low;
  nodes_[at].high = high;
  if (count <= kLeaf) {
    nodes_[at].next = first;
    nodes_[at].count = count;
    return;
  }
  const glm::dvec3 size = most - least;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](uint32_t a, uint32_t b) {
    return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis] : a < b;
  });
  build(first, half, middles);
  nodes_[at].next = static_cast<uint32_t>(nodes_.size());
  build(first + half, count - half, middles);
}

}  // namespace crowdbench::truth
