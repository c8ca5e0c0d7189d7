// Based on: T. Gonzalez, "Clustering to minimize the maximum intercluster distance" (1985): farthest points first, of
// which every beginning covers within twice the least radius that any as many points could. Differs from the source:
// the distance is that in a disc's plane; places that a new point may reach are found by a grid as wide as the radius.
#include "renderers/surfel/surfel_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

namespace crowdbench::renderers {
namespace {

constexpr float kLeastCosine = 0.1F;
constexpr uint32_t kRanksBetweenReports = 256;
constexpr size_t kTime = 1000;

// Of kTime for `most` places, what the first `rank` take: each is compared with those around it, of which there are the
// fewer the more are chosen, n / rank.
size_t time_of(size_t rank, size_t most) {
  return static_cast<size_t>(kTime * std::log(static_cast<double>(rank)) / std::log(static_cast<double>(most) + 1));
}

// Places by the cubes that they lie in.
class Grid {
 public:
  Grid(std::span<const SurfacePlace> places, float cell) : cell_(std::max(cell, 1e-6F)) {
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

}  // namespace

float disc_distance(const SurfacePlace& from, const SurfacePlace& to) {
  return glm::distance(from.position, to.position) / std::max(glm::dot(from.normal, to.normal), kLeastCosine);
}

SurfelOrder order_places(std::span<const SurfacePlace> places, size_t count, const BakeProgress& progress) {
  SurfelOrder out;
  const size_t n = places.size();
  const size_t most = std::min(count, n);
  std::vector<float> gap(n, std::numeric_limits<float>::max());  // to the nearest chosen place
  out.nearest.assign(n, 0);
  const auto reach = [&](uint32_t chosen, uint32_t rank, uint32_t i) {
    const float d = disc_distance(places[chosen], places[i]);
    if (d >= gap[i]) return false;
    gap[i] = d;
    out.nearest[i] = rank;
    return true;
  };
  out.order.push_back(0);
  for (uint32_t i = 0; i < n; ++i) (void)reach(0, 0, i);
  // Gaps that have shrunk since leave their older entries behind.
  using Entry = std::pair<float, uint32_t>;
  const auto later = [](const Entry& a, const Entry& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  };
  std::priority_queue<Entry, std::vector<Entry>, decltype(later)> queue(later);
  for (uint32_t i = 0; i < n; ++i) queue.push({gap[i], i});
  Grid grid(places, queue.top().first);
  while (true) {
    while (queue.top().first != gap[queue.top().second]) queue.pop();
    const float radius = queue.top().first;
    const uint32_t place = queue.top().second;
    out.radius.push_back(radius);
    if (out.order.size() == most || radius <= 0) return out;
    // No place lies farther than `radius`, so a new point takes none over from farther.
    if (radius < 0.5F * grid.cell()) grid = Grid(places, radius);
    const auto rank = static_cast<uint32_t>(out.order.size());
    if (progress && rank % kRanksBetweenReports == 1) progress(time_of(rank, most), kTime);
    out.order.push_back(place);
    grid.near(places[place].position, [&](uint32_t i) {
      if (reach(place, rank, i)) queue.push({gap[i], i});
    });
  }
}

}  // namespace crowdbench::renderers
