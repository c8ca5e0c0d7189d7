// Based on: Beacco, Spanlang, Andujar and Pelechano, "A flexible approach for output-sensitive rendering of animated
// characters" (CGF 2011), for capturing a box's faces as a cube map's; Olano and Greer, "Triangle scan conversion using
// 2D homogeneous coordinates" (1997), for the edge functions. Differs from the sources: samples at corners and edges of
// texels, beside their middles, say between which depths the surface passes from a texel into the next.
#include "renderers/relief/relief_cube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "renderers/relief/relief.shared.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_clip.h"
#include "renderers/relief/relief_gaps.h"
#include "renderers/relief/relief_surface.h"

namespace crowdbench::renderers {
namespace {

constexpr double kNearest = 1e-3;  // of the way from the middle to a face: nothing nearer is seen

// The face of a box that looks along an axis, from its low side (0) or its high one.
struct BoxFace {
  int axis;
  int side;
};

// The corners of a triangle in a face's frame: the box's middle at 0, the face at z = 1, where it spans [-1, 1] in x
// and y.
std::array<glm::dvec3, 3> in_frame(const CaptureSource& source, const BoxSpace& space, const BoxFace& face,
                                   uint32_t triangle) {
  std::array<glm::dvec3, 3> p = corners_of(source.character.mesh, triangle, source.positions, space.unit_from_capture);
  const double outward = face.side == 0 ? -1 : 1;
  for (glm::dvec3& unit : p) {
    const glm::dvec3 q = 2.0 * unit - 1.0;
    unit = {q[(face.axis + 1) % 3], q[(face.axis + 2) % 3], outward * q[face.axis]};
  }
  return p;
}

// What lies before the middle of a triangle, projected: least and greatest x and y. None: all of it lies behind.
struct Reach {
  glm::dvec2 low{1e30};
  glm::dvec2 high{-1e30};
};
std::optional<Reach> reach_of(const std::array<glm::dvec3, 3>& p) {
  Reach reach;
  const auto add = [&](const glm::dvec3& point) {
    reach.low = glm::min(reach.low, glm::dvec2(point) / point.z);
    reach.high = glm::max(reach.high, glm::dvec2(point) / point.z);
  };
  for (size_t k = 0; k < 3; ++k) {
    const glm::dvec3& a = p[k];
    const glm::dvec3& b = p[(k + 1) % 3];
    if (a.z >= kNearest) add(a);
    if ((a.z < kNearest) == (b.z < kNearest)) continue;
    glm::dvec3 crossing = glm::mix(a, b, (kNearest - a.z) / (b.z - a.z));
    crossing.z = kNearest;
    add(crossing);
  }
  const bool seen =
      reach.low.x <= 1 && reach.low.y <= 1 && reach.high.x >= -1 && reach.high.y >= -1 && reach.low.x <= reach.high.x;
  return seen ? std::optional(reach) : std::nullopt;
}

// A triangle as rays from the middle meet it: three functions of their direction, each 0 along an edge, of one sign
// within it.
struct EdgeFunctions {
  std::array<glm::dvec3, 3> edges;
  double volume;
  explicit EdgeFunctions(const std::array<glm::dvec3, 3>& p)
      : edges{glm::cross(p[1], p[2]), glm::cross(p[2], p[0]), glm::cross(p[0], p[1])},
        volume(glm::dot(edges[0], p[0])) {}
};

// One map while it is captured; samples lie half a texel apart, the odd ones at the middles of texels.
struct CubeMap {
  AxisMaps maps;
  std::vector<uint8_t> inner;  // the first surface on the ray shows its inner side
  explicit CubeMap(size_t n) : maps(n), inner(n * n) {}
  void add(long column, long row, const Winner& met, bool inside) {
    const auto last = static_cast<long>(maps.n) - 1;
    for (long j = std::max(0L, (row - 1) / 2); j <= std::min(last, row / 2); ++j)
      for (long i = std::max(0L, (column - 1) / 2); i <= std::min(last, column / 2); ++i) {
        Touched& texel = maps.touched[static_cast<size_t>(j) * maps.n + static_cast<size_t>(i)];
        if (!texel.any() || met.depth < texel.low) texel.front = met;
        if (!texel.any() || met.depth > texel.high) texel.back = met;
        texel.low = std::min(texel.low, met.depth);
        texel.high = std::max(texel.high, met.depth);
      }
    if (column % 2 == 0 || row % 2 == 0) return;
    const size_t texel = static_cast<size_t>(row / 2) * maps.n + static_cast<size_t>(column / 2);
    Winner& first = maps.winners[0][texel];
    Winner& outermost = maps.winners[1][texel];
    if (first.triangle == UINT32_MAX || met.depth < first.depth) {
      first = met;
      inner[texel] = inside ? 1 : 0;
    }
    if (outermost.triangle == UINT32_MAX || met.depth > outermost.depth) outermost = met;
  }
};

// The triangle as a mask's texels are counted on it: in texels of the map, depth in [0, 1] of n.
std::array<glm::dvec3, 3> in_map_texels(std::array<glm::dvec3, 3> p, size_t n) {
  for (glm::dvec3& corner : p)
    corner = {0.5 * corner.x * static_cast<double>(n), 0.5 * corner.y * static_cast<double>(n), 0.5 * corner.z};
  return p;
}

// Every sample of the map that meets what is taken of a triangle.
void cast(const CaptureSource& source, const std::array<glm::dvec3, 3>& p, const Skirt& skirt, bool turned,
          CubeMap& map) {
  const std::optional<Reach> reach = reach_of(p);
  if (!reach) return;
  const EdgeFunctions triangle(p);
  const auto n = static_cast<double>(map.maps.n);
  const bool sheet = material_of(source, skirt.triangle).double_sided;
  const double footprint = alpha_footprint(source, skirt.triangle, in_map_texels(p, map.maps.n), map.maps.n);
  const auto first = [n](double x) { return static_cast<long>(std::ceil((std::max(x, -1.0) + 1) * n - 1e-9)); };
  const auto last = [n](double x) { return static_cast<long>(std::floor((std::min(x, 1.0) + 1) * n + 1e-9)); };
  for (long row = first(reach->low.y); row <= last(reach->high.y); ++row) {
    for (long column = first(reach->low.x); column <= last(reach->high.x); ++column) {
      const glm::dvec3 ray(static_cast<double>(column) / n - 1, static_cast<double>(row) / n - 1, 1.0);
      glm::dvec3 weights(glm::dot(triangle.edges[0], ray), glm::dot(triangle.edges[1], ray),
                         glm::dot(triangle.edges[2], ray));
      const double sum = weights.x + weights.y + weights.z;
      const double depth = triangle.volume / sum;
      if (!(depth >= kNearest && depth <= 1.0 + 2 * kOutside)) continue;  // NaN: seen edge-on
      weights /= sum;
      if (std::min({weights.x, weights.y, weights.z}) < -1e-9) continue;
      const double away =
          (skirt.shared[0] ? 0 : weights.x) + (skirt.shared[1] ? 0 : weights.y) + (skirt.shared[2] ? 0 : weights.z);
      if (skirt.reach < 1 && away > skirt.reach) continue;
      const Winner met{skirt.triangle, weights.y, weights.z, std::min(depth, 1.0)};
      if (is_there(source, met, footprint)) map.add(column, row, met, !sheet && (sum > 0) != turned);
    }
  }
}

// What the face shows: the outermost surface, on all levels.
void store_face(const CaptureSource& source, const BoxSpace& space, const AxisMaps& maps, size_t index,
                const BoxFace& face, ReliefModel& model) {
  const ReliefBox& box = model.boxes[index];
  const auto at = [](int k) { return k % 3; };
  const auto n = static_cast<double>(maps.n);
  const glm::dvec3 edges = glm::dvec3(box.size[at(face.axis + 1)], box.size[at(face.axis + 2)], box.size[face.axis]) /
                           std::max({box.size.x, box.size.y, box.size.z, 1e-30});
  const auto span_of = [&](const Winner& winner, const glm::dvec3& scale, double texels) {
    TexelSpan of{in_frame(source, space, face, winner.triangle), texels};
    for (glm::dvec3& corner : of.corners) corner *= 0.5 * n * scale;
    return of;
  };
  const auto which = static_cast<size_t>(face.axis * 2 + face.side);
  const glm::dmat3 bind_from_unit = glm::inverse(space.unit_from_bind);
  for (size_t texel = 0; texel < maps.n * maps.n; ++texel) {
    if (!maps.covered(texel)) continue;
    const Winner& winner = maps.winners[1][texel];
    const size_t byte = (box.first * 6 + which * maps.n * maps.n + texel) * 4;
    const SurfacePoint point(source.character.mesh, winner);
    const glm::dvec3 met(space.unit_from_capture * glm::dvec4(point.mixed<glm::dvec3>(source.positions), 1.0));
    shade(source, space, winner, bind_from_unit * (met - 0.5), span_of(winner, glm::dvec3(1.0), winner.depth),
          {model.colour.data() + byte, model.normal.data() + byte,
           model.emission.empty() ? nullptr : model.emission.data() + byte});
  }
  for (uint32_t level = 1; level < atlas_levels(box.texels); ++level) {
    const size_t side = size_t{1} << level;
    const size_t m = maps.n >> level;
    uint8_t* const begin = model.colour.data() + 4 * (model.colour_texel(index, level) + which * m * m);
    for (size_t square = 0; square < m * m; ++square) {
      const size_t texel = middle_of(maps, square % m, square / m, side);
      if (texel == maps.n * maps.n) continue;
      const Winner& winner = maps.winners[1][texel];
      store_colour(source, winner, span_of(winner, edges, static_cast<double>(side << RELIEF_FINER)),
                   begin + 4 * square);
    }
  }
}

}  // namespace

void capture_cube_face(const CaptureSource& source, const BoxSpace& space, const std::vector<Skirt>& all, size_t index,
                       int axis, int side, ReliefModel& model) {
  const ReliefBox& box = model.boxes[index];
  const BoxFace face{axis, side};
  CubeMap map(static_cast<size_t>(box.texels));
  AxisMaps& maps = map.maps;
  // The low faces' frames are left-handed, and a box may be.
  const bool turned = (side == 0) != (glm::determinant(glm::dmat3(space.unit_from_capture)) < 0);
  for (const Skirt& skirt : all) cast(source, in_frame(source, space, face, skirt.triangle), skirt, turned, map);
  maps.kept = maps.touched;
  close_gaps(maps);
  const auto stored = [](double d) { return static_cast<uint16_t>(std::clamp(d, 0.0, 1.0) * 65535.0 + 0.5); };
  const size_t texels = maps.n * maps.n;
  for (size_t texel = 0; texel < texels; ++texel) {
    const bool covered = maps.covered(texel);
    uint16_t* depth = model.depth.data() + (box.first * 6 + static_cast<size_t>(axis * 2 + side) * texels + texel) * 2;
    depth[0] = !covered ? 65535 : map.inner[texel] != 0 ? 0 : stored(maps.intervals[texel][0]);
    depth[1] = covered ? stored(maps.intervals[texel][1]) : 0;
  }
  store_face(source, space, maps, index, face, model);
}

}  // namespace crowdbench::renderers
