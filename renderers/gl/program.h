// Program: shaders from files, with #include and #define variants.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderers/gl/objects.h"

namespace crowdbench::gl {

// Name and value, written as #define lines after #version; the value may be empty.
using Defines = std::vector<std::pair<std::string, std::string>>;

// Shader text with its includes pasted in, and what a driver's line numbers mean.
struct ShaderText {
  std::string text;
  std::vector<std::string> files;  // a driver's line number N is line N % 100000 of files[N / 100000]
};

// Loads shader files by their path below the repository, "renderers/mesh/mesh.vert". They are compiled into the binary;
// a file of the same path below $CROWDBENCH_SHADER_DIR wins. `#include "renderers/shaders/x.glsl"` pastes a file once a
// shader. Throws Error naming file and line: unknown file, unknown or circular include, no #version first.
ShaderText load_shader(std::string_view path, const Defines& defines = {});
// The same with a reader of the caller's (tests); returns false for an unknown path.
using ReadShader = bool (*)(std::string_view path, std::string& text);
ShaderText assemble_shader(std::string_view path, const Defines& defines, ReadShader read);
// Rewrites "0:100012(3): error" and "0(100012) : error" of a driver's log to "renderers/mesh/mesh.vert:12: error".
std::string map_log(const std::string& log, const std::vector<std::string>& files);

class Program : public Object {
 public:
  Program() = default;
  // Stages by extension: .vert .frag .comp. feedback: names of outputs captured by transform feedback, interleaved.
  // Throws Error with the driver's first message at its file and line.
  Program(Context& context, std::initializer_list<std::string_view> files, const Defines& defines = {},
          const std::vector<std::string>& feedback = {});
  void use() const;
  // glProgramUniform at an explicit location (renderers/shaders/bindings.shared.h).
  void set(int location, int value) const;
  void set(int location, unsigned value) const;
  void set(int location, float value) const;
};

}  // namespace crowdbench::gl
