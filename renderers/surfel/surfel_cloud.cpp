// Based on: candidates by area: M. Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018), within
// triangles; order: surfel_order.cpp.
#include "renderers/surfel/surfel_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/colour.h"
#include "renderers/surfel/surfel_area.h"
#include "renderers/surfel/surfel_border.h"
#include "renderers/surfel/surfel_grid.h"
#include "renderers/surfel/surfel_order.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

constexpr size_t kCandidates = 8;  // for each surfel

struct Candidate {
  const scene::Primitive* primitive = nullptr;
  // In one order whichever comes first in the mesh and whichever way they turn there, so that a figure and its mirror
  // image have the same points.
  std::array<uint32_t, 3> corners{};
  glm::vec3 at{0.0F};   // barycentric
  size_t triangle = 0;  // of the mesh's indices
};

// As the mesh has them.
std::array<uint32_t, 3> turned_corners(const scene::Mesh& mesh, const Candidate& c) {
  return {mesh.indices[3 * c.triangle], mesh.indices[3 * c.triangle + 1], mesh.indices[3 * c.triangle + 2]};
}

template <typename T>
T blend(const std::vector<T>& values, const Candidate& c) {
  return c.at.x * values[c.corners[0]] + c.at.y * values[c.corners[1]] + c.at.z * values[c.corners[2]];
}

// Nearest texel, linear light and alpha.
glm::vec4 texel_of(const scene::Texture& texture, const glm::vec2& uv) {
  const Image8& image = texture.image;
  const auto place = [](float u, int size, bool repeat, bool mirrored) {
    if (repeat && mirrored) {
      u -= 2 * std::floor(u / 2);
      u = u > 1 ? 2 - u : u;
    } else if (repeat) {
      u -= std::floor(u);
    }
    return std::clamp(static_cast<int>(u * static_cast<float>(size)), 0, size - 1);
  };
  const uint8_t* p = image.at(place(uv.x, image.width, texture.repeat_u, texture.mirrored_u),
                              place(uv.y, image.height, texture.repeat_v, texture.mirrored_v));
  const auto linear = [&](int k) { return static_cast<float>(srgb_to_linear(p[k] / 255.0)); };
  return {linear(0), linear(1), linear(2), static_cast<float>(p[3]) / 255};
}

const scene::Texture* image_of(const scene::Character& character, int image) {
  if (image < 0 || character.images[static_cast<size_t>(image)].image.empty()) return nullptr;
  return &character.images[static_cast<size_t>(image)];
}

// The base colour's image and the vertex colour at a place: linear light and alpha, before the material's factor.
glm::vec4 painted(const scene::Character& character, const Candidate& c) {
  const scene::Mesh& mesh = character.mesh;
  const scene::Material& m = character.materials[static_cast<size_t>(c.primitive->material)];
  glm::vec4 texel(1.0F);
  if (const scene::Texture* image = image_of(character, m.base_colour_image))
    texel = texel_of(*image, mesh.uvs.empty() ? glm::vec2(0.0F) : blend(mesh.uvs, c));
  if (!mesh.colours.empty()) texel *= blend(mesh.colours, c);
  return texel;
}

// Colour and light of a place; false where a mask cuts it out.
bool look(const scene::Character& character, const Candidate& c, Surfel& out) {
  const scene::Mesh& mesh = character.mesh;
  const scene::Material& m = character.materials[static_cast<size_t>(c.primitive->material)];
  const glm::vec2 uv = mesh.uvs.empty() ? glm::vec2(0.0F) : blend(mesh.uvs, c);
  const glm::vec4 texel = painted(character, c);
  if (texel.a < scene::alpha_threshold(m)) return false;
  out.colour = glm::vec3(m.base_colour) * glm::vec3(texel);
  out.emissive = m.unlit ? glm::vec3(0.0F) : m.emissive;
  if (const scene::Texture* image = image_of(character, m.emissive_image))
    out.emissive *= glm::vec3(texel_of(*image, mesh.emissive_uvs.empty() ? uv : blend(mesh.emissive_uvs, c)));
  out.slot = m.slot;
  out.unlit = m.unlit;
  out.double_sided = m.double_sided;
  return true;
}

// The corners' influences together, the four largest.
void blend_weights(const scene::Mesh& mesh, const Candidate& c, Surfel& out) {
  std::vector<std::pair<uint16_t, float>> all;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 4; ++i) {
      const uint16_t joint = mesh.joints[c.corners[static_cast<size_t>(k)]][i];
      const float weight = c.at[k] * mesh.weights[c.corners[static_cast<size_t>(k)]][i];
      const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.first == joint; });
      if (found != all.end())
        found->second += weight;
      else
        all.emplace_back(joint, weight);
    }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  all.resize(std::max<size_t>(all.size(), 4), {all.front().first, 0.0F});
  const float sum = all[0].second + all[1].second + all[2].second + all[3].second;
  for (int i = 0; i < 4; ++i) {
    out.joints[i] = all[static_cast<size_t>(i)].first;
    out.weights[i] = all[static_cast<size_t>(i)].second / sum;
  }
}

// `count` places, as many on each triangle as its area has a share in. first: where in their sequence they begin. area:
// of all, square metres.
std::vector<Candidate> candidates_of(const scene::Mesh& mesh, const std::vector<glm::vec3>& posed, size_t count,
                                     size_t first, double& area) {
  struct Triangle {
    Candidate corners;
    double end = 0;  // of its area, summed over those before it too
  };
  std::vector<Triangle> triangles;
  area = 0;
  for (const scene::Primitive& p : mesh.primitives)
    for (uint32_t i = 0; i + 2 < p.index_count; i += 3) {
      Triangle t;
      t.corners.primitive = &p;
      t.corners.triangle = (p.first_index + i) / 3;
      t.corners.corners = turned_corners(mesh, t.corners);
      std::sort(t.corners.corners.begin(), t.corners.corners.end());
      const auto& [a, b, c] = t.corners.corners;
      area += 0.5 * static_cast<double>(glm::length(glm::cross(posed[b] - posed[a], posed[c] - posed[a])));
      t.end = area;
      triangles.push_back(t);
    }
  std::vector<Candidate> out;
  size_t at = 0;
  for (size_t i = 0; i < count && area > 0; ++i) {
    const double place = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * area;
    while (at + 1 < triangles.size() && triangles[at].end < place) ++at;
    Candidate c = triangles[at].corners;
    // Roberts' two-dimensional sequence, folded into the triangle.
    double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(first + i), 1.0);
    double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(first + i), 1.0);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    c.at = {static_cast<float>(1 - u - v), static_cast<float>(u), static_cast<float>(v)};
    out.push_back(c);
  }
  return out;
}

glm::vec3 unit_or_up(const glm::vec3& v) {
  const float length = glm::length(v);
  return length > 0 ? v / length : glm::vec3(0.0F, 1.0F, 0.0F);
}

// Each surfel's colours become the means over the candidates nearest to it that an outfit colours alike.
void average_colours(const std::vector<Surfel>& candidates, const SurfelOrder& order, std::vector<Surfel>& surfels) {
  std::vector<int> counts(surfels.size(), 0);
  for (Surfel& s : surfels) s.colour = s.emissive = glm::vec3(0.0F);
  for (size_t i = 0; i < candidates.size(); ++i) {
    Surfel& to = surfels[order.nearest[i]];
    if (candidates[i].slot != to.slot || candidates[i].unlit != to.unlit) continue;
    to.colour += candidates[i].colour;
    to.emissive += candidates[i].emissive;
    ++counts[order.nearest[i]];
  }
  for (size_t i = 0; i < surfels.size(); ++i) {
    surfels[i].colour /= static_cast<float>(std::max(counts[i], 1));
    surfels[i].emissive /= static_cast<float>(std::max(counts[i], 1));
  }
}

// What lies on the surface in the bank's first pose, and what lies beside it.
struct Sampled {
  std::vector<Surfel> candidates;
  std::vector<SheetPlace> on;      // of each
  std::vector<SheetPlace> beside;  // where a mask cuts it out, and beyond its borders
};

// Reflects a place in the borders of its triangle, to beside the surface.
struct Beyond {
  SheetPlace sheet;
  glm::vec3 edge{0.0F}, outward{0.0F};  // a place on the edge; unit
};
void reflect(const Candidate& c, const std::array<uint32_t, 3>& turned, const SheetPlace& sheet,
             const std::array<bool, 3>& borders, const std::vector<glm::vec3>& posed, std::vector<Beyond>& out) {
  for (size_t k = 0; k < 3; ++k) {
    if (!borders[k]) continue;
    const glm::vec3& a = posed[turned[k]];
    const glm::vec3 along = posed[turned[(k + 1) % 3]] - a;
    const uint32_t opposite = turned[(k + 2) % 3];
    const glm::vec3 to = posed[opposite] - a;
    const glm::vec3 height = to - along * (glm::dot(to, along) / std::max(glm::dot(along, along), 1e-30F));
    const float length = glm::length(height);
    if (length <= 0) continue;
    Beyond b{sheet, a, -height / length};
    const auto corner = std::find(c.corners.begin(), c.corners.end(), opposite) - c.corners.begin();
    b.sheet.place.position -= 2 * c.at[static_cast<int>(corner)] * height;
    out.push_back(b);
  }
}

// Leaves out what another triangle fills: of a neighbour whose corners lie elsewhere, as where parts meet.
void keep_empty(const std::vector<Beyond>& beyond, float apart, Sampled& sampled) {
  std::vector<SurfacePlace> on;
  for (const SheetPlace& s : sampled.on) on.push_back(s.place);
  const SurfaceGrid grid(on, apart);
  for (const Beyond& b : beyond) {
    bool filled = false;
    grid.near(b.sheet.place.position, [&](uint32_t k) {
      filled = filled || (glm::distance(on[k].position, b.sheet.place.position) < apart &&
                          glm::dot(on[k].normal, b.sheet.place.normal) > 0.5F &&
                          glm::dot(on[k].position - b.edge, b.outward) > 0.25F * apart);
    });
    if (!filled) sampled.beside.push_back(b.sheet);
  }
}

// first: as of candidates_of.
Sampled sample_surface(const scene::Character& character, const std::vector<glm::vec3>& posed, size_t count,
                       size_t first) {
  const scene::Mesh& mesh = character.mesh;
  const std::vector<std::array<bool, 3>> borders = find_borders(mesh);
  Sampled out;
  std::vector<Beyond> beyond;
  double area = 0;
  const std::vector<Candidate> candidates = candidates_of(mesh, posed, count, first, area);
  for (const Candidate& c : candidates) {
    const std::array<uint32_t, 3> turned = turned_corners(mesh, c);
    const auto& [i, j, k] = turned;
    const glm::vec3 face = unit_or_up(glm::cross(posed[j] - posed[i], posed[k] - posed[i]));
    const SheetPlace sheet{{blend(posed, c), c.primitive->mirrored ? -face : face},
                           static_cast<uint32_t>(c.primitive - mesh.primitives.data())};
    Surfel s;
    if (!look(character, c, s)) {
      out.beside.push_back(sheet);
      continue;
    }
    s.position = blend(mesh.positions, c);
    s.normal = unit_or_up(blend(mesh.normals, c));
    blend_weights(mesh, c, s);
    out.candidates.push_back(s);
    out.on.push_back(sheet);
    reflect(c, turned, sheet, borders[c.triangle], posed, beyond);
  }
  constexpr double kApart = 1.5;  // of the width of a square that a candidate stands for
  if (!beyond.empty())
    keep_empty(beyond, static_cast<float>(kApart * std::sqrt(area / static_cast<double>(count))), out);
  return out;
}

// How far discs may reach at each level. judged: other places than those of `sampled`, at which reaches end: between
// those as much is covered as anywhere.
void fit_discs(const scene::Character& character, const scene::PoseBank& bank, const Sampled& sampled,
               const Sampled& judged, const SurfelOrder& order, double cover, SurfelCloud& cloud) {
  std::vector<SheetPlace> sheets;
  for (const uint32_t i : order.order) sheets.push_back(sampled.on[i]);
  cloud.levels = surfel_levels(order.radius);
  const std::vector<float> reaches = find_reaches(sheets, sampled.beside, cloud.levels);
  for (size_t i = 0; i < reaches.size(); ++i) cloud.surfels[i].reach = reaches[i];
  for (SurfelLevel& level : cloud.levels)
    level.reach = fit_reach(std::span(sheets).first(level.points), reaches, judged.on, judged.beside,
                            static_cast<float>(level.radius * cover));
  const std::vector<SurfelArea> areas = fit_areas(character, bank, cloud.surfels, cloud.levels, cover);
  for (size_t k = 0; k < cloud.levels.size(); ++k) {
    cloud.levels[k].thin = static_cast<double>(areas[k].thin);
    cloud.levels[k].uneven = static_cast<double>(areas[k].uneven);
    cloud.levels[k].closed = static_cast<double>(areas[k].closed);
    cloud.levels[k].over = static_cast<double>(areas[k].over);
  }
}

}  // namespace

Surfel in_pose(Surfel surfel, std::span<const scene::Mat3x4> palette) {
  glm::vec4 rows[3] = {glm::vec4(0.0F), glm::vec4(0.0F), glm::vec4(0.0F)};
  for (int k = 0; k < 4; ++k)
    for (int r = 0; r < 3; ++r) rows[r] += surfel.weights[k] * palette[surfel.joints[k]].rows[r];
  const glm::vec4 place(surfel.position, 1.0F);
  const glm::vec3 normal = surfel.normal;
  for (int r = 0; r < 3; ++r) {
    surfel.position[r] = glm::dot(rows[r], place);
    surfel.normal[r] = glm::dot(glm::vec3(rows[r]), normal);
  }
  surfel.normal = unit_or_up(surfel.normal);
  return surfel;
}

bool is_there(const scene::Character& character, const scene::Primitive& primitive,
              const std::array<uint32_t, 3>& corners, const glm::vec3& at) {
  const float least = scene::alpha_threshold(character.materials[static_cast<size_t>(primitive.material)]);
  return least <= 0 || painted(character, {&primitive, corners, at, 0}).a >= least;
}

SurfelCloud make_surfel_cloud(const scene::Character& character, const scene::PoseBank& bank, size_t count,
                              double cover, const BakeProgress& progress) {
  const std::vector<glm::vec3> posed = scene::skin_points(character.mesh, bank.palette(bank.sample(0, 0.0)));
  const Sampled sampled = sample_surface(character, posed, kCandidates * count, 0);
  SurfelCloud out;
  if (sampled.candidates.empty()) return out;
  std::vector<SurfacePlace> places;
  for (const SheetPlace& s : sampled.on) places.push_back(s.place);
  const SurfelOrder order = order_places(places, count, progress);
  for (const uint32_t i : order.order) out.surfels.push_back(sampled.candidates[i]);
  average_colours(sampled.candidates, order, out.surfels);
  const Sampled judged =
      sampled.beside.empty() ? Sampled() : sample_surface(character, posed, kCandidates * count, kCandidates * count);
  fit_discs(character, bank, sampled, judged, order, cover, out);
  return out;
}

}  // namespace crowdbench::renderers
