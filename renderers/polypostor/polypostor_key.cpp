#include "renderers/polypostor/polypostor_key.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderers/polypostor/polypostor_contour.h"

namespace crowdbench::renderers {
namespace {

// q -> matrix * q + shift.
struct Affine {
  glm::dmat2 matrix{1.0};
  glm::dvec2 shift{0.0};
};

// At most about kPoints of the corners: neighbours move alike.
Affine fit_affine(std::span<const uint32_t> corners, std::span<const glm::dvec3> from, std::span<const glm::dvec3> to) {
  constexpr size_t kPoints = 256;
  const size_t step = corners.size() / kPoints + 1;
  glm::dvec2 mean_from(0.0);
  glm::dvec2 mean_to(0.0);
  double count = 0;
  for (size_t i = 0; i < corners.size(); i += step) {
    mean_from += glm::dvec2(from[corners[i]]);
    mean_to += glm::dvec2(to[corners[i]]);
    count += 1;
  }
  mean_from /= count;
  mean_to /= count;
  glm::dmat2 square(0.0);
  glm::dmat2 mixed(0.0);
  for (size_t i = 0; i < corners.size(); i += step) {
    const glm::dvec2 p = glm::dvec2(from[corners[i]]) - mean_from;
    const glm::dvec2 q = glm::dvec2(to[corners[i]]) - mean_to;
    square += glm::outerProduct(p, p);
    mixed += glm::outerProduct(q, p);
  }
  // A part as thin as a line keeps its width.
  const double thin = 1e-3 * (square[0][0] + square[1][1]) + 1e-9;
  Affine out;
  out.matrix = (mixed + glm::dmat2(thin)) * glm::inverse(square + glm::dmat2(thin));
  out.shift = mean_to - out.matrix * mean_from;
  return out;
}

// Square root of linear: the sRGB curve is one but for some percent.
glm::vec3 nearest_texel(const scene::Character& character, int image_index, const glm::vec2& uv) {
  const Image8& image = character.images[static_cast<size_t>(image_index)].image;
  const auto texel = [](float at, int size) {
    return std::clamp(static_cast<int>((at - std::floor(at)) * static_cast<float>(size)), 0, size - 1);
  };
  const uint8_t* t = image.at(texel(uv.x, image.width), texel(uv.y, image.height));
  return glm::vec3(t[0], t[1], t[2]) / 255.0F;
}

}  // namespace

std::vector<glm::vec3> vertex_tones(const scene::Character& character) {
  const scene::Mesh& mesh = character.mesh;
  std::vector<glm::vec3> tones(mesh.positions.size(), glm::vec3(1.0F));
  for (const scene::Primitive& primitive : mesh.primitives) {
    const scene::Material& material = character.materials[static_cast<size_t>(primitive.material)];
    for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
      glm::vec3 colour(material.base_colour);
      if (!mesh.colours.empty()) colour *= glm::vec3(mesh.colours[v]);
      glm::vec3 tone = glm::sqrt(glm::clamp(colour, 0.0F, 1.0F));
      if (material.base_colour_image >= 0) tone *= nearest_texel(character, material.base_colour_image, mesh.uvs[v]);
      if (!material.unlit && material.emissive != glm::vec3(0.0F)) {
        glm::vec3 glow = glm::sqrt(glm::clamp(material.emissive, 0.0F, 1.0F));
        if (material.emissive_image >= 0)
          glow *= nearest_texel(character, material.emissive_image,
                                mesh.emissive_uvs.empty() ? mesh.uvs[v] : mesh.emissive_uvs[v]);
        tone = glm::sqrt(glm::min(tone * tone + glow * glow, 1.0F));
      }
      tones[v] = tone;
    }
  }
  return tones;
}

PartLook look_at_part(std::span<const uint32_t> corners, std::span<const glm::dvec3> positions,
                      std::span<const glm::vec3> normals, std::span<const glm::vec3> tones) {
  PartLook look;
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const uint32_t v : corners) {
    low = glm::min(low, glm::dvec2(positions[v]));
    high = glm::max(high, glm::dvec2(positions[v]));
  }
  if (corners.empty()) return look;
  look.x = static_cast<int>(std::floor(low.x));
  look.y = static_cast<int>(std::floor(low.y));
  look.width = static_cast<int>(std::ceil(high.x)) - look.x;
  look.height = static_cast<int>(std::ceil(high.y)) - look.y;
  look.samples.resize(static_cast<size_t>(look.width) * static_cast<size_t>(look.height));
  std::vector<double> depth(look.samples.size(), -INFINITY);
  const glm::dvec2 origin(look.x + 0.5, look.y + 0.5);
  for (size_t t = 0; t + 2 < corners.size(); t += 3) {
    std::array<glm::dvec2, 3> p;
    for (size_t k = 0; k < 3; ++k) p[k] = glm::dvec2(positions[corners[t + k]]) - origin;
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (std::abs(area) < 1e-12) continue;
    const auto first = [](double v) { return std::max(0, static_cast<int>(std::ceil(v))); };
    const auto last = [](double v, int size) { return std::min(size - 1, static_cast<int>(std::floor(v))); };
    const int r1 = last(std::max({p[0].y, p[1].y, p[2].y}), look.height);
    const int c1 = last(std::max({p[0].x, p[1].x, p[2].x}), look.width);
    for (int r = first(std::min({p[0].y, p[1].y, p[2].y})); r <= r1; ++r)
      for (int c = first(std::min({p[0].x, p[1].x, p[2].x})); c <= c1; ++c) {
        const glm::dvec2 q(c, r);
        const std::array<double, 3> w = {cross(p[1] - q, p[2] - q) / area, cross(p[2] - q, p[0] - q) / area,
                                         cross(p[0] - q, p[1] - q) / area};
        if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
        double z = 0;
        for (size_t k = 0; k < 3; ++k) z += w[k] * positions[corners[t + k]].z;
        const size_t at = static_cast<size_t>(r) * static_cast<size_t>(look.width) + static_cast<size_t>(c);
        if (z <= depth[at]) continue;
        depth[at] = z;
        PartLook::Sample sample;
        for (size_t k = 0; k < 3; ++k) {
          sample.tone += static_cast<float>(w[k]) * tones[corners[t + k]];
          sample.normal += static_cast<float>(w[k]) * normals[corners[t + k]];
        }
        if (area < 0) sample.normal = -sample.normal;
        const float length = glm::length(sample.normal);
        sample.normal = length > 1e-6F ? sample.normal / length : glm::vec3(0.0F, 0.0F, 1.0F);
        look.samples[at] = sample;
      }
  }
  return look;
}

double look_error(const PartLook& shown, const PartLook& wanted, std::span<const uint32_t> corners,
                  std::span<const glm::dvec3> shown_positions, std::span<const glm::dvec3> wanted_positions) {
  const Affine back = fit_affine(corners, wanted_positions, shown_positions);
  // The turn from the image to the frame: against that of `back`.
  const glm::dvec2 turn(back.matrix[0][0] + back.matrix[1][1], back.matrix[0][1] - back.matrix[1][0]);
  const double length = glm::length(turn);
  const float c = length > 1e-12 ? static_cast<float>(turn.x / length) : 1.0F;
  const float s = length > 1e-12 ? static_cast<float>(turn.y / length) : 0.0F;
  double error = 0;
  size_t at = 0;
  for (int r = 0; r < wanted.height; ++r)
    for (int col = 0; col < wanted.width; ++col, ++at) {
      const PartLook::Sample& b = wanted.samples[at];
      if (b.normal == glm::vec3(0.0F)) continue;
      const glm::dvec2 q = back.matrix * glm::dvec2(wanted.x + col + 0.5, wanted.y + r + 0.5) + back.shift;
      const int x = static_cast<int>(std::floor(q.x)) - shown.x;
      const int y = static_cast<int>(std::floor(q.y)) - shown.y;
      const PartLook::Sample* a = nullptr;
      if (x >= 0 && y >= 0 && x < shown.width && y < shown.height)
        a = &shown.samples[static_cast<size_t>(y) * static_cast<size_t>(shown.width) + static_cast<size_t>(x)];
      // Light from everywhere, without its clamp: a third of the squared length.
      if (a == nullptr || a->normal == glm::vec3(0.0F)) {
        error += kUnseen * static_cast<double>(glm::dot(b.tone, b.tone)) / 3;
        continue;
      }
      const glm::vec3 normal(c * a->normal.x + s * a->normal.y, c * a->normal.y - s * a->normal.x, a->normal.z);
      for (int k = 0; k < 3; ++k) {
        const glm::vec3 difference = b.tone[k] * b.normal - a->tone[k] * normal;
        error += static_cast<double>(glm::dot(difference, difference)) / 3;
      }
    }
  return error;
}

}  // namespace crowdbench::renderers
