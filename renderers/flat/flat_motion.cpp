// Based on: motion vectors of rendered frames, by which frames between them are made (after Didyk et al. 2010,
// "Perceptually-motivated real-time temporal upsampling of 3D content for high-refresh-rate displays", and others).
// Differs from the source, and why: vectors lie on the lattice of the moment half-way between two frames instead of on
// that of either frame, so that what is in front there is known and need not be searched for, and one texel leads to
// both pictures.
#include "renderers/flat/flat_motion.h"

#include <algorithm>
#include <cmath>

#include "renderers/impostor/tiles/tile_capture.h"

namespace crowdbench::renderers {
namespace {

constexpr int kSteps = 63;  // of x, to either side
constexpr int kZero = 64;

// x and y in texels, z in metres.
glm::dvec3 on_lattice(const glm::vec3& position, const MotionLattice& lattice) {
  const glm::dvec3 p = glm::dvec3(position) - lattice.centre;
  return {glm::dot(p, lattice.basis.right) / lattice.texel, glm::dot(p, lattice.basis.up) / lattice.texel,
          glm::dot(p, lattice.basis.to_eye)};
}

size_t index_in(const TileRect& rect, int x, int y) {
  return static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x - rect.x);
}

bool inside(const TileRect& rect, int x, int y) {
  return x >= rect.x && y >= rect.y && x < rect.x + rect.width && y < rect.y + rect.height;
}

TileRect rect_around(const TileRect& a, const TileRect& b) {
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

double edge(const glm::dvec3& a, const glm::dvec3& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

void draw_triangle(const std::array<glm::dvec3, 3>& p, int triangle, ShownSurface& surface) {
  const double area = edge(p[0], p[1], p[2].x, p[2].y);
  if (std::abs(area) < 1e-12) return;
  const auto from = [](double least) { return static_cast<int>(std::ceil(least - 0.5)); };
  const auto to = [](double most) { return static_cast<int>(std::floor(most - 0.5)); };
  for (int y = from(std::min({p[0].y, p[1].y, p[2].y})); y <= to(std::max({p[0].y, p[1].y, p[2].y})); ++y)
    for (int x = from(std::min({p[0].x, p[1].x, p[2].x})); x <= to(std::max({p[0].x, p[1].x, p[2].x})); ++x) {
      const double b = edge(p[2], p[0], x + 0.5, y + 0.5) / area;
      const double c = edge(p[0], p[1], x + 0.5, y + 0.5) / area;
      if (b < 0 || c < 0 || b + c > 1 || !inside(surface.rect, x, y)) continue;
      const size_t at = index_in(surface.rect, x, y);
      const auto depth = static_cast<float>(p[0].z + b * (p[1].z - p[0].z) + c * (p[2].z - p[0].z));
      if (surface.triangle[at] >= 0 && depth <= surface.depth[at]) continue;
      surface.triangle[at] = triangle;
      surface.depth[at] = depth;
      surface.weight[at] = {static_cast<float>(b), static_cast<float>(c)};
    }
}

struct NearestShown {
  size_t texel = 0;  // of the surface
  int steps = 0;     // to any of eight neighbours
};

// Of every texel of `rect` the texel of the surface that shows something in fewest steps; empty where the surface shows
// nothing.
std::vector<NearestShown> nearest_shown(const ShownSurface& surface, const TileRect& rect) {
  const TileRect all = rect_around(rect, surface.rect);
  const size_t count = static_cast<size_t>(all.width) * static_cast<size_t>(all.height);
  constexpr int kNone = -1;
  std::vector<NearestShown> source(count, {0, kNone});
  std::vector<size_t> order;
  for (int y = surface.rect.y; y < surface.rect.y + surface.rect.height; ++y)
    for (int x = surface.rect.x; x < surface.rect.x + surface.rect.width; ++x)
      if (surface.covers(x, y)) {
        order.push_back(index_in(all, x, y));
        source[order.back()] = {index_in(surface.rect, x, y), 0};
      }
  if (order.empty()) return {};
  for (size_t i = 0; i < order.size(); ++i) {
    const int x = all.x + static_cast<int>(order[i] % static_cast<size_t>(all.width));
    const int y = all.y + static_cast<int>(order[i] / static_cast<size_t>(all.width));
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!inside(all, x + dx, y + dy)) continue;
        const size_t to = index_in(all, x + dx, y + dy);
        if (source[to].steps != kNone) continue;
        source[to] = {source[order[i]].texel, source[order[i]].steps + 1};
        order.push_back(to);
      }
  }
  std::vector<NearestShown> out;
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) out.push_back(source[index_in(all, x, y)]);
  return out;
}

// The point of a triangle in another pose, on the lattice.
glm::dvec3 point_of(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices, int triangle,
                    const std::array<float, 2>& weight, const MotionLattice& lattice) {
  const auto first = static_cast<size_t>(triangle) * 3;
  const glm::vec3& a = positions[indices[first]];
  return on_lattice(
      a + weight[0] * (positions[indices[first + 1]] - a) + weight[1] * (positions[indices[first + 2]] - a), lattice);
}

// Whether what a frame shows where a point of half-way lies belongs elsewhere half-way: something hides the point
// there. at: the point half-way, on the lattice; there: in the frame. deep: whether its depth tells, too.
bool hidden_in(const ShownSurface& picture, const MotionPoses& poses, const MotionLattice& lattice,
               const glm::dvec3& at, const glm::dvec3& there, bool deep) {
  const int x = static_cast<int>(std::floor(there.x));
  const int y = static_cast<int>(std::floor(there.y));
  if (!picture.covers(x, y)) return false;
  const size_t texel = index_in(picture.rect, x, y);
  const glm::dvec3 found =
      point_of(poses.half_way, poses.indices, picture.triangle[texel], picture.weight[texel], lattice);
  constexpr double kTexelsAside = 1.5;  // a texel's middle lies up to 0.7 beside a point within it, and is stretched
  constexpr double kTexelsDeep = 2;     // what a slope within a texel and its neighbours may differ by
  return glm::distance(glm::dvec2(found), glm::dvec2(at)) > kTexelsAside ||
         (deep && std::abs(found.z - at.z) > kTexelsDeep * lattice.texel);
}

std::array<uint8_t, 2> encode_motion(const Motion& motion, double range) {
  const int x = std::clamp(static_cast<int>(std::lround(motion.metres.x / range * kSteps)), -kSteps, kSteps);
  return {static_cast<uint8_t>(2 * (kZero + x) + (motion.hidden ? 1 : 0)), encode_signed(motion.metres.y / range)};
}

}  // namespace

bool ShownSurface::covers(int x, int y) const { return inside(rect, x, y) && triangle[index_in(rect, x, y)] >= 0; }

ShownSurface shown_surface(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices,
                           const MotionLattice& lattice) {
  ShownSurface surface;
  surface.rect = tile_bounds(positions, lattice.centre, lattice.basis, lattice.texel);
  const size_t texels = static_cast<size_t>(surface.rect.width) * static_cast<size_t>(surface.rect.height);
  surface.triangle.assign(texels, -1);
  surface.depth.assign(texels, 0.0F);
  surface.weight.resize(texels);
  std::vector<glm::dvec3> placed;
  placed.reserve(positions.size());
  for (const glm::vec3& p : positions) placed.push_back(on_lattice(p, lattice));
  for (size_t i = 0; i + 2 < indices.size(); i += 3)
    draw_triangle({placed[indices[i]], placed[indices[i + 1]], placed[indices[i + 2]]}, static_cast<int>(i / 3),
                  surface);
  return surface;
}

std::vector<uint8_t> motion_texels(const MotionPoses& poses, const MotionLattice& lattice, const TileRect& rect,
                                   double range) {
  const ShownSurface shown = shown_surface(poses.half_way, poses.indices, lattice);
  const std::array<const std::vector<glm::vec3>*, 2> frames = {&poses.earlier, &poses.later};
  const std::array<ShownSurface, 2> pictures = {shown_surface(poses.earlier, poses.indices, lattice),
                                                shown_surface(poses.later, poses.indices, lattice)};
  const std::vector<NearestShown> nearest = nearest_shown(shown, rect);
  std::vector<uint8_t> out;
  out.reserve(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height) * 4);
  for (size_t i = 0; i < static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height); ++i) {
    std::array<Motion, 2> motions;
    for (size_t f = 0; f < 2 && !nearest.empty(); ++f) {
      const size_t at = nearest[i].texel;
      const auto place = [&](const std::vector<glm::vec3>& positions) {
        return point_of(positions, poses.indices, shown.triangle[at], shown.weight[at], lattice);
      };
      const glm::dvec3 half_way = place(poses.half_way);
      const glm::dvec3 step = place(*frames[f]) - half_way;
      const int column = static_cast<int>(i) % rect.width;
      const int row = static_cast<int>(i) / rect.width;
      const glm::dvec3 here(rect.x + column + 0.5, rect.y + row + 0.5, half_way.z);
      motions[f] = {glm::dvec2(step) * lattice.texel,
                    hidden_in(pictures[f], poses, lattice, here, here + step, nearest[i].steps == 0)};
    }
    // A neighbour that leads to other surfaces in both frames shows nothing; a point that is hidden in both, what it
    // can.
    const bool air =
        nearest.empty() || nearest[i].steps > 1 || (nearest[i].steps == 1 && motions[0].hidden && motions[1].hidden);
    if (air || (motions[0].hidden && motions[1].hidden)) motions[0].hidden = motions[1].hidden = air;
    for (const Motion& motion : motions)
      for (const uint8_t code : encode_motion(motion, range)) out.push_back(code);
  }
  return out;
}

Motion decode_motion(uint8_t x, uint8_t y, double range) {
  const int steps = x / 2 - kZero;  // the lowest bit says whether it is hidden
  return {glm::dvec2(steps / static_cast<double>(kSteps), decode_signed(y)) * range, x % 2 != 0};
}

double largest_step(const std::vector<glm::vec3>& from, const std::vector<glm::vec3>& to) {
  float most = 0;
  for (size_t v = 0; v < from.size(); ++v) {
    const glm::vec3 d = to[v] - from[v];
    most = std::max(most, glm::dot(d, d));
  }
  return std::sqrt(static_cast<double>(most));
}

}  // namespace crowdbench::renderers
