#include "renderers/relief/relief_surface.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/colour.h"
#include "renderers/relief/relief_pyramid.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::renderers {
namespace {

uint8_t byte_of(double unit) { return static_cast<uint8_t>(std::clamp(unit, 0.0, 1.0) * 255.0 + 0.5); }

// Texels of an image that a texel's span covers, along a side: by the areas of the triangle in both.
double image_texels(const LinearPyramid& image, const std::vector<glm::vec2>& uvs, const SurfacePoint& point,
                    const TexelSpan& of) {
  const glm::dvec2 t0(uvs[point.v[0]]);
  const glm::dvec2 size(image.width(), image.height());
  const glm::dvec2 e1 = (glm::dvec2(uvs[point.v[1]]) - t0) * size;
  const glm::dvec2 e2 = (glm::dvec2(uvs[point.v[2]]) - t0) * size;
  const double skin_area = std::abs(e1.x * e2.y - e1.y * e2.x);
  const double map_area = glm::length(glm::cross(of.corners[1] - of.corners[0], of.corners[2] - of.corners[0]));
  return of.texels * std::min(std::sqrt(skin_area / std::max(map_area, 1e-9)), 64.0);
}

glm::dvec3 sampled(const LinearPyramid& image, const std::vector<glm::vec2>& uvs, const SurfacePoint& point,
                   const TexelSpan& of) {
  return {image.colour(point.mixed<glm::dvec2>(uvs), image_texels(image, uvs, point, of))};
}

// The unit normal in bind space, toward where it is seen from where the material has two sides: a back face seen
// through an opening shows its inner side.
glm::dvec3 normal_toward(const CaptureSource& source, const BoxSpace& space, const SurfacePoint& point,
                         const glm::dvec3& toward, bool double_sided) {
  glm::dvec3 n = space.bind_from_capture * point.mixed<glm::dvec3>(source.normals);
  const bool away = glm::dot(toward, n) < 0;
  if (space.bends) n = point.mixed<glm::dvec3>(source.character.mesh.normals);
  const double length = glm::length(n);
  n = length > 0 ? n / length : glm::dvec3(0, 1, 0);
  return double_sided && away ? -n : n;
}

}  // namespace

const scene::Material& material_of(const CaptureSource& source, uint32_t triangle) {
  return source.character.materials[static_cast<size_t>(source.material_of_triangle[triangle])];
}

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

void store_colour(const CaptureSource& source, const Winner& winner, const TexelSpan& of, uint8_t* texel) {
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

void shade(const CaptureSource& source, const BoxSpace& space, const Winner& winner, const glm::dvec3& toward,
           const TexelSpan& of, const FaceTexel& texel) {
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
  const glm::dvec3 n = normal_toward(source, space, point, toward, material.double_sided);
  for (int c = 0; c < 3; ++c) texel.normal[c] = byte_of(0.5 + 0.5 * n[c]);
  texel.normal[3] = material.slot;
}

}  // namespace crowdbench::renderers
