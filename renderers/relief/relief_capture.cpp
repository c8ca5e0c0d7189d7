#include "renderers/relief/relief_capture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderers/relief/relief.shared.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_clip.h"
#include "renderers/relief/relief_gaps.h"
#include "renderers/relief/relief_surface.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

// What of a triangle's piece within a texel's column is there: looked at where it stands, and in steps of a texel along
// its depth where it is steep.
struct Stretch {
  bool any = false;
  glm::dvec3 middle{0.0};
  double low = 0;  // depths
  double high = 0;
};
template <typename At>
Stretch what_masks_leave(const CaptureSource& source, const Polygon& polygon, size_t n, double footprint,
                         const At& at) {
  Stretch out;
  size_t nearest = 0;
  size_t farthest = 0;
  for (size_t k = 0; k < polygon.count; ++k) {
    out.middle += polygon.corners[k] / static_cast<double>(polygon.count);
    if (polygon.corners[k].z < polygon.corners[nearest].z) nearest = k;
    if (polygon.corners[k].z > polygon.corners[farthest].z) farthest = k;
  }
  out.low = polygon.corners[nearest].z;
  out.high = polygon.corners[farthest].z;
  const double deep = (out.high - out.low) * static_cast<double>(n);
  if (deep <= 1 || scene::alpha_threshold(material_of(source, at(out.middle).triangle)) <= 0) {
    out.any = is_there(source, at(out.middle), footprint);
    return out;
  }
  const int steps = static_cast<int>(std::min(std::ceil(deep), 256.0));
  const glm::dvec3 stride = (polygon.corners[farthest] - polygon.corners[nearest]) / static_cast<double>(steps);
  glm::dvec3 first(0.0);
  glm::dvec3 last(0.0);
  for (int i = 0; i < steps; ++i) {
    const glm::dvec3 point = polygon.corners[nearest] + (i + 0.5) * stride;
    if (!is_there(source, at(point), footprint)) continue;
    if (!out.any) first = point;
    last = point;
    out.any = true;
  }
  out.low = first.z - 0.5 * stride.z;
  out.high = last.z + 0.5 * stride.z;
  out.middle = is_there(source, at(out.middle), footprint) ? out.middle : first;
  return out;
}

// Adds what is taken of a triangle to every texel that it reaches into. One that is seen edge-on still has depths.
void touch(const CaptureSource& source, const std::array<glm::dvec3, 3>& p, const Skirt& skirt, size_t n,
           std::vector<Touched>& touched) {
  const uint32_t t = skirt.triangle;
  const Polygon all = taken(p, skirt);
  const auto range = [&](int axis) {
    double low = all.corners[0][axis];
    double high = low;
    for (size_t k = 1; k < all.count; ++k) {
      low = std::min(low, all.corners[k][axis]);
      high = std::max(high, all.corners[k][axis]);
    }
    const auto last = static_cast<long>(n) - 1;
    return std::pair(std::clamp(static_cast<long>(std::floor(low)), 0L, last),
                     std::clamp(static_cast<long>(std::floor(high)), 0L, last));
  };
  const auto [left, right] = range(0);
  const auto [top, bottom] = range(1);
  const glm::dvec3 e1 = p[1] - p[0];
  const glm::dvec3 e2 = p[2] - p[0];
  const glm::dvec3 across = glm::cross(e1, e2);
  const double square = glm::dot(across, across);
  if (square <= 0) return;
  const double footprint = alpha_footprint(source, t, p, n);
  const auto at = [&](const glm::dvec3& point) {
    const glm::dvec3 from = point - p[0];
    return Winner{t, glm::dot(glm::cross(from, e2), across) / square, glm::dot(glm::cross(e1, from), across) / square,
                  point.z};
  };
  for (long j = top; j <= bottom; ++j) {
    for (long i = left; i <= right; ++i) {
      const glm::dvec3 square_low(i, j, -kOutside);
      const Polygon polygon = clipped(all, square_low, square_low + glm::dvec3(1.0, 1.0, 1.0 + 2 * kOutside));
      if (polygon.count == 0) continue;
      const Stretch piece = what_masks_leave(source, polygon, n, footprint, at);
      if (!piece.any) continue;
      const Winner here = at(piece.middle);
      Touched& texel = touched[static_cast<size_t>(j) * n + static_cast<size_t>(i)];
      texel.low = std::min(texel.low, piece.low);
      texel.high = std::max(texel.high, piece.high);
      if (texel.front.triangle == UINT32_MAX || here.depth < texel.front.depth) texel.front = here;
      if (texel.back.triangle == UINT32_MAX || here.depth > texel.back.depth) texel.back = here;
    }
  }
}

// Makes a triangle the winner of every texel whose centre it covers nearest or farthest, as far as it is taken.
void compete(const CaptureSource& source, const std::array<glm::dvec3, 3>& p, const Skirt& skirt, AxisMaps& maps) {
  const uint32_t t = skirt.triangle;
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  if (std::abs(area) < 1e-12) return;
  const double footprint = alpha_footprint(source, t, p, maps.n);
  const auto first = [](double a, double b, double c) {
    return std::max(0L, static_cast<long>(std::ceil(std::min({a, b, c}) - 0.5 - 1e-9)));
  };
  const auto last = [&](double a, double b, double c) {
    return std::min(static_cast<long>(maps.n) - 1, static_cast<long>(std::floor(std::max({a, b, c}) - 0.5 + 1e-9)));
  };
  for (long j = first(p[0].y, p[1].y, p[2].y); j <= last(p[0].y, p[1].y, p[2].y); ++j) {
    for (long i = first(p[0].x, p[1].x, p[2].x); i <= last(p[0].x, p[1].x, p[2].x); ++i) {
      const double x = static_cast<double>(i) + 0.5;
      const double y = static_cast<double>(j) + 0.5;
      const double b1 = ((x - p[0].x) * (p[2].y - p[0].y) - (y - p[0].y) * (p[2].x - p[0].x)) / area;
      const double b2 = ((p[1].x - p[0].x) * (y - p[0].y) - (p[1].y - p[0].y) * (x - p[0].x)) / area;
      if (b1 < -1e-9 || b2 < -1e-9 || b1 + b2 > 1.0 + 1e-9) continue;
      const double away = (skirt.shared[0] ? 0 : 1 - b1 - b2) + (skirt.shared[1] ? 0 : b1) + (skirt.shared[2] ? 0 : b2);
      if (skirt.reach < 1 && away > skirt.reach) continue;
      const double plane = p[0].z + b1 * (p[1].z - p[0].z) + b2 * (p[2].z - p[0].z);
      if (plane < -kOutside || plane > 1.0 + kOutside) continue;
      const double depth = std::clamp(plane, 0.0, 1.0);
      if (!is_there(source, {t, b1, b2, depth}, footprint)) continue;
      const size_t texel = static_cast<size_t>(j) * maps.n + static_cast<size_t>(i);
      Winner& front = maps.winners[0][texel];
      Winner& back = maps.winners[1][texel];
      if (front.triangle == UINT32_MAX || depth < front.depth) front = {t, b1, b2, depth};
      if (back.triangle == UINT32_MAX || depth > back.depth) back = {t, b1, b2, depth};
    }
  }
}

// A triangle as an axis of the box sees it: u, v in texels, depth in [0, 1].
std::array<glm::dvec3, 3> in_texels(const CaptureSource& source, const BoxSpace& space, int axis, size_t n,
                                    uint32_t triangle) {
  const int u_axis = (axis + 1) % 3;
  const int v_axis = (axis + 2) % 3;
  std::array<glm::dvec3, 3> p = corners_of(source.character.mesh, triangle, source.positions, space.unit_from_capture);
  for (glm::dvec3& unit : p)
    unit = {unit[u_axis] * static_cast<double>(n), unit[v_axis] * static_cast<double>(n), unit[axis]};
  return p;
}

// Between the two layers of a patch lies the body only where the lower one faces down the axis and the upper one up it.
// Where it does not, air does, and the layer is kept that faces along the axis most: the other belongs to another axis.
void part_layers(const CaptureSource& source, const BoxSpace& space, const std::vector<Skirt>& all, int axis,
                 AxisMaps& maps) {
  const auto along = [&](const Winner& winner) {
    const glm::dvec3 n =
        space.bind_from_capture * SurfacePoint(source.character.mesh, winner).mixed<glm::dvec3>(source.normals);
    return (space.unit_from_bind * n)[axis];
  };
  for (size_t texel = 0; texel < maps.n * maps.n; ++texel) {
    Winner& front = maps.winners[0][texel];
    Winner& back = maps.winners[1][texel];
    if (!maps.covered(texel) || front.triangle == back.triangle) continue;
    const double lower = along(front);
    const double upper = along(back);
    if (lower <= 0 && upper >= 0) continue;
    const bool keep_front = lower <= 0 || (upper < 0 && -upper < lower);
    (keep_front ? back : front) = keep_front ? front : back;
    Touched& kept = maps.kept[texel];
    kept = {front.depth, front.depth, front, front};
    const size_t column = texel % maps.n;
    const size_t row = texel / maps.n;
    const glm::dvec3 square(static_cast<double>(column), static_cast<double>(row), 0);
    for (const Skirt& skirt : all) {
      if (skirt.triangle != front.triangle) continue;
      const Polygon part = clipped(taken(in_texels(source, space, axis, maps.n, skirt.triangle), skirt),
                                   square - glm::dvec3(0, 0, kOutside), square + glm::dvec3(1, 1, 1 + kOutside));
      for (size_t k = 0; k < part.count; ++k) {
        kept.low = std::min(kept.low, part.corners[k].z);
        kept.high = std::max(kept.high, part.corners[k].z);
      }
    }
  }
}

// The depths and extents of one axis.
void store_depths(const AxisMaps& maps, const ReliefBox& box, int axis, ReliefModel& model) {
  const auto stored = [](double d) { return static_cast<uint16_t>(std::clamp(d, 0.0, 1.0) * 65535.0 + 0.5); };
  const size_t texels = maps.n * maps.n;
  const size_t map = box.first * 3 + static_cast<size_t>(axis) * texels;
  for (size_t texel = 0; texel < texels; ++texel) {
    const bool covered = maps.covered(texel);
    const Touched& touched = maps.touched[texel];
    uint16_t* depth = model.depth.data() + (map + texel) * 2;
    depth[0] = covered ? stored(maps.intervals[texel][0]) : 65535;
    depth[1] = covered ? stored(maps.intervals[texel][1]) : 0;
    uint16_t* extent = model.extent.data() + (map + texel) * 2;
    extent[0] = std::min(depth[0], touched.any() ? stored(touched.low) : uint16_t{65535});
    extent[1] = std::max(depth[1], touched.any() ? stored(touched.high) : uint16_t{0});
  }
}

// The colours, normals and glow of one axis's two faces.
void store_faces(const CaptureSource& source, const BoxSpace& space, const AxisMaps& maps, const ReliefBox& box,
                 int axis, ReliefModel& model) {
  const auto flat = [](std::array<glm::dvec3, 3> corners) {
    for (glm::dvec3& corner : corners) corner.z = 0;
    return corners;
  };
  const size_t texels = maps.n * maps.n;
  const glm::dvec3 up = glm::transpose(space.unit_from_bind)[axis];
  for (int side = 0; side < 2; ++side) {
    const glm::dvec3 toward = side == 0 ? -up : up;
    const size_t face = box.first * 6 + static_cast<size_t>(axis * 2 + side) * texels;
    for (size_t texel = 0; texel < texels; ++texel) {
      if (!maps.covered(texel)) continue;
      const Winner& winner = maps.winners[static_cast<size_t>(side)][texel];
      const size_t byte = (face + texel) * 4;
      shade(source, space, winner, toward, {flat(in_texels(source, space, axis, maps.n, winner.triangle))},
            {model.colour.data() + byte, model.normal.data() + byte,
             model.emission.empty() ? nullptr : model.emission.data() + byte});
    }
  }
}

// The colours of the levels above the finest, of one axis's two faces.
void store_levels(const CaptureSource& source, const BoxSpace& space, const AxisMaps& maps, size_t index, int axis,
                  ReliefModel& model) {
  const ReliefBox& box = model.boxes[index];
  const auto at = [](int k) { return k % 3; };
  const glm::dvec3 edges = glm::dvec3(box.size[at(axis + 1)], box.size[at(axis + 2)], box.size[axis]) /
                           std::max({box.size.x, box.size.y, box.size.z, 1e-30});
  const glm::dvec3 scale = edges * glm::dvec3(1.0, 1.0, static_cast<double>(maps.n));
  for (uint32_t level = 1; level < atlas_levels(box.texels); ++level) {
    const size_t side = size_t{1} << level;
    const size_t m = maps.n >> level;
    uint8_t* const begin = model.colour.data() + 4 * model.colour_texel(index, level);
    for (size_t v = 0; v < m; ++v)
      for (size_t u = 0; u < m; ++u) {
        const size_t texel = middle_of(maps, u, v, side);
        if (texel == maps.n * maps.n) continue;
        for (size_t face = 0; face < 2; ++face) {
          const Winner& winner = maps.winners[face][texel];
          TexelSpan of{in_texels(source, space, axis, maps.n, winner.triangle),
                       static_cast<double>(side << RELIEF_FINER)};
          for (glm::dvec3& corner : of.corners) corner *= scale;
          store_colour(source, winner, of, begin + 4 * (((static_cast<size_t>(axis) * 2 + face) * m + v) * m + u));
        }
      }
  }
}

}  // namespace

void capture_axis(const CaptureSource& source, const BoxSpace& space, const std::vector<Skirt>& all, bool patch,
                  size_t index, int axis, ReliefModel& model) {
  const ReliefBox& box = model.boxes[index];
  AxisMaps maps(static_cast<size_t>(box.texels));
  for (const Skirt& skirt : all) {
    const std::array<glm::dvec3, 3> p = in_texels(source, space, axis, maps.n, skirt.triangle);
    touch(source, p, skirt, maps.n, maps.touched);
    compete(source, p, skirt, maps);
  }
  maps.kept = maps.touched;
  if (patch) part_layers(source, space, all, axis, maps);
  close_gaps(maps);
  store_depths(maps, box, axis, model);
  store_faces(source, space, maps, box, axis, model);
  store_levels(source, space, maps, index, axis, model);
}

}  // namespace crowdbench::renderers
