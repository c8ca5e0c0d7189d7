// What every frame is drawn with and read back by, whatever its target stores depths as.
#pragma once
#include <epoxy/gl.h>

#include <algorithm>
#include <cstddef>

#include "core/image.h"
#include "renderers/gl/objects.h"
#include "scene/frame/frame.h"

namespace crowdbench::renderers {

// Sets OpenGL's state for opaque agents and clears what is bound: the background, nobody, the farthest depth. ids:
// whether colour 1 holds them. reversed: near is 1 and far 0.
void begin_frame(const scene::Frame& frame, bool ids, bool reversed);

// A texture's first level, row 0 on top.
template <typename T>
Image<T> read_upright(const gl::Texture& texture, int channels, GLenum format, GLenum type) {
  Image<T> image(texture.width(), texture.height(), channels);
  texture.read(0, format, type, image.data.data(), image.data.size() * sizeof(T));
  const size_t row = static_cast<size_t>(image.width) * static_cast<size_t>(image.channels);
  for (int y = 0; y < image.height / 2; ++y)
    std::swap_ranges(image.at(0, y), image.at(0, y) + row, image.at(0, image.height - 1 - y));
  return image;
}

}  // namespace crowdbench::renderers
