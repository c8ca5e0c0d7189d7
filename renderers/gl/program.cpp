#include "renderers/gl/program.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdlib>
#include <regex>
#include <utility>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "renderers/gl/embedded.h"

namespace crowdbench::gl {
namespace {

// The folder that takes the embedded shaders' place; empty: none.
std::filesystem::path shader_folder() {
  const char* folder = std::getenv("CROWDBENCH_SHADER_DIR");
  if (folder == nullptr || *folder == '\0') return {};
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored))
    throw Error("CROWDBENCH_SHADER_DIR", fmt::format("'{}' is not a folder", printable(folder)),
                "name the top of a checkout of crowdbench, or unset it");
  return folder;
}

bool read_shader_file(std::string_view path, std::string& text) {
  if (const std::filesystem::path folder = shader_folder(); !folder.empty()) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(folder / path, ignored)) return false;
    text = read_text(folder / path);
    return true;
  }
  for (const EmbeddedShader& shader : embedded_shaders()) {
    if (shader.path != path) continue;
    text = shader.text;
    return true;
  }
  return false;
}

// What follows "#include": the path between double quotes.
std::string included_path(std::string_view line, const std::string& where) {
  const size_t first = line.find('"');
  const size_t last = line.rfind('"');
  if (first == std::string_view::npos || last <= first) throw Error(where, "#include needs a path in double quotes");
  return std::string(line.substr(first + 1, last - first - 1));
}

// "include" of "  # include "x"", "" of a line that is not a directive.
std::string_view directive_of(std::string_view line) {
  constexpr std::string_view kBlank = " \t";
  size_t at = line.find_first_not_of(kBlank);
  if (at == std::string_view::npos || line[at] != '#') return {};
  at = line.find_first_not_of(kBlank, at + 1);
  if (at == std::string_view::npos) return {};
  return line.substr(at, std::min(line.find_first_not_of("abcdefghijklmnopqrstuvwxyz", at), line.size()) - at);
}

// A file is pasted wherever it is included, until it has been pasted outside of every #if: whether the text inside of
// one counts is for the driver to say, so what is pasted there is wrapped in a guard, and stands again where it is next
// asked for. No #line directives: one inside of what is skipped would be skipped with it, and all that follows be
// misnumbered.
struct Assembler {
  const Defines& defines;
  ReadShader read;
  std::string folder;  // that the files are read from, for errors; empty: they are in the binary
  ShaderText out;
  std::vector<std::string> open;     // the chain of files being pasted
  std::vector<bool> certain;         // by file: its text stands outside of every #if
  std::vector<size_t> conditionals;  // lines of the #if's that are open in the current file
  size_t guards = 0;                 // #if's around the current file

  void line(std::string_view text, size_t file, size_t number) {
    out.text.append(text).append("\n");
    out.lines.push_back({static_cast<uint32_t>(file), static_cast<uint32_t>(number)});
  }

  Error missing(const std::string& path, const std::string& from) const {
    if (folder.empty()) return {from, fmt::format("there is no shader file '{}'", printable(path))};
    return {
        from,
        fmt::format("there is no '{}' in '{}', which CROWDBENCH_SHADER_DIR names", printable(path), printable(folder)),
        "name the top of a whole checkout of crowdbench, or unset it"};
  }

  void include(const std::string& path, size_t from, size_t number) {
    const std::string where = fmt::format("{}:{}", out.files[from], number);
    if (std::find(open.begin(), open.end(), path) != open.end())
      throw Error(where, fmt::format("'{}' includes itself", path));
    const auto known = std::find(out.files.begin(), out.files.end(), path);
    const auto file = static_cast<size_t>(known - out.files.begin());
    if (known != out.files.end() && certain[file]) return;
    const bool always = guards + conditionals.size() == 0;
    if (always && known == out.files.end()) {
      paste(path, where);
      return;
    }
    line(fmt::format("#ifndef CB_PASTED_{}", file), from, number);
    line(fmt::format("#define CB_PASTED_{}", file), from, number);
    std::vector<size_t> outside = std::exchange(conditionals, {});
    guards += outside.size() + 1;
    paste(path, where);
    guards -= outside.size() + 1;
    conditionals = std::move(outside);
    line("#endif", from, number);
    certain[file] = always;
  }

  void paste(const std::string& path, const std::string& from) {
    std::string text;
    if (!read(path, text)) throw missing(path, from);
    const auto file = static_cast<size_t>(std::find(out.files.begin(), out.files.end(), path) - out.files.begin());
    if (file == out.files.size()) {
      out.files.push_back(path);
      certain.push_back(guards == 0);
    }
    open.push_back(path);
    size_t number = 0;
    size_t begin = 0;
    while (begin < text.size()) {
      const size_t end = std::min(text.find('\n', begin), text.size());
      const std::string_view content = std::string_view(text).substr(begin, end - begin);
      begin = end + 1;
      ++number;
      const auto where = [&](size_t at) { return fmt::format("{}:{}", path, at); };
      const std::string_view directive = directive_of(content);
      if (open.size() == 1 && number == 1) {
        if (directive != "version") throw Error(where(1), "a shader begins with #version");
        line(content, file, 1);
        for (const auto& [name, value] : defines) line(fmt::format("#define {} {}", name, value), file, 1);
        continue;
      }
      if (directive == "include") {
        include(included_path(content, where(number)), file, number);
        continue;
      }
      if (directive == "if" || directive == "ifdef" || directive == "ifndef") conditionals.push_back(number);
      if (directive == "endif") {
        if (conditionals.empty()) throw Error(where(number), "#endif without an #if before it");
        conditionals.pop_back();
      }
      line(content, file, number);
    }
    if (!conditionals.empty()) throw Error(fmt::format("{}:{}", path, conditionals.back()), "#if without an #endif");
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

// $CROWDBENCH_DUMP_SHADERS: what is given to the driver, one file a text, "relief-0123456789abcdef.frag".
void dump(std::string_view path, const std::string& text) {
  const char* folder = std::getenv("CROWDBENCH_DUMP_SHADERS");
  if (folder == nullptr || *folder == '\0') return;
  const std::filesystem::path file(path);
  const uint64_t hash = xxh3_64({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  write_file(std::filesystem::path(folder) /
                 fmt::format("{}-{:016x}{}", file.stem().string(), hash, file.extension().string()),
             text);
}

// A shader object for the time of linking.
class Shader : public Object {
 public:
  Shader(Context& context, std::string_view path, const Defines& defines)
      : Object(context, [](unsigned name) { glDeleteShader(name); }) {
    const ShaderText source = load_shader(path, defines);
    dump(path, source.text);
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
    throw Error(std::string(path), "the shader does not compile: " + printable(first_error(map_log(log, source)), 400));
  }
};

}  // namespace

ShaderText assemble_shader(std::string_view path, const Defines& defines, ReadShader read, const std::string& folder) {
  Assembler assembler{defines, read, folder, {}, {}, {}, {}, 0};
  assembler.paste(std::string(path), std::string(path));
  return std::move(assembler.out);
}

ShaderText load_shader(std::string_view path, const Defines& defines) {
  return assemble_shader(path, defines, read_shader_file, shader_folder().string());
}

std::string map_log(const std::string& log, const ShaderText& source) {
  // Mesa: "0:12(3): error: ..."; NVIDIA: "0(12) : error C1008: ..."; others: "ERROR: 0:12: ...".
  static const std::regex place(R"((^|\n|ERROR: |WARNING: )(\d+)(?::(\d+)(?:\(\d+\))?|\((\d+)\)))");
  std::string out;
  auto at = log.cbegin();
  for (std::sregex_iterator match(log.begin(), log.end(), place), end; match != end; ++match) {
    const std::smatch& m = *match;
    const size_t number = std::strtoul((m[3].matched ? m[3].str() : m[4].str()).c_str(), nullptr, 10);
    out.append(at, m[0].first);
    out += m[1].str();
    if (number >= 1 && number <= source.lines.size()) {
      const auto& [file, line] = source.lines[number - 1];
      out += fmt::format("{}:{}", source.files[file], line);
    } else {
      out += fmt::format("{}:{}", m[2].str(), number);
    }
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
