// Based on: nothing but counting: places lie evenly by area on the surface and beside it, so that areas are numbers of
// places (Monte Carlo integration by a low-discrepancy sequence).
#include "renderers/surfel/surfel_border.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>

#include "renderers/surfel/surfel_grid.h"

namespace crowdbench::renderers {
namespace {

constexpr float kAlike = 0.5F;  // of two normals of one sheet
// Beside it there are places only so often, so that the nearest is farther than the border itself.
constexpr float kLeastReach = 0.25F;
constexpr float kNever = std::numeric_limits<float>::infinity();

struct Bits {
  size_t operator()(const std::array<float, 3>& p) const {
    size_t h = 0;
    for (const float v : p) h = h * 1000003U + std::hash<float>()(v);
    return h;
  }
};

// By vertex: the first vertex in the same place.
std::vector<uint32_t> weld(const std::vector<glm::vec3>& positions) {
  std::unordered_map<std::array<float, 3>, uint32_t, Bits> first;
  std::vector<uint32_t> out;
  for (const glm::vec3& p : positions)
    out.push_back(
        first.try_emplace({p.x + 0.0F, p.y + 0.0F, p.z + 0.0F}, static_cast<uint32_t>(out.size())).first->second);
  return out;
}

std::vector<SurfacePlace> places_of(std::span<const SheetPlace> sheet) {
  std::vector<SurfacePlace> out;
  for (const SheetPlace& s : sheet) out.push_back(s.place);
  return out;
}

}  // namespace

std::vector<std::array<bool, 3>> find_borders(const scene::Mesh& mesh) {
  const std::vector<uint32_t> welded = weld(mesh.positions);
  const size_t triangles = mesh.indices.size() / 3;
  const auto key = [](uint32_t a, uint32_t b) { return uint64_t{std::min(a, b)} << 32U | std::max(a, b); };
  std::unordered_map<uint64_t, int> faces;  // by edge
  std::set<std::array<uint32_t, 3>> seen;
  for (size_t t = 0; t < triangles; ++t) {
    std::array<uint32_t, 3> c{};
    for (size_t k = 0; k < 3; ++k) c[k] = welded[mesh.indices[3 * t + k]];
    std::array<uint32_t, 3> sorted = c;
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] == sorted[1] || sorted[1] == sorted[2] || !seen.insert(sorted).second) continue;
    for (size_t k = 0; k < 3; ++k) ++faces[key(c[k], c[(k + 1) % 3])];
  }
  std::vector<std::array<bool, 3>> out(triangles);
  for (size_t t = 0; t < triangles; ++t)
    for (size_t k = 0; k < 3; ++k) {
      const auto found = faces.find(key(welded[mesh.indices[3 * t + k]], welded[mesh.indices[3 * t + (k + 1) % 3]]));
      out[t][k] = found != faces.end() && found->second == 1;
    }
  return out;
}

std::vector<float> find_reaches(std::span<const SheetPlace> surfels, std::span<const SheetPlace> beside,
                                std::span<const SurfelLevel> levels) {
  std::vector<float> out(surfels.size(), kNever);
  if (beside.empty()) return out;
  const std::vector<SurfacePlace> ends = places_of(beside);
  size_t begin = 0;
  for (const SurfelLevel& level : levels) {
    const auto radius = static_cast<float>(2 * level.radius);
    const SurfaceGrid grid(ends, radius);
    for (size_t i = begin; i < level.points; ++i) {
      const SheetPlace& s = surfels[i];
      grid.near(s.place.position, [&](uint32_t k) {
        if (beside[k].primitive != s.primitive) return;
        const glm::vec3 to = ends[k].position - s.place.position;
        const float out_of_plane = std::abs(glm::dot(to, s.place.normal));
        const float along = std::sqrt(std::max(0.0F, glm::dot(to, to) - out_of_plane * out_of_plane));
        if (along < out_of_plane || along > radius || glm::dot(ends[k].normal, s.place.normal) < kAlike) return;
        out[i] = std::min(out[i], along);
      });
    }
    begin = level.points;
  }
  return out;
}

float fit_reach(std::span<const SheetPlace> surfels, std::span<const float> reaches, std::span<const SheetPlace> on,
                std::span<const SheetPlace> beside, float radius) {
  if (beside.empty()) return 1;
  std::vector<SurfacePlace> places = places_of(on);
  for (const SheetPlace& b : beside) places.push_back(b.place);
  // The factor from which on each is reached.
  std::vector<float> from(places.size(), kNever);
  const SurfaceGrid grid(places, radius);
  for (size_t i = 0; i < surfels.size(); ++i)
    grid.near(surfels[i].place.position, [&](uint32_t k) {
      if (reaches[i] <= 0) return;  // no factor makes it reach anything
      if (k >= on.size() && beside[k - on.size()].primitive != surfels[i].primitive) return;
      const float d = disc_distance(surfels[i].place, places[k]);
      if (d <= radius) from[k] = std::min(from[k], d / reaches[i]);
    });
  const auto middle = from.begin() + static_cast<std::ptrdiff_t>(on.size());
  std::sort(from.begin(), middle);
  std::sort(middle, from.end());
  // Of the places of the surface the last `missed` ones are missed, of those beside it the first `over` ones reached.
  float best = kLeastReach;
  for (auto b = middle; b != from.end() && *b < kNever; ++b) {
    const auto over = b - middle + 1;
    const auto missed = middle - std::upper_bound(from.begin(), middle, *b);
    if (over > missed) break;
    best = std::max(best, *b);
  }
  return best;
}

}  // namespace crowdbench::renderers
