#include "renderers/polypostor/polypostor_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crowdbench::renderers {
namespace {

// What a part shows, at one sample a texel.
struct PartDepths {
  int x = 0, y = 0, width = 0, height = 0;  // texels; x and y: of the first column and row
  std::vector<uint8_t> covered;             // from either side
  std::vector<double> front;                // of what is seen from its outside, texels towards the eye; -inf: nothing
};

PartDepths depths_of(std::span<const uint32_t> corners, std::span<const uint8_t> two_sided,
                     std::span<const glm::dvec3> positions) {
  PartDepths out;
  if (corners.empty()) return out;
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const uint32_t v : corners) {
    low = glm::min(low, glm::dvec2(positions[v]));
    high = glm::max(high, glm::dvec2(positions[v]));
  }
  out.x = static_cast<int>(std::floor(low.x));
  out.y = static_cast<int>(std::floor(low.y));
  out.width = static_cast<int>(std::ceil(high.x)) - out.x;
  out.height = static_cast<int>(std::ceil(high.y)) - out.y;
  out.covered.assign(static_cast<size_t>(out.width) * static_cast<size_t>(out.height), 0);
  out.front.assign(out.covered.size(), -INFINITY);
  for (size_t t = 0; 3 * t + 2 < corners.size(); ++t) {
    std::array<glm::dvec3, 3> p;
    for (size_t k = 0; k < 3; ++k) p[k] = positions[corners[3 * t + k]] - glm::dvec3(out.x + 0.5, out.y + 0.5, 0);
    const double area = cross(glm::dvec2(p[1] - p[0]), glm::dvec2(p[2] - p[0]));
    if (std::abs(area) < 1e-12) continue;
    const bool faces = area > 0 || two_sided[t] != 0;
    const auto first = [](double v) { return std::max(0, static_cast<int>(std::ceil(v))); };
    const auto last = [](double v, int size) { return std::min(size - 1, static_cast<int>(std::floor(v))); };
    const int r1 = last(std::max({p[0].y, p[1].y, p[2].y}), out.height);
    const int c1 = last(std::max({p[0].x, p[1].x, p[2].x}), out.width);
    for (int r = first(std::min({p[0].y, p[1].y, p[2].y})); r <= r1; ++r)
      for (int c = first(std::min({p[0].x, p[1].x, p[2].x})); c <= c1; ++c) {
        const glm::dvec2 q(c, r);
        const double u = cross(glm::dvec2(p[1]) - q, glm::dvec2(p[2]) - q) / area;
        const double v = cross(glm::dvec2(p[2]) - q, glm::dvec2(p[0]) - q) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const size_t at = static_cast<size_t>(r) * static_cast<size_t>(out.width) + static_cast<size_t>(c);
        out.covered[at] = 1;
        if (faces) out.front[at] = std::max(out.front[at], u * p[0].z + v * p[1].z + (1 - u - v) * p[2].z);
      }
  }
  return out;
}

// Texels that several parts cover.
struct Contests {
  struct Entry {
    size_t part;
    double depth;  // of the plane, units
    double front;  // PartDepths::front
    bool right;    // it lies in front, or as far in front as any: around joints parts share their surface
  };
  struct Contest {
    size_t first, count;  // of the entries
  };
  std::vector<Entry> entries;
  std::vector<Contest> contests;
  std::vector<std::vector<size_t>> by_part;  // the contests that each is in
};

Contests contests_of(const PolypostorPlan& plan, const PolypostorTier& tier, std::span<const PartDepths> parts,
                     std::span<const TilePlane> planes) {
  constexpr double kShared = 0.25;  // texels
  glm::ivec2 low(1 << 20);
  glm::ivec2 high(-(1 << 20));
  for (const PartDepths& part : parts) {
    if (part.covered.empty()) continue;
    low = glm::min(low, glm::ivec2(part.x, part.y));
    high = glm::max(high, glm::ivec2(part.x + part.width, part.y + part.height));
  }
  const double unit = depth_unit(plan);
  Contests out;
  out.by_part.resize(parts.size());
  for (int y = low.y; y < high.y; ++y)
    for (int x = low.x; x < high.x; ++x) {
      Contests::Contest one{out.entries.size(), 0};
      double nearest = -INFINITY;
      for (size_t c = 0; c < parts.size(); ++c) {
        const PartDepths& part = parts[c];
        const int column = x - part.x;
        const int row = y - part.y;
        if (column < 0 || row < 0 || column >= part.width || row >= part.height) continue;
        const size_t at = static_cast<size_t>(row) * static_cast<size_t>(part.width) + static_cast<size_t>(column);
        if (part.covered[at] == 0) continue;
        const glm::dvec2 p = tier.texel * glm::dvec2(x + 0.5, y + 0.5);
        out.entries.push_back({c, on_plane(plan, planes[c], p).z / unit, part.front[at], false});
        nearest = std::max(nearest, part.front[at]);
      }
      one.count = out.entries.size() - one.first;
      if (one.count < 2 || !std::isfinite(nearest)) {
        out.entries.resize(one.first);
        continue;
      }
      for (size_t e = one.first; e < one.first + one.count; ++e) {
        out.entries[e].right = out.entries[e].front >= nearest - kShared;
        out.by_part[out.entries[e].part].push_back(out.contests.size());
      }
      out.contests.push_back(one);
    }
  return out;
}

// By how many units a part's plane is best moved while the others stay as they are.
// worth: texels that a unit has to mend.
int best_shift(const Contests& all, size_t part, std::span<const int> shifts, double worth) {
  constexpr int kMost = kMostOrderUnits;
  // By how many more texels are wrong at a shift than at the one before.
  std::array<double, 2 * kMost + 1> more{};
  for (const size_t i : all.by_part[part]) {
    const Contests::Contest& one = all.contests[i];
    const Contests::Entry* own = nullptr;
    const Contests::Entry* other = nullptr;
    double most = -INFINITY;  // of the others
    for (size_t e = one.first; e < one.first + one.count; ++e) {
      const Contests::Entry& entry = all.entries[e];
      if (entry.part == part) {
        own = &entry;
      } else if (entry.depth + shifts[entry.part] > most) {
        most = entry.depth + shifts[entry.part];
        other = &entry;
      }
    }
    if (own->right == other->right) continue;
    // The least shift from which on the part is drawn in front.
    const int from = static_cast<int>(std::clamp(std::floor(most - own->depth) + 1, -double{kMost}, kMost + 1.0));
    if (own->right) more[0] += 1;
    if (from <= kMost) more[static_cast<size_t>(from + kMost)] += own->right ? -1 : 1;
  }
  int best = 0;
  double least = INFINITY;
  double wrong = 0;
  for (int k = -kMost; k <= kMost; ++k) {
    wrong += more[static_cast<size_t>(k + kMost)];
    if (wrong + worth * std::abs(k) >= least) continue;
    least = wrong + worth * std::abs(k);
    best = k;
  }
  return best;
}

}  // namespace

glm::dvec3 on_plane(const PolypostorPlan& plan, const TilePlane& plane, const glm::dvec2& p) {
  const double rise = plane.slope_x * p.x + plane.slope_y * p.y;
  const double k = std::clamp((plan.eye - plane.height / plan.texel) / std::max(plan.eye + rise, 1.0), 0.5, 2.0);
  return {k * p.x, k * p.y, k * rise * plan.texel + plane.height};
}

double depth_unit(const PolypostorPlan& plan) { return kPolypostorReach * plan.sphere.radius / 127; }

void order_planes(const PolypostorPlan& plan, const PolypostorTier& tier, std::span<const glm::dvec3> positions,
                  std::span<TilePlane> planes) {
  constexpr int kRounds = 3;
  std::vector<PartDepths> parts;
  for (size_t c = 0; c < planes.size(); ++c) parts.push_back(depths_of(tier.corners[c], tier.two_sided[c], positions));
  const Contests contests = contests_of(plan, tier, parts, planes);
  std::vector<int> shifts(planes.size(), 0);
  // Freely at first, so that parts get past each other; then back where it does not pay, as planes that were moved
  // stand apart beside the view.
  for (const double worth : {0.5, 4.0})
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<int> before = shifts;
      for (size_t c = 0; c < planes.size(); ++c) shifts[c] = best_shift(contests, c, shifts, worth);
      if (shifts == before) break;
    }
  for (size_t c = 0; c < planes.size(); ++c) planes[c].height += shifts[c] * depth_unit(plan);
}

}  // namespace crowdbench::renderers
