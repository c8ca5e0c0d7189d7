#include "renderers/gl/program.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

#include "core/error.h"
#include "core/files.h"
#include "renderers/gl/embedded.h"

namespace crowdbench::gl {
namespace {

bool read_shader_file(std::string_view path, std::string& text) {
  if (const char* folder = std::getenv("CROWDBENCH_SHADER_DIR")) {
    const std::filesystem::path file = std::filesystem::path(folder) / path;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) {
      text = read_text(file);
      return true;
    }
  }
  for (const EmbeddedShader& shader : embedded_shaders()) {
    if (shader.path != path) continue;
    text = shader.text;
    return true;
  }
  return false;
}

// Line n of file f is given to the driver as line f * kLinesPerFile + n.
constexpr size_t kLinesPerFile = 100000;

struct Assembler {
  const Defines& defines;
  ReadShader read;
  ShaderText out;
  std::vector<std::string> open;  // the chain of files being pasted

  // Says which line the *next* one is. The file goes into the number, because Mesa forgets the source string's number
  // for errors within expressions.
  void mark(size_t line, size_t file) { out.text += fmt::format("#line {}\n", file * kLinesPerFile + line); }

  void paste(const std::string& path, const std::string& from) {
    if (std::find(open.begin(), open.end(), path) != open.end())
      throw Error(from, fmt::format("'{}' includes itself", path));
    if (std::find(out.files.begin(), out.files.end(), path) != out.files.end()) return;
    std::string text;
    if (!read(path, text)) throw Error(from, fmt::format("there is no shader file '{}'", printable(path)));
    const size_t file = out.files.size();
    out.files.push_back(path);
    open.push_back(path);
    if (file > 0) mark(1, file);
    size_t number = 0;
    size_t begin = 0;
    while (begin < text.size()) {
      const size_t end = std::min(text.find('\n', begin), text.size());
      const std::string line = text.substr(begin, end - begin);
      begin = end + 1;
      ++number;
      const std::string where = fmt::format("{}:{}", path, number);
      if (file == 0 && number == 1) {
        if (!line.starts_with("#version")) throw Error(where, "a shader begins with #version");
        out.text += line + "\n";
        for (const auto& [name, value] : defines) out.text += fmt::format("#define {} {}\n", name, value);
        mark(2, 0);
      } else if (line.starts_with("#include")) {
        const size_t first = line.find('"');
        const size_t last = line.rfind('"');
        if (first == std::string::npos || last <= first) throw Error(where, "#include wants a path in double quotes");
        paste(line.substr(first + 1, last - first - 1), where);
        mark(number + 1, file);
      } else {
        out.text += line + "\n";
      }
    }
    open.pop_back();
  }
};

GLenum stage_of(std::string_view path) {
  if (path.ends_with(".vert")) return GL_VERTEX_SHADER;
  if (path.ends_with(".frag")) return GL_FRAGMENT_SHADER;
  if (path.ends_with(".comp")) return GL_COMPUTE_SHADER;
  throw Error(std::string(path), "the extension names no shader stage", "use .vert, .frag or .comp");
}

// The first line of a log that speaks of an error, else its first line.
std::string first_error(const std::string& log) {
  std::string first;
  size_t begin = 0;
  while (begin < log.size()) {
    const size_t end = std::min(log.find('\n', begin), log.size());
    const std::string line = log.substr(begin, end - begin);
    begin = end + 1;
    if (line.empty()) continue;
    if (line.find("error") != std::string::npos) return line;
    if (first.empty()) first = line;
  }
  return first;
}

// A shader object for the time of linking.
class Shader : public Object {
 public:
  Shader(Context& context, std::string_view path, const Defines& defines)
      : Object(context, [](unsigned name) { glDeleteShader(name); }) {
    const ShaderText source = load_shader(path, defines);
    name_ = glCreateShader(stage_of(path));
    const char* text = source.text.c_str();
    glShaderSource(name_, 1, &text, nullptr);
    glCompileShader(name_);
    GLint fine = 0;
    glGetShaderiv(name_, GL_COMPILE_STATUS, &fine);
    if (fine) return;
    GLint length = 0;
    glGetShaderiv(name_, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
    glGetShaderInfoLog(name_, length, nullptr, log.data());
    log.resize(log.find('\0') == std::string::npos ? log.size() : log.find('\0'));
    throw Error(std::string(path),
                "the shader does not compile: " + printable(first_error(map_log(log, source.files)), 400));
  }
};

}  // namespace

ShaderText assemble_shader(std::string_view path, const Defines& defines, ReadShader read) {
  Assembler assembler{defines, read, {}, {}};
  assembler.paste(std::string(path), std::string(path));
  return std::move(assembler.out);
}

ShaderText load_shader(std::string_view path, const Defines& defines) {
  return assemble_shader(path, defines, read_shader_file);
}

std::string map_log(const std::string& log, const std::vector<std::string>& files) {
  // Mesa: "1:12(3): error: ..."; NVIDIA: "1(12) : error C1008: ..."; others: "ERROR: 1:12: ...".
  static const std::regex place(R"((^|\n|ERROR: |WARNING: )(\d+)(?::(\d+)(?:\(\d+\))?|\((\d+)\)))");
  std::string out;
  auto at = log.cbegin();
  for (std::sregex_iterator match(log.begin(), log.end(), place), end; match != end; ++match) {
    const std::smatch& m = *match;
    const size_t number = std::strtoul((m[3].matched ? m[3].str() : m[4].str()).c_str(), nullptr, 10);
    const size_t file = number / kLinesPerFile;
    const size_t line = number % kLinesPerFile;
    out.append(at, m[0].first);
    out += m[1].str();
    out += file < files.size() ? fmt::format("{}:{}", files[file], line) : fmt::format("{}:{}", m[2].str(), number);
    at = m[0].second;
  }
  out.append(at, log.cend());
  return out;
}

Program::Program(Context& context, std::initializer_list<std::string_view> files, const Defines& defines,
                 const std::vector<std::string>& feedback)
    : Object(context, [](unsigned name) { glDeleteProgram(name); }) {
  std::vector<Shader> shaders;
  for (const std::string_view file : files) shaders.emplace_back(context, file, defines);
  name_ = glCreateProgram();
  for (const Shader& shader : shaders) glAttachShader(name_, shader.name());
  if (!feedback.empty()) {
    std::vector<const char*> names;
    names.reserve(feedback.size());
    for (const std::string& name : feedback) names.push_back(name.c_str());
    glTransformFeedbackVaryings(name_, static_cast<GLsizei>(names.size()), names.data(), GL_INTERLEAVED_ATTRIBS);
  }
  glLinkProgram(name_);
  for (const Shader& shader : shaders) glDetachShader(name_, shader.name());
  GLint fine = 0;
  glGetProgramiv(name_, GL_LINK_STATUS, &fine);
  if (fine) return;
  GLint length = 0;
  glGetProgramiv(name_, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  glGetProgramInfoLog(name_, length, nullptr, log.data());
  log.resize(log.find('\0') == std::string::npos ? log.size() : log.find('\0'));
  throw Error(files.size() ? std::string(*files.begin()) : "program",
              "the program does not link: " + printable(first_error(log), 400));
}

void Program::use() const { glUseProgram(name_); }
void Program::set(int location, int value) const { glProgramUniform1i(name_, location, value); }
void Program::set(int location, unsigned value) const { glProgramUniform1ui(name_, location, value); }
void Program::set(int location, float value) const { glProgramUniform1f(name_, location, value); }

}  // namespace crowdbench::gl
