// Textures as OpenGL samples them, in double: mip levels, wrapping and filters. See truth.h for what is exact.
#pragma once
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::truth {

// How texture coordinates change from one sample to the next, along the picture's rows and columns.
struct TextureFootprint {
  glm::dvec2 across{0.0};
  glm::dvec2 down{0.0};
};

class TruthTexture {
 public:
  // Refers to the texture, whose image has 4 channels and at least one texel.
  explicit TruthTexture(const scene::Texture& texture);

  // Linear RGB and alpha at uv; (0, 0) is the outer corner of the image's first texel, v downwards.
  glm::dvec4 sample(const glm::dvec2& uv, const TextureFootprint& footprint) const;

  // Levels that are sampled; changing them is how masks keep what they cover.
  std::vector<Image8>& levels() { return levels_; }
  const std::vector<Image8>& levels() const { return levels_; }

 private:
  glm::dvec4 texel(const Image8& level, int64_t x, int64_t y) const;
  glm::dvec4 within(size_t level, const glm::dvec2& uv, bool linear) const;
  const scene::Texture& texture_;
  std::vector<Image8> levels_;
};

// A character's images that its materials show; without levels where none shows them. As the mesh has them, those that
// share a texture array share how many levels there are.
std::vector<TruthTexture> make_truth_textures(const scene::Character& character);

// log2 of how many texels of the first level a sample's footprint is long (OpenGL 4.5, 8.14.1).
double level_of(const TextureFootprint& footprint, int width, int height);

}  // namespace crowdbench::truth
