// Pages of tiles on the GPU.
#pragma once
#include <cstdint>
#include <span>

#include "renderers/gl/objects.h"

namespace crowdbench::renderers {

// An array texture of one level. stored: a sized internal format; format: of the bytes given, one unsigned byte a
// channel (of compressed blocks: anything). texels: `layers` layers, tightly packed; rows must be multiples of four
// bytes.
gl::Texture upload_layers(gl::Context& context, unsigned stored, unsigned format, int width, int height, int layers,
                          std::span<const uint8_t> texels);

// Reads a page without mip levels and without wrapping round. filter: GL_LINEAR or GL_NEAREST.
gl::Sampler page_sampler(gl::Context& context, unsigned filter);

}  // namespace crowdbench::renderers
