// Program: shaders from files, with #include and #define variants.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderers/gl/objects.h"

namespace crowdbench::gl {

// Name and value, written as #define lines after #version; the value may be empty.
using Defines = std::vector<std::pair<std::string, std::string>>;

// Shader text with its includes pasted in, and where each of its lines came from.
struct ShaderText {
  struct Line {
    uint32_t file;    // of `files`
    uint32_t number;  // from 1
    bool operator==(const Line&) const = default;
  };
  std::string text;
  std::vector<std::string> files;  // each once; the shader's own first
  std::vector<Line> lines;         // of each line of the text; one that was added (a #define) has that of its cause
};

// Loads shader files by their path below the repository, "renderers/mesh/mesh.vert". They are compiled into the binary;
// $CROWDBENCH_SHADER_DIR, the top of a checkout, takes the place of all of them. `#include "renderers/shaders/x.glsl"`
// pastes a file, once a shader, also inside of #if. Throws Error naming file and line: unknown file, unknown or
// circular include, no #version first, an #if without its #endif; and one naming CROWDBENCH_SHADER_DIR where that is
// not a folder.
ShaderText load_shader(std::string_view path, const Defines& defines = {});
// The same with a reader of the caller's (tests), which returns false for an unknown path. folder: where it looks, for
// errors; empty: in the binary.
using ReadShader = bool (*)(std::string_view path, std::string& text);
ShaderText assemble_shader(std::string_view path, const Defines& defines, ReadShader read,
                           const std::string& folder = {});
// Rewrites "0:112(3): error" and "0(112) : error" of a driver's log to "renderers/mesh/mesh.vert:12: error".
std::string map_log(const std::string& log, const ShaderText& source);

class Program : public Object {
 public:
  Program() = default;
  // Stages by extension: .vert .frag .comp. feedback: names of outputs captured by transform feedback, interleaved.
  // Throws Error with the driver's first message at its file and line. $CROWDBENCH_DUMP_SHADERS, a folder, gets every
  // text that is given to the driver, for other compilers to look at.
  Program(Context& context, std::initializer_list<std::string_view> files, const Defines& defines = {},
          const std::vector<std::string>& feedback = {});
  void use() const;
  // glProgramUniform at an explicit location (renderers/shaders/bindings.shared.h).
  void set(int location, int value) const;
  void set(int location, unsigned value) const;
  void set(int location, float value) const;
};

}  // namespace crowdbench::gl
