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
#include "scene/character/character.h"

namespace crowdbench::renderers {

// A texture as linear light and alpha in a box-filtered pyramid: a texel of a relief map may cover many texels of the
// skin. Every level covers as much at `threshold` as the first.
class LinearPyramid {
 public:
  LinearPyramid(const scene::Texture& texture, float threshold) : texture_(texture) {
    std::array<float, 256> decode{};
    for (int i = 0; i < 256; ++i) decode[static_cast<size_t>(i)] = static_cast<float>(srgb_to_linear(i / 255.0));
    const Image8& image = texture.image;
    Level base{image.width, image.height, std::vector<glm::vec4>(image.pixels()), 1};
    for (size_t i = 0; i < base.texels.size(); ++i) {
      const uint8_t* p = image.data.data() + i * static_cast<size_t>(image.channels);
      base.texels[i] = {decode[p[0]], decode[p[1]], decode[p[2]],
                        image.channels == 4 ? static_cast<float>(p[3]) / 255.0F : 1.0F};
    }
    levels_.push_back(std::move(base));
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
    if (threshold > 0) keep_coverage(threshold);
  }

  // footprint: texels of level 0 that one sample spans.
  glm::vec4 sample(const glm::dvec2& uv, double footprint) const {
    const double wanted = footprint > 1.0 ? std::log2(footprint) : 0.0;
    const auto level = std::min(static_cast<size_t>(wanted + 0.5), levels_.size() - 1);
    const Level& l = levels_[level];
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
    glm::vec4 texel =
        glm::mix(glm::mix(at(x0, y0), at(x0 + 1, y0), fx), glm::mix(at(x0, y0 + 1), at(x0 + 1, y0 + 1), fx), fy);
    texel.a *= l.alpha_scale;
    return texel;
  }
  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }

 private:
  struct Level {
    int width;
    int height;
    std::vector<glm::vec4> texels;
    float alpha_scale = 1;
  };

  // As the mesh's mip levels (scene/character/alpha_coverage.h).
  void keep_coverage(float threshold) {
    const auto there = [&](const glm::vec4& texel) { return texel.a >= threshold; };
    const std::vector<glm::vec4>& base = levels_[0].texels;
    const double wanted = static_cast<double>(std::count_if(base.begin(), base.end(), there)) / double(base.size());
    for (size_t l = 1; l < levels_.size(); ++l) {
      std::vector<float> alpha;
      for (const glm::vec4& texel : levels_[l].texels) alpha.push_back(texel.a);
      const auto count = static_cast<size_t>(wanted * static_cast<double>(alpha.size()) + 0.5);
      if (count == 0) continue;
      std::nth_element(alpha.begin(), alpha.begin() + long(count) - 1, alpha.end(), std::greater<>());
      if (const float least = alpha[count - 1]; least > 0) levels_[l].alpha_scale = threshold / least * (1 + 1e-6F);
    }
  }

  static int wrap(double i, int n, bool repeat, bool mirrored) {
    if (!repeat) return static_cast<int>(std::clamp(i, 0.0, n - 1.0));
    const double period = mirrored ? 2.0 * n : n;
    const double m = i - period * std::floor(i / period);
    const int k = std::min(static_cast<int>(m), static_cast<int>(period) - 1);
    return k < n ? k : 2 * n - 1 - k;
  }

  static Level halved(const Level& from) {
    Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}, 1};
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
};

}  // namespace crowdbench::renderers
