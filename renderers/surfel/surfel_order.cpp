// Based on: T. Gonzalez, "Clustering to minimize the maximum intercluster distance" (1985): farthest points first, of
// which every beginning covers within twice the least radius that any as many points could. Differs from the source:
// the distance is that in a disc's plane; places that a new point may reach are found by a grid as wide as the radius.
#include "renderers/surfel/surfel_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "renderers/surfel/surfel_grid.h"

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
  SurfaceGrid grid(places, queue.top().first);
  while (true) {
    while (queue.top().first != gap[queue.top().second]) queue.pop();
    const float radius = queue.top().first;
    const uint32_t place = queue.top().second;
    out.radius.push_back(radius);
    if (out.order.size() == most || radius <= 0) return out;
    // No place lies farther than `radius`, so a new point takes none over from farther.
    if (radius < 0.5F * grid.cell()) grid = SurfaceGrid(places, radius);
    const auto rank = static_cast<uint32_t>(out.order.size());
    if (progress && rank % kRanksBetweenReports == 1) progress(time_of(rank, most), kTime);
    out.order.push_back(place);
    grid.near(places[place].position, [&](uint32_t i) {
      if (reach(place, rank, i)) queue.push({gap[i], i});
    });
  }
}

}  // namespace crowdbench::renderers
