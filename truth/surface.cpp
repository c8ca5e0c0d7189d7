#include "truth/surface.h"

#include <algorithm>
#include <cmath>

#include "scene/character/alpha_coverage.h"

namespace crowdbench::truth {
namespace {

// How the weights of a triangle's corners change with the ray's direction. A corner's share of a direction d is d . n_i
// with n_i the cross product of the other two corners, seen from the eye; weights are those shares over their sum.
struct WeightSlopes {
  glm::dvec3 across, down;
};
WeightSlopes slopes_of(const glm::dvec3 posed[3], const glm::dvec3& weights, const View& view,
                       const glm::dvec3& direction, double step) {
  glm::dvec3 shares_across;
  glm::dvec3 shares_down;
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 n = glm::cross(posed[(i + 1) % 3], posed[(i + 2) % 3]);
    shares_across[i] = step * glm::dot(view.right(), n);
    shares_down[i] = step * glm::dot(view.down(), n);
    sum += glm::dot(direction, n);
  }
  const auto slope = [&](const glm::dvec3& shares) {
    return (shares - weights * (shares.x + shares.y + shares.z)) / sum;
  };
  return {slope(shares_across), slope(shares_down)};
}

template <typename T>
auto interpolated(const std::vector<T>& values, const uint32_t* corners, const glm::dvec3& weights) {
  using Double = glm::vec<T::length(), double>;
  return weights.x * Double(values[corners[0]]) + weights.y * Double(values[corners[1]]) +
         weights.z * Double(values[corners[2]]);
}

double covered_from_0(double x, double half_width) {
  const double whole = std::floor(x);
  return whole * 2 * half_width + std::min(x - whole, 2 * half_width);
}

}  // namespace

glm::dvec3 shade(const scene::Light& light, const glm::dvec3& albedo, const glm::dvec3& normal, bool unlit,
                 const glm::dvec3& emissive) {
  if (unlit) return albedo;
  const glm::dvec3 towards = glm::normalize(glm::dvec3(light.direction));
  const double length = glm::length(normal);
  const double lambert = length > 0 ? std::max(0.0, glm::dot(normal, towards) / length) : 0.0;
  return albedo * (static_cast<double>(light.ambient) + static_cast<double>(light.diffuse) * lambert) + emissive;
}

double line_coverage(double x, double width, double half_width) {
  const double w = std::max(width, 1e-6);
  const double from = covered_from_0(x - 0.5 * w + half_width, half_width);
  return std::clamp((covered_from_0(x + 0.5 * w + half_width, half_width) - from) / w, 0.0, 1.0);
}

Surface::Surface(const scene::Character& character)
    : character_(character),
      indices_(drawn_indices(character.mesh)),
      primitive_of_(primitives_of_triangles(character.mesh)),
      textures_(make_truth_textures(character)) {
  for (const scene::Material& m : character.materials)
    threshold_.push_back(static_cast<double>(scene::alpha_threshold(m)));
}

uint32_t Surface::material_index(uint32_t triangle) const {
  return static_cast<uint32_t>(character_.mesh.primitives[primitive_of_[triangle]].material);
}
const scene::Material& Surface::material(uint32_t triangle) const {
  return character_.materials[material_index(triangle)];
}

// White where the material has no such image.
glm::dvec4 Surface::texel(int image, const std::vector<glm::vec2>& uvs, uint32_t triangle, const glm::dvec3 posed[3],
                          const glm::dvec3& weights, const View& view, const glm::dvec3& direction, double step) const {
  if (image < 0 || textures_[static_cast<size_t>(image)].levels().empty()) return glm::dvec4(1.0);
  glm::dvec2 uv(0.0);
  TextureFootprint footprint;
  if (!uvs.empty()) {
    const uint32_t* corners = indices_.data() + size_t{3} * triangle;
    const WeightSlopes slopes = slopes_of(posed, weights, view, direction, step);
    uv = interpolated(uvs, corners, weights);
    footprint = {interpolated(uvs, corners, slopes.across), interpolated(uvs, corners, slopes.down)};
  }
  return textures_[static_cast<size_t>(image)].sample(uv, footprint);
}

double Surface::above_cutoff(uint32_t triangle, const glm::dvec3 posed[3], const glm::dvec3& weights, const View& view,
                             const glm::dvec3& direction, double step) const {
  const scene::Mesh& mesh = character_.mesh;
  double alpha =
      texel(material(triangle).base_colour_image, mesh.uvs, triangle, posed, weights, view, direction, step).a;
  if (!mesh.colours.empty()) alpha *= interpolated(mesh.colours, indices_.data() + size_t{3} * triangle, weights).a;
  return alpha - threshold_[material_index(triangle)];
}

Surface::Shaded Surface::shaded(uint32_t triangle, const TriangleHit& hit, const AgentPose& pose, uint32_t outfit,
                                const scene::Frame& frame, const View& view, const glm::dvec3& direction,
                                double step) const {
  const scene::Mesh& mesh = character_.mesh;
  const scene::Material& m = material(triangle);
  const uint32_t* corners = indices_.data() + size_t{3} * triangle;
  glm::dvec3 posed[3];
  glm::dvec3 normal(0.0);
  for (int i = 0; i < 3; ++i) {
    posed[i] = pose.position(corners[i]);
    normal += hit.weights[i] * pose.normal(corners[i]);
  }
  if (hit.back) normal = -normal;
  if (mesh.primitives[primitive_of_[triangle]].flat) {
    // The face as it is posed, its side towards the eye. A face of no extent keeps what was interpolated.
    const glm::dvec3 face = glm::cross(posed[1] - posed[0], posed[2] - posed[0]);
    if (glm::dot(face, face) > 0) normal = hit.back ? -face : face;
  }
  const auto look_up = [&](int image, const std::vector<glm::vec2>& uvs) {
    return glm::dvec3(texel(image, uvs, triangle, posed, hit.weights, view, direction, step));
  };
  glm::dvec3 albedo = glm::dvec3(m.base_colour) * look_up(m.base_colour_image, mesh.uvs);
  if (!mesh.colours.empty()) albedo *= glm::dvec3(interpolated(mesh.colours, corners, hit.weights));
  if (m.slot < scene::kOutfitSlots) albedo *= glm::dvec3(frame.outfits[outfit].colours[m.slot]);
  glm::dvec3 emissive(m.emissive);
  if (emissive != glm::dvec3(0.0))
    emissive *= look_up(m.emissive_image, mesh.emissive_uvs.empty() ? mesh.uvs : mesh.emissive_uvs);
  const double length = glm::length(normal);
  return {length > 0 ? normal / length : normal, shade(frame.light, albedo, normal, m.unlit, emissive)};
}

std::optional<double> ground_depth(const scene::Frame& frame, const View& view, const glm::dvec3& direction) {
  if (!frame.ground) return std::nullopt;
  const double depth = (frame.ground_height - frame.origin.y) / direction.y;
  if (!(depth > view.near()) || !(depth <= view.far()) || !std::isfinite(depth)) return std::nullopt;
  return depth;
}

glm::dvec3 ground_colour(const scene::Frame& frame, const View& view, const glm::dvec3& direction, double depth,
                         double step) {
  // By how much the place on the ground changes when the direction does: the depth changes with it.
  const auto moved = [&](const glm::dvec3& by) {
    const glm::dvec3 d = step * by;
    return depth * (glm::dvec2(d.x, d.z) - glm::dvec2(direction.x, direction.z) * (d.y / direction.y));
  };
  const glm::dvec2 place = depth * glm::dvec2(direction.x, direction.z);
  const glm::dvec2 footprint = glm::abs(moved(view.right())) + glm::abs(moved(view.down()));
  constexpr double kHalfWidth = 0.015;
  const auto within_cell = [](double x) { return x - std::floor(x); };
  const double across = line_coverage(place.x + within_cell(frame.origin.x), footprint.x, kHalfWidth);
  const double along = line_coverage(place.y + within_cell(frame.origin.z), footprint.y, kHalfWidth);
  const double grey = glm::mix(0.30, 0.16, 1 - (1 - across) * (1 - along));
  const double fade = std::exp2(-glm::dot(place, place) / (120.0 * 120.0));
  return glm::mix(glm::dvec3(frame.background), glm::dvec3(grey), fade);
}

}  // namespace crowdbench::truth
