// Based on: P. Cignoni, C. Rocchini and R. Scopigno, "Metro: measuring error on simplified surfaces" (1998): both ways,
// by samples; C. Ericson, "Real-Time Collision Detection" (2005), section 5.1.5, for the nearest place of a triangle.
// Differs from the source: samples are spaced evenly along the running sum of the triangles' areas, and within
// triangles by the additive recurrence of M. Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018),
// in place of random numbers.
#include "scene/character/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "scene/character/surface_gauge.h"

namespace crowdbench::scene {
namespace {

// Inverses of the plastic number, the root of x^3 = x + 1, and of its square: steps of the recurrence.
constexpr double kStepU = 0.75487766624669276;
constexpr double kStepV = 0.56984029099805327;

struct Triangle {
  glm::vec3 a, b, c;
};

glm::vec3 nearest_on(const Triangle& t, const glm::vec3& p) {
  const glm::vec3 ab = t.b - t.a;
  const glm::vec3 ac = t.c - t.a;
  const glm::vec3 ap = p - t.a;
  const float d1 = glm::dot(ab, ap);
  const float d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return t.a;
  const glm::vec3 bp = p - t.b;
  const float d3 = glm::dot(ab, bp);
  const float d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return t.b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t.a + ab * (d1 / (d1 - d3));
  const glm::vec3 cp = p - t.c;
  const float d5 = glm::dot(ab, cp);
  const float d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return t.c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t.a + ac * (d2 / (d2 - d6));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return t.b + (t.c - t.b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const float sum = va + vb + vc;
  return sum > 0 ? t.a + ab * (vb / sum) + ac * (vc / sum) : t.a;
}

// Triangles in boxes in boxes: each box is cut at the middle of its triangles along its longest side.
class Boxes {
 public:
  explicit Boxes(const Surface& surface) {
    for (size_t i = 0; i + 2 < surface.indices.size(); i += 3)
      triangles_.push_back({surface.positions[surface.indices[i]], surface.positions[surface.indices[i + 1]],
                            surface.positions[surface.indices[i + 2]]});
    if (!triangles_.empty()) build(0, triangles_.size());
  }

  bool empty() const { return triangles_.empty(); }

  // Whether distance(p) is at most `bound`.
  bool is_within(const glm::vec3& p, double bound) const {
    // Boxes are passed over beyond a little more, as both distances are rounded.
    constexpr double kRounding = 1 + 1e-5;
    const auto most = static_cast<float>(bound * bound * kRounding + 1e-30);
    std::vector<uint32_t>& open = open_;
    open.assign(1, 0);
    while (!open.empty()) {
      const Box& box = boxes_[open.back()];
      open.pop_back();
      if (box.squared_distance(p) > most) continue;
      if (box.right == 0) {
        for (uint32_t t = box.first; t < box.first + box.count; ++t) {
          const glm::vec3 apart = nearest_on(triangles_[t], p) - p;
          if (static_cast<double>(std::sqrt(glm::dot(apart, apart))) <= bound) return true;
        }
        continue;
      }
      open_both(box, p);
    }
    return false;
  }

  float distance(const glm::vec3& p) const {
    float best = std::numeric_limits<float>::infinity();  // squared
    std::vector<uint32_t>& open = open_;
    open.assign(1, 0);
    while (!open.empty()) {
      const Box& box = boxes_[open.back()];
      open.pop_back();
      if (box.squared_distance(p) >= best) continue;
      if (box.right == 0) {
        for (uint32_t t = box.first; t < box.first + box.count; ++t) {
          const glm::vec3 apart = nearest_on(triangles_[t], p) - p;
          best = std::min(best, glm::dot(apart, apart));
        }
        continue;
      }
      open_both(box, p);
    }
    return std::sqrt(best);
  }

 private:
  struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};
    uint32_t first = 0, count = 0;
    uint32_t right = 0;  // the left one follows its parent; 0: no boxes inside
    float squared_distance(const glm::vec3& p) const {
      const glm::vec3 apart = glm::max(glm::max(low - p, p - high), glm::vec3(0.0F));
      return glm::dot(apart, apart);
    }
  };

  // The nearer of the two boxes inside is looked at first.
  void open_both(const Box& box, const glm::vec3& p) const {
    const auto left = static_cast<uint32_t>(&box - boxes_.data()) + 1;
    const bool left_first = boxes_[left].squared_distance(p) < boxes_[box.right].squared_distance(p);
    open_.push_back(left_first ? box.right : left);
    open_.push_back(left_first ? left : box.right);
  }

  uint32_t build(size_t first, size_t end) {
    const auto self = static_cast<uint32_t>(boxes_.size());
    Box box;
    box.first = static_cast<uint32_t>(first);
    box.count = static_cast<uint32_t>(end - first);
    for (size_t t = first; t < end; ++t)
      for (const glm::vec3& p : {triangles_[t].a, triangles_[t].b, triangles_[t].c}) {
        box.low = glm::min(box.low, p);
        box.high = glm::max(box.high, p);
      }
    boxes_.push_back(box);
    constexpr size_t kLeaf = 4;
    if (end - first <= kLeaf) return self;
    const glm::vec3 extent = box.high - box.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t middle = (first + end) / 2;
    const auto at = [&](size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(end), [axis](const Triangle& s, const Triangle& t) {
      return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
    });
    build(first, middle);
    const uint32_t right = build(middle, end);
    boxes_[self].right = right;
    return self;
  }

  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
  mutable std::vector<uint32_t> open_;
};

// Places on a surface, evenly by area.
std::vector<glm::vec3> places_by_area(const Surface& surface, size_t count) {
  const std::span<const uint32_t> corners = surface.indices;
  std::vector<double> sums = {0.0};
  for (size_t i = 0; i + 2 < corners.size(); i += 3) {
    const glm::vec3 a = surface.positions[corners[i]];
    const glm::vec3 normal = glm::cross(surface.positions[corners[i + 1]] - a, surface.positions[corners[i + 2]] - a);
    sums.push_back(sums.back() + static_cast<double>(glm::length(normal)));
  }
  std::vector<glm::vec3> out;
  size_t t = 0;
  for (size_t s = 0; s < count && sums.back() > 0; ++s) {
    const double at = sums.back() * (static_cast<double>(s) + 0.5) / static_cast<double>(count);
    while (sums[t + 1] < at) ++t;
    double whole = 0;
    auto u = static_cast<float>(std::modf(0.5 + kStepU * static_cast<double>(s), &whole));
    auto v = static_cast<float>(std::modf(0.5 + kStepV * static_cast<double>(s), &whole));
    if (u + v > 1) {  // the square's other half, folded
      u = 1 - u;
      v = 1 - v;
    }
    const glm::vec3 a = surface.positions[corners[3 * t]];
    out.push_back(a + u * (surface.positions[corners[3 * t + 1]] - a) +
                  v * (surface.positions[corners[3 * t + 2]] - a));
  }
  return out;
}

std::vector<glm::vec3> corners_of(const Surface& surface, const SurfacePlaces& places) {
  std::vector<uint32_t> corners(surface.indices.begin(), surface.indices.end());
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const size_t most = std::max<size_t>(1, places.most_corners);
  const size_t step = corners.size() / most + (corners.size() % most == 0 ? 0 : 1);
  std::vector<glm::vec3> out;
  for (size_t i = step == 0 ? 0 : places.turn % step; i < corners.size(); i += step)
    out.push_back(surface.positions[corners[i]]);
  return out;
}

}  // namespace

SurfaceDistance surface_distance(const Surface& a, const Surface& b, const SurfacePlaces& places) {
  const Boxes boxes_a(a);
  const Boxes boxes_b(b);
  SurfaceDistance out;
  if (boxes_a.empty() || boxes_b.empty()) return out;
  double squares = 0;
  size_t by_area = 0;
  for (const auto& [from, to] : {std::pair(&a, &boxes_b), std::pair(&b, &boxes_a)}) {
    const auto measure = [&out, nearest = to](const glm::vec3& p) {
      const auto distance = static_cast<double>(nearest->distance(p));
      out.max = std::max(out.max, distance);
      ++out.places;
      return distance;
    };
    for (const glm::vec3& p : places_by_area(*from, places.by_area)) {
      const double distance = measure(p);
      squares += distance * distance;
      ++by_area;
    }
    for (const glm::vec3& p : corners_of(*from, places)) measure(p);
  }
  out.rms = by_area > 0 ? std::sqrt(squares / static_cast<double>(by_area)) : 0;
  return out;
}

struct SurfaceGauge::Kept {
  Boxes boxes;
  SurfacePlaces places;
  std::vector<glm::vec3> own;  // by area, then corners
  size_t far = 0;              // of them: the last that was too far
  Kept(const Surface& surface, const SurfacePlaces& where)
      : boxes(surface), places(where), own(places_by_area(surface, where.by_area)) {
    const std::vector<glm::vec3> corners = corners_of(surface, where);
    own.insert(own.end(), corners.begin(), corners.end());
  }
};

SurfaceGauge::SurfaceGauge(const Surface& surface, const SurfacePlaces& places)
    : kept_(std::make_unique<Kept>(surface, places)) {}
SurfaceGauge::~SurfaceGauge() = default;
SurfaceGauge::SurfaceGauge(SurfaceGauge&&) noexcept = default;
SurfaceGauge& SurfaceGauge::operator=(SurfaceGauge&&) noexcept = default;

bool SurfaceGauge::is_within(const Surface& other, double bound) {
  const Boxes boxes(other);
  if (boxes.empty() || kept_->boxes.empty()) return true;
  const std::vector<glm::vec3>& own = kept_->own;
  if (!own.empty() && !boxes.is_within(own[kept_->far], bound)) return false;
  for (size_t i = 0; i < own.size(); ++i) {
    if (boxes.is_within(own[i], bound)) continue;
    kept_->far = i;
    return false;
  }
  const auto near = [&](const glm::vec3& p) { return kept_->boxes.is_within(p, bound); };
  return std::ranges::all_of(places_by_area(other, kept_->places.by_area), near) &&
         std::ranges::all_of(corners_of(other, kept_->places), near);
}

}  // namespace crowdbench::scene
