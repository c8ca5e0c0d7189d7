// A hierarchy of boxes over triangles, in double. What it leaves out cannot be hit (Ray::meets), so that it finds what
// trying every triangle finds, bit for bit.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "truth/ray.h"

namespace crowdbench::truth {

struct ClosestHit {
  TriangleHit hit;
  uint32_t triangle = ~0U;  // none
  bool found() const { return triangle != ~0U; }
  // Nearer, or as near and earlier: a total order, so that the closest hit does not depend on which is tried first.
  bool before(const ClosestHit& other) const {
    return hit.t < other.hit.t || (hit.t == other.hit.t && triangle < other.triangle);
  }
};

class Bvh {
 public:
  // positions, indices (three a triangle): finite; both must outlive this.
  Bvh(std::span<const glm::dvec3> positions, std::span<const uint32_t> indices);

  // The first triangle with t in [from, to] that `accept(triangle, hit)` takes. accept may be asked about triangles
  // that lie behind the result, and its answers must not depend on the order.
  template <typename Accept>
  ClosestHit closest(const Ray& ray, double from, double to, const Accept& accept) const {
    ClosestHit best;
    if (nodes_.empty()) return best;
    std::array<uint32_t, 64> stack;
    size_t top = 0;
    stack[top++] = 0;
    double start = 0;
    while (top > 0) {
      const uint32_t at = stack[--top];
      const Node& node = nodes_[at];
      if (!ray.meets(node.low, node.high, start) || start > to || start > best.hit.t) continue;
      if (node.count == 0) {
        // What begins nearer is looked at first.
        double left = 0;
        double right = 0;
        ray.meets(nodes_[at + 1].low, nodes_[at + 1].high, left);
        ray.meets(nodes_[node.next].low, nodes_[node.next].high, right);
        stack[top++] = left <= right ? node.next : at + 1;
        stack[top++] = left <= right ? at + 1 : node.next;
        continue;
      }
      for (uint32_t i = node.next; i < node.next + node.count; ++i)
        try_triangle(ray, order_[i], from, to, accept, best);
    }
    return best;
  }

  // The same by trying every triangle.
  template <typename Accept>
  ClosestHit closest_of_all(const Ray& ray, double from, double to, const Accept& accept) const {
    ClosestHit best;
    for (uint32_t triangle = 0; triangle < order_.size(); ++triangle)
      try_triangle(ray, triangle, from, to, accept, best);
    return best;
  }

 private:
  // count 0: the children are the next node and `next`; else triangles order_[next] and on.
  struct Node {
    glm::dvec3 low, high;
    uint32_t next = 0;
    uint32_t count = 0;
  };
  void build(uint32_t first, uint32_t count, std::span<const glm::dvec3> middles);

  template <typename Accept>
  void try_triangle(const Ray& ray, uint32_t triangle, double from, double to, const Accept& accept,
                    ClosestHit& best) const {
    const uint32_t* corners = indices_.data() + size_t{3} * triangle;
    ClosestHit one;
    one.triangle = triangle;
    if (ray.hits(positions_[corners[0]], positions_[corners[1]], positions_[corners[2]], one.hit) &&
        one.hit.t >= from && one.hit.t <= to && one.before(best) && accept(triangle, one.hit))
      best = one;
  }

  std::span<const glm::dvec3> positions_;
  std::span<const uint32_t> indices_;
  std::vector<uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace crowdbench::truth
