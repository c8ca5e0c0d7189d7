#include "renderers/bake/emission.h"

#include <algorithm>
#include <array>

#include "core/colour.h"

namespace crowdbench::renderers {
namespace {

// By component; linear light.
glm::vec3 brightest(const Image8& image) {
  std::array<uint8_t, 3> most{};
  for (size_t i = 0; i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) most[c] = std::max(most[c], image.data[i * static_cast<size_t>(image.channels) + c]);
  return {srgb_to_linear(most[0] / 255.0), srgb_to_linear(most[1] / 255.0), srgb_to_linear(most[2] / 255.0)};
}

}  // namespace

float emission_peak(const scene::Character& character) {
  float peak = 0;
  std::vector<bool> seen(character.materials.size());
  for (const scene::Primitive& primitive : character.mesh.primitives) {
    const auto m = static_cast<size_t>(primitive.material);
    if (primitive.index_count == 0 || seen[m]) continue;
    seen[m] = true;
    const scene::Material& material = character.materials[m];
    if (material.unlit || material.emissive == glm::vec3(0.0F)) continue;
    glm::vec3 most = material.emissive;
    if (material.emissive_image >= 0)
      most *= brightest(character.images[static_cast<size_t>(material.emissive_image)].image);
    peak = std::max({peak, most.r, most.g, most.b});
  }
  return peak;
}

}  // namespace crowdbench::renderers
