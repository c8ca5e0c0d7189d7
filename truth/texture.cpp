// Based on: the OpenGL 4.5 core profile, 8.14 (filters), 8.14.2 (wrapping) and 8.14.4 (mip levels).
#include "truth/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "core/colour.h"
#include "scene/character/alpha_coverage.h"

namespace crowdbench::truth {
namespace {

const std::array<double, 256>& linear_of_codes() {
  static const std::array<double, 256> all = [] {
    std::array<double, 256> out{};
    for (size_t i = 0; i < out.size(); ++i) out[i] = srgb_to_linear(static_cast<double>(i) / 255.0);
    return out;
  }();
  return all;
}

glm::dvec4 decoded(const uint8_t* rgba) {
  const std::array<double, 256>& linear = linear_of_codes();
  return {linear[rgba[0]], linear[rgba[1]], linear[rgba[2]], rgba[3] / 255.0};
}

// Half as large: each texel what lies between those of the finer level at its middle, their mean where both sides
// halve.
Image8 halved(const Image8& from) {
  Image8 out(std::max(from.width / 2, 1), std::max(from.height / 2, 1), 4);
  const auto between = [](int i, int size, int finer) {
    const double at = (i + 0.5) * finer / size - 0.5;
    const int first = std::max(static_cast<int>(std::floor(at)), 0);
    return std::tuple(first, std::min(first + 1, finer - 1), std::max(at - first, 0.0));
  };
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const auto [left, right, along] = between(x, out.width, from.width);
      const auto [above, below, down] = between(y, out.height, from.height);
      const glm::dvec4 upper = glm::mix(decoded(from.at(left, above)), decoded(from.at(right, above)), along);
      const glm::dvec4 lower = glm::mix(decoded(from.at(left, below)), decoded(from.at(right, below)), along);
      const glm::dvec4 value = glm::mix(upper, lower, down);
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = linear_to_srgb8(value[c]);
      out.at(x, y)[3] = static_cast<uint8_t>(value.a * 255.0 + 0.5);
    }
  return out;
}

int64_t wrapped(int64_t i, int64_t size, bool repeat, bool mirrored) {
  if (!repeat) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mirrored ? 2 * size : size;
  const int64_t in = ((i % period) + period) % period;
  return in < size ? in : period - 1 - in;
}

bool filters_within_levels(scene::MinFilter filter) {
  return filter == scene::MinFilter::linear_mipmap_linear || filter == scene::MinFilter::linear_mipmap_nearest ||
         filter == scene::MinFilter::linear;
}
bool filters_between_levels(scene::MinFilter filter) {
  return filter == scene::MinFilter::linear_mipmap_linear || filter == scene::MinFilter::nearest_mipmap_linear;
}
bool has_levels(scene::MinFilter filter) {
  return filter != scene::MinFilter::linear && filter != scene::MinFilter::nearest;
}

// What a mask leaves of a texture stays as much on every level (scene/character/alpha_coverage.h). False where it
// cannot on this one.
bool keep_coverage(const scene::CoverageKeeper& keeper, Image8& level) {
  scene::AlphaLevel alpha{level.width, level.height, {}};
  for (size_t i = 3; i < level.data.size(); i += 4) alpha.alpha.push_back(level.data[i]);
  if (!keeper.keep(alpha)) return false;
  for (size_t i = 0; i < alpha.alpha.size(); ++i) level.data[4 * i + 3] = alpha.alpha[i];
  return true;
}

// The images of one array of the mesh that a mask tests.
struct MaskedArray {
  std::vector<TruthTexture*> textures;
  std::vector<scene::CoverageKeeper> keepers;
};

void keep_coverage(MaskedArray& array) {
  for (size_t level = 1; level < array.textures.front()->levels().size(); ++level)
    for (size_t i = 0; i < array.textures.size(); ++i)
      if (!keep_coverage(array.keepers[i], array.textures[i]->levels()[level])) {
        for (TruthTexture* texture : array.textures) texture->levels().resize(level);
        return;
      }
}

}  // namespace

double level_of(const TextureFootprint& footprint, int width, int height) {
  const glm::dvec2 size(width, height);
  return std::log2(std::max(glm::length(footprint.across * size), glm::length(footprint.down * size)));
}

TruthTexture::TruthTexture(const scene::Texture& texture) : texture_(texture) {
  if (texture.image.empty()) return;
  levels_.push_back(texture.image);
  if (!has_levels(texture.min_filter)) return;
  while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
}

glm::dvec4 TruthTexture::texel(const Image8& level, int64_t x, int64_t y) const {
  return decoded(level.at(static_cast<int>(wrapped(x, level.width, texture_.repeat_u, texture_.mirrored_u)),
                          static_cast<int>(wrapped(y, level.height, texture_.repeat_v, texture_.mirrored_v))));
}

glm::dvec4 TruthTexture::within(size_t index, const glm::dvec2& uv, bool linear) const {
  const Image8& level = levels_[index];
  // Far out a texel has no place of its own any more.
  const glm::dvec2 at = glm::clamp(uv * glm::dvec2(level.width, level.height), -1e15, 1e15);
  if (!linear) return texel(level, static_cast<int64_t>(std::floor(at.x)), static_cast<int64_t>(std::floor(at.y)));
  const glm::dvec2 corner = glm::floor(at - 0.5);
  const glm::dvec2 part = at - 0.5 - corner;
  const auto x = static_cast<int64_t>(corner.x);
  const auto y = static_cast<int64_t>(corner.y);
  return glm::mix(glm::mix(texel(level, x, y), texel(level, x + 1, y), part.x),
                  glm::mix(texel(level, x, y + 1), texel(level, x + 1, y + 1), part.x), part.y);
}

glm::dvec4 TruthTexture::sample(const glm::dvec2& uv, const TextureFootprint& footprint) const {
  const scene::MinFilter filter = texture_.min_filter;
  const double level = level_of(footprint, levels_[0].width, levels_[0].height);
  const bool linear = filters_within_levels(filter);
  const double magnified_to = !texture_.nearest && !linear && has_levels(filter) ? 0.5 : 0.0;
  if (!(level > magnified_to)) return within(0, uv, !texture_.nearest);
  const auto last = static_cast<double>(levels_.size() - 1);
  if (!filters_between_levels(filter))
    return within(static_cast<size_t>(std::min(std::ceil(level + 0.5) - 1, last)), uv, linear);
  const double clamped = std::min(level, last);
  const double finer = std::floor(clamped);
  const auto index = static_cast<size_t>(finer);
  if (clamped == finer) return within(index, uv, linear);
  return glm::mix(within(index, uv, linear), within(index + 1, uv, linear), clamped - finer);
}

std::vector<TruthTexture> make_truth_textures(const scene::Character& character) {
  std::vector<float> cutoffs(character.images.size(), 0.0F);
  std::vector<bool> shown(character.images.size(), false);
  for (const scene::Material& m : character.materials) {
    if (m.emissive_image >= 0) shown[static_cast<size_t>(m.emissive_image)] = true;
    if (m.base_colour_image < 0) continue;
    const auto image = static_cast<size_t>(m.base_colour_image);
    shown[image] = true;
    cutoffs[image] = std::max(cutoffs[image], scene::alpha_threshold(m));
  }
  static const scene::Texture nothing;
  std::vector<TruthTexture> out;
  out.reserve(character.images.size());
  for (size_t i = 0; i < character.images.size(); ++i) out.emplace_back(shown[i] ? character.images[i] : nothing);

  using Alike = std::tuple<int, int, bool, bool, bool, bool, bool, scene::MinFilter>;
  std::map<Alike, MaskedArray> arrays;
  for (size_t i = 0; i < out.size(); ++i) {
    const scene::Texture& t = character.images[i];
    if (out[i].levels().empty() || !(cutoffs[i] > 0 && cutoffs[i] <= 1)) continue;
    MaskedArray& array = arrays[{t.image.width, t.image.height, t.repeat_u, t.repeat_v, t.mirrored_u, t.mirrored_v,
                                 t.nearest, t.min_filter}];
    scene::AlphaLevel base{t.image.width, t.image.height, {}};
    for (size_t k = 3; k < t.image.data.size(); k += 4) base.alpha.push_back(t.image.data[k]);
    const bool between = filters_within_levels(t.min_filter) && has_levels(t.min_filter);
    array.textures.push_back(&out[i]);
    array.keepers.emplace_back(base, cutoffs[i], scene::AlphaSampling{!t.nearest, t.repeat_u, t.repeat_v},
                               scene::AlphaSampling{between, t.repeat_u, t.repeat_v});
  }
  for (auto& [alike, array] : arrays) keep_coverage(array);
  return out;
}

}  // namespace crowdbench::truth
