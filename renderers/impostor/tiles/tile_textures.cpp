#include "renderers/impostor/tiles/tile_textures.h"

#include <epoxy/gl.h>

namespace crowdbench::renderers {

gl::Texture upload_layers(gl::Context& context, unsigned stored, unsigned format, int width, int height, int layers,
                          std::span<const uint8_t> texels) {
  gl::Texture texture = gl::Texture::make_array(context, stored, width, height, layers, 1);
  const size_t layer_bytes = texels.size() / static_cast<size_t>(layers);
  for (int layer = 0; layer < layers; ++layer)
    texture.write(0, layer, format, GL_UNSIGNED_BYTE, texels.data() + static_cast<size_t>(layer) * layer_bytes);
  return texture;
}

gl::Sampler page_sampler(gl::Context& context, unsigned filter) {
  return {context,
          {.min_filter = filter, .mag_filter = filter, .wrap_s = GL_CLAMP_TO_EDGE, .wrap_t = GL_CLAMP_TO_EDGE}};
}

}  // namespace crowdbench::renderers
