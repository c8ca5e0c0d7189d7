#include "renderers/relief/relief_capture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/colour.h"
#include "renderers/relief/relief.shared.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_clip.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

struct Winner {
  uint32_t triangle = UINT32_MAX;
  double b1 = 0;  // barycentric weights of the second and third corner
  double b2 = 0;
  double depth = 0;
};

// The face of a box that looks along an axis, from its low side (0) or its high one.
struct Face {
  int axis;
  int side;
};

// Four bytes each; emission may be null.
struct FaceTexel {
  uint8_t* colour;
  uint8_t* normal;
  uint8_t* emission;
};

uint8_t byte_of(double unit) { return static_cast<uint8_t>(std::clamp(unit, 0.0, 1.0) * 255.0 + 0.5); }

// A point of a triangle, by the weights of its corners.
struct SurfacePoint {
  std::array<uint32_t, 3> v;
  double b0, b1, b2;

  SurfacePoint(const scene::Mesh& mesh, const Winner& winner)
      : v{mesh.indices[3 * winner.triangle], mesh.indices[3 * winner.triangle + 1],
          mesh.indices[3 * winner.triangle + 2]},
        b0(1.0 - winner.b1 - winner.b2),
        b1(winner.b1),
        b2(winner.b2) {}
  template <typename Vector, typename Value>
  Vector mixed(const std::vector<Value>& of_vertex) const {
    return Vector(of_vertex[v[0]]) * b0 + Vector(of_vertex[v[1]]) * b1 + Vector(of_vertex[v[2]]) * b2;
  }
};

// What a texel spans of the surface around it.
struct Footprint {
  std::array<glm::dvec3, 3>
      corners;        // of the triangle, in texels; over the picture plane alone, or as they lie in space
  double texels = 1;  // that the span is wide
};

// Texels of an image that a texel's span covers, along a side: by the areas of the triangle in both.
double image_texels(const LinearPyramid& image, const std::vector<glm::vec2>& uvs, const SurfacePoint& point,
                    const Footprint& of) {
  const glm::dvec2 t0(uvs[point.v[0]]);
  const glm::dvec2 size(image.width(), image.height());
  const glm::dvec2 e1 = (glm::dvec2(uvs[point.v[1]]) - t0) * size;
  const glm::dvec2 e2 = (glm::dvec2(uvs[point.v[2]]) - t0) * size;
  const double skin_area = std::abs(e1.x * e2.y - e1.y * e2.x);
  const double map_area = glm::length(glm::cross(of.corners[1] - of.corners[0], of.corners[2] - of.corners[0]));
  return of.texels * std::min(std::sqrt(skin_area / std::max(map_area, 1e-9)), 64.0);
}

glm::dvec3 sampled(const LinearPyramid& image, const std::vector<glm::vec2>& uvs, const SurfacePoint& point,
                   const Footprint& of) {
  return {image.colour(point.mixed<glm::dvec2>(uvs), image_texels(image, uvs, point, of))};
}

const scene::Material& material_of(const CaptureSource& source, uint32_t triangle) {
  return source.character.materials[static_cast<size_t>(source.material_of_triangle[triangle])];
}

// The texels of a triangle's skin that a texel of a map spans along the surface, however steep it stands: from what
// masks leave is asked at places that are a texel of the map apart. corners: in texels of the map, depth in [0, 1] of
// n.
double alpha_footprint(const CaptureSource& source, uint32_t triangle, const std::array<glm::dvec3, 3>& corners,
                       size_t n) {
  const scene::Material& material = material_of(source, triangle);
  const scene::Mesh& mesh = source.character.mesh;
  if (scene::alpha_threshold(material) <= 0 || material.base_colour_image < 0 || mesh.uvs.empty()) return 1;
  const LinearPyramid& image = source.pyramids[static_cast<size_t>(material.base_colour_image)];
  const uint32_t* v = &mesh.indices[3 * size_t{triangle}];
  const glm::dvec2 size(image.width(), image.height());
  const glm::dvec2 e1 = glm::dvec2(mesh.uvs[v[1]] - mesh.uvs[v[0]]) * size;
  const glm::dvec2 e2 = glm::dvec2(mesh.uvs[v[2]] - mesh.uvs[v[0]]) * size;
  const glm::dvec3 scale(1.0, 1.0, static_cast<double>(n));
  const double area = glm::length(glm::cross(scale * (corners[1] - corners[0]), scale * (corners[2] - corners[0])));
  return std::min(std::sqrt(std::abs(e1.x * e2.y - e1.y * e2.x) / std::max(area, 1e-9)), 64.0);
}

// Whether a mask leaves the surface there.
bool is_there(const CaptureSource& source, const Winner& winner, double footprint) {
  const scene::Material& material = material_of(source, winner.triangle);
  const float threshold = scene::alpha_threshold(material);
  if (threshold <= 0) return true;
  const scene::Mesh& mesh = source.character.mesh;
  const SurfacePoint point(mesh, winner);
  double alpha = mesh.colours.empty() ? 1.0 : point.mixed<glm::dvec4>(mesh.colours).a;
  if (material.base_colour_image >= 0 && !mesh.uvs.empty())
    alpha *= source.pyramids[static_cast<size_t>(material.base_colour_image)]
                 .sample(point.mixed<glm::dvec2>(mesh.uvs), footprint)
                 .a;
  return alpha >= threshold;
}

// The unit normal in bind space, toward the face where the material has two sides: a back face seen through an opening
// shows its inner side.
glm::dvec3 normal_toward(const CaptureSource& source, const BoxSpace& space, const SurfacePoint& point,
                         const Face& face, bool double_sided) {
  glm::dvec3 n = space.bind_from_capture * point.mixed<glm::dvec3>(source.normals);
  const double along = (space.unit_from_bind * n)[face.axis];
  if (space.bends) n = point.mixed<glm::dvec3>(source.character.mesh.normals);
  const double length = glm::length(n);
  n = length > 0 ? n / length : glm::dvec3(0, 1, 0);
  return double_sided && ((face.side == 0 && along > 0) || (face.side == 1 && along < 0)) ? -n : n;
}

// sRGB, and whether it is unlit.
void store_colour(const CaptureSource& source, const Winner& winner, const Footprint& of, uint8_t* texel) {
  const scene::Mesh& mesh = source.character.mesh;
  const SurfacePoint point(mesh, winner);
  const scene::Material& material = material_of(source, winner.triangle);
  glm::dvec3 albedo = glm::dvec3(material.base_colour);
  if (!mesh.colours.empty()) albedo *= point.mixed<glm::dvec3>(mesh.colours);
  if (material.base_colour_image >= 0 && !mesh.uvs.empty())
    albedo *= sampled(source.pyramids[static_cast<size_t>(material.base_colour_image)], mesh.uvs, point, of);
  for (int c = 0; c < 3; ++c) texel[c] = linear_to_srgb8(albedo[c]);
  texel[3] = material.unlit ? 255 : 0;
}

// What a face stores of a point.
void shade(const CaptureSource& source, const BoxSpace& space, const Winner& winner, const Face& face,
           const Footprint& of, const FaceTexel& texel) {
  const scene::Mesh& mesh = source.character.mesh;
  const SurfacePoint point(mesh, winner);
  const scene::Material& material = material_of(source, winner.triangle);
  store_colour(source, winner, of, texel.colour);
  if (texel.emission != nullptr && !material.unlit) {
    glm::dvec3 glow(material.emissive / source.emission_peak);
    if (material.emissive_image >= 0)
      glow *= sampled(source.pyramids[static_cast<size_t>(material.emissive_image)],
                      mesh.emissive_uvs.empty() ? mesh.uvs : mesh.emissive_uvs, point, of);
    for (int c = 0; c < 3; ++c) texel.emission[c] = linear_to_srgb8(glow[c]);
  }
  const glm::dvec3 n = normal_toward(source, space, point, face, material.double_sided);
  for (int c = 0; c < 3; ++c) texel.normal[c] = byte_of(0.5 + 0.5 * n[c]);
  texel.normal[3] = material.slot;
}

// What surfaces lie within one texel's square.
struct Touched {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  Winner front;  // by the middle of each triangle's part in the square
  Winner back;
  bool any() const { return front.triangle != UINT32_MAX; }
};

// Widens the intervals of two neighbours to where a surface that lies in both crosses from one into the other.
void join(const Touched& a, const Touched& b, std::array<double, 2>& at_a, std::array<double, 2>& at_b) {
  const bool ordered = at_a[1] < at_b[0];
  const Touched& below = ordered ? a : b;
  const Touched& above = ordered ? b : a;
  std::array<double, 2>& lower = ordered ? at_a : at_b;
  std::array<double, 2>& upper = ordered ? at_b : at_a;
  // Diagonal neighbours share one corner, where a sloping surface has one's least and the other's greatest depth: equal
  // but for rounding.
  if (lower[1] >= upper[0] || above.low > below.high + 1e-9) return;
  const double meeting = std::clamp(0.5 * (lower[1] + upper[0]), std::min(above.low, below.high), below.high);
  lower[1] = std::max(lower[1], meeting);
  upper[0] = std::min(upper[0], meeting);
}

// What an axis of a box sees, texel by texel; the winners at texel centres, the nearest and the farthest.
struct AxisMaps {
  size_t n;  // texels a side
  std::array<std::vector<Winner>, 2> winners;
  std::vector<Touched> touched;
  std::vector<Touched> kept;                     // of these, what the winners are of
  std::vector<std::array<double, 2>> intervals;  // least and greatest depth
  explicit AxisMaps(size_t side)
      : n(side), winners{std::vector<Winner>(n * n), std::vector<Winner>(n * n)}, touched(n * n), intervals(n * n) {}
  bool covered(size_t texel) const { return winners[0][texel].triangle != UINT32_MAX; }
};

// From the winners at texel centres to closed intervals, see ReliefModel.
void close_gaps(AxisMaps& maps) {
  const size_t n = maps.n;
  const std::vector<Touched>& touched = maps.kept;
  std::vector<Winner>& front = maps.winners[0];
  std::vector<Winner>& back = maps.winners[1];
  std::vector<std::array<double, 2>>& intervals = maps.intervals;
  const auto covered = [&](size_t texel) { return maps.covered(texel); };
  for (size_t texel = 0; texel < n * n; ++texel) intervals[texel] = {front[texel].depth, back[texel].depth};
  const auto join_all = [&] {
    for (size_t v = 0; v < n; ++v) {
      for (size_t u = 0; u < n; ++u) {
        const size_t a = v * n + u;
        if (!covered(a)) continue;
        // Diagonal ones too: a step may pass a corner.
        const bool below = v + 1 < n;
        for (const size_t b : {u + 1 < n ? a + 1 : a, below ? a + n : a, below && u + 1 < n ? a + n + 1 : a,
                               below && u > 0 ? a + n - 1 : a})
          if (b != a && covered(b)) join(touched[a], touched[b], intervals[a], intervals[b]);
      }
    }
  };
  join_all();
  // Walls seen edge-on: no centre finds them, or another surface covers the centre.
  std::vector<size_t> missed;
  const double slack = 1.0 / static_cast<double>(n);
  for (size_t v = 0; v < n; ++v) {
    for (size_t u = 0; u < n; ++u) {
      const size_t texel = v * n + u;
      if (!touched[texel].any()) continue;
      bool held = false;
      for (const size_t near : {texel, u > 0 ? texel - 1 : texel, u + 1 < n ? texel + 1 : texel,
                                v > 0 ? texel - n : texel, v + 1 < n ? texel + n : texel})
        held = held || (covered(near) && intervals[near][0] <= touched[texel].low + slack &&
                        intervals[near][1] >= touched[texel].high - slack);
      if (!held) missed.push_back(texel);
    }
  }
  for (const size_t texel : missed) {
    const bool alone = !covered(texel);
    if (alone || touched[texel].low < intervals[texel][0]) {
      front[texel] = touched[texel].front;
      intervals[texel][0] = touched[texel].low;
    }
    if (alone || touched[texel].high > intervals[texel][1]) {
      back[texel] = touched[texel].back;
      intervals[texel][1] = touched[texel].high;
    }
  }
  if (!missed.empty()) join_all();
}

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
  for (int side = 0; side < 2; ++side) {
    const size_t face = box.first * 6 + static_cast<size_t>(axis * 2 + side) * texels;
    for (size_t texel = 0; texel < texels; ++texel) {
      if (!maps.covered(texel)) continue;
      const Winner& winner = maps.winners[static_cast<size_t>(side)][texel];
      const size_t byte = (face + texel) * 4;
      shade(source, space, winner, {axis, side}, {flat(in_texels(source, space, axis, maps.n, winner.triangle))},
            {model.colour.data() + byte, model.normal.data() + byte,
             model.emission.empty() ? nullptr : model.emission.data() + byte});
    }
  }
}

// Of a square of `side` texels the covered one nearest to its middle; none: n * n.
size_t middle_of(const AxisMaps& maps, size_t u, size_t v, size_t side) {
  size_t found = maps.n * maps.n;
  size_t nearest = 2 * side * side;
  const auto from = [side](size_t x) { return 2 * x + 1 > side ? 2 * x + 1 - side : side - 2 * x - 1; };
  for (size_t y = 0; y < side; ++y)
    for (size_t x = 0; x < side; ++x) {
      const size_t texel = (v * side + y) * maps.n + u * side + x;
      const size_t off = from(x) * from(x) + from(y) * from(y);
      if (off >= nearest || !maps.covered(texel)) continue;
      found = texel;
      nearest = off;
    }
  return found;
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
          Footprint of{in_texels(source, space, axis, maps.n, winner.triangle),
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
