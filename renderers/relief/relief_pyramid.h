// The textures of the mesh, as the bake of reliefs samples them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "core/colour.h"
#include "scene/character/alpha_coverage.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

// A texture as linear light and alpha in a box-filtered pyramid: a texel of a relief map may cover many texels of the
// skin. Every level that alpha is taken of covers as much at `threshold` as the first.
class LinearPyramid {
 public:
  LinearPyramid(const scene::Texture& texture, float threshold) : texture_(texture) {
    std::array<float, 256> decode{};
    for (int i = 0; i < 256; ++i) decode[static_cast<size_t>(i)] = static_cast<float>(srgb_to_linear(i / 255.0));
    const Image8& image = texture.image;
    Level base{image.width, image.height, std::vector<glm::vec4>(image.pixels())};
    for (size_t i = 0; i < base.texels.size(); ++i) {
      const uint8_t* p = image.data.data() + i * static_cast<size_t>(image.channels);
      base.texels[i] = {decode[p[0]], decode[p[1]], decode[p[2]],
                        image.channels == 4 ? static_cast<float>(p[3]) / 255.0F : 1.0F};
    }
    levels_.push_back(std::move(base));
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
    alpha_levels_ = levels_.size();
    if (threshold > 0 && threshold <= 1) keep_coverage(threshold);
  }

  // footprint: texels of level 0 that one sample spans.
  glm::vec4 sample(const glm::dvec2& uv, double footprint) const {
    const double wanted = footprint > 1.0 ? std::log2(footprint) : 0.0;
    const auto level = std::min(static_cast<size_t>(wanted + 0.5), levels_.size() - 1);
    glm::vec4 texel = sample_level(levels_[level], uv);
    if (level >= alpha_levels_) texel.a = sample_level(levels_[alpha_levels_ - 1], uv).a;
    return texel;
  }
  // The colour alone, between the two levels next to the footprint, as the mesh's trilinear filter is.
  glm::vec3 colour(const glm::dvec2& uv, double footprint) const {
    const double wanted =
        std::min(footprint > 1.0 ? std::log2(footprint) : 0.0, static_cast<double>(levels_.size() - 1));
    const auto level = static_cast<size_t>(wanted);
    const glm::vec3 finer(sample_level(levels_[level], uv));
    const auto beyond = static_cast<float>(wanted - static_cast<double>(level));
    return beyond > 0 ? glm::mix(finer, glm::vec3(sample_level(levels_[level + 1], uv)), beyond) : finer;
  }
  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }

 private:
  struct Level {
    int width;
    int height;
    std::vector<glm::vec4> texels;
  };

  // As the mesh's mip levels, alpha's end where one cannot hold it; colours' do not.
  void keep_coverage(float threshold) {
    const scene::AlphaSampling sampling{true, texture_.repeat_u, texture_.repeat_v};
    const scene::CoverageKeeper keeper(alpha_of(levels_[0]), threshold, sampling, sampling);
    for (size_t l = 1; l < levels_.size(); ++l) {
      scene::AlphaLevel level = alpha_of(levels_[l]);
      if (!keeper.keep(level)) {
        alpha_levels_ = l;
        return;
      }
      for (size_t i = 0; i < level.alpha.size(); ++i)
        levels_[l].texels[i].a = static_cast<float>(level.alpha[i]) / 255.0F;
    }
  }

  static scene::AlphaLevel alpha_of(const Level& level) {
    scene::AlphaLevel out{level.width, level.height, {}};
    for (const glm::vec4& texel : level.texels)
      out.alpha.push_back(static_cast<uint8_t>(std::lround(std::clamp(texel.a, 0.0F, 1.0F) * 255.0F)));
    return out;
  }

  glm::vec4 sample_level(const Level& l, const glm::dvec2& uv) const {
    const double x = uv.x * l.width - 0.5;
    const double y = uv.y * l.height - 0.5;
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    const auto fx = static_cast<float>(x - x0);
    const auto fy = static_cast<float>(y - y0);
    const auto at = [&](double i, double j) {
      const int xi = wrap(i, l.width, texture_.repeat_u, texture_.mirrored_u);
      const int yi = wrap(j, l.height, texture_.repeat_v, texture_.mirrored_v);
      return l.texels[static_cast<size_t>(yi) * static_cast<size_t>(l.width) + static_cast<size_t>(xi)];
    };
    return glm::mix(glm::mix(at(x0, y0), at(x0 + 1, y0), fx), glm::mix(at(x0, y0 + 1), at(x0 + 1, y0 + 1), fx), fy);
  }

  static int wrap(double i, int n, bool repeat, bool mirrored) {
    if (!repeat) return static_cast<int>(std::clamp(i, 0.0, n - 1.0));
    const double period = mirrored ? 2.0 * n : n;
    const double m = i - period * std::floor(i / period);
    const int k = std::min(static_cast<int>(m), static_cast<int>(period) - 1);
    return k < n ? k : 2 * n - 1 - k;
  }

  static Level halved(const Level& from) {
    Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.texels.resize(static_cast<size_t>(to.width) * static_cast<size_t>(to.height));
    for (int y = 0; y < to.height; ++y) {
      for (int x = 0; x < to.width; ++x) {
        const int x1 = std::min(2 * x + 1, from.width - 1);
        const int y1 = std::min(2 * y + 1, from.height - 1);
        const auto at = [&](int i, int j) {
          return from.texels[static_cast<size_t>(j) * static_cast<size_t>(from.width) + static_cast<size_t>(i)];
        };
        to.texels[static_cast<size_t>(y) * static_cast<size_t>(to.width) + static_cast<size_t>(x)] =
            0.25F * (at(std::min(2 * x, from.width - 1), std::min(2 * y, from.height - 1)) +
                     at(x1, std::min(2 * y, from.height - 1)) + at(std::min(2 * x, from.width - 1), y1) + at(x1, y1));
      }
    }
    return to;
  }

  const scene::Texture& texture_;
  std::vector<Level> levels_;
  size_t alpha_levels_ = 1;  // the first so many have alpha
};

}  // namespace crowdbench::renderers
