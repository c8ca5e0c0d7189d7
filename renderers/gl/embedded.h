#pragma once
#include <string_view>
#include <vector>

namespace crowdbench::gl {

// A shader file compiled into the binary: path below the repository ("renderers/mesh/mesh.vert") and its text.
struct EmbeddedShader {
  std::string_view path;
  std::string_view text;
};
const std::vector<EmbeddedShader>& embedded_shaders();

}  // namespace crowdbench::gl
