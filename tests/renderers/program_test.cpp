#include "renderers/gl/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "core/error.h"
#include "core/files.h"
#include "gl_test_support.h"
#include "renderers/gl/embedded.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::gl {
namespace {

bool read(std::string_view path, std::string& text) {
  if (path == "a.frag")
    text = "#version 450 core\n#include \"b.glsl\"\nvoid main() {}\n";
  else if (path == "b.glsl")
    text = "// b, line 1\n#include \"c.glsl\"\nfloat b;\n";
  else if (path == "c.glsl")
    text = "float c;\n";
  else if (path == "twice.frag")
    text = "#version 450 core\n#include \"c.glsl\"\n#include \"c.glsl\"\nvoid main() {}\n";
  else if (path == "loop.frag")
    text = "#version 450 core\n#include \"loop.glsl\"\n";
  else if (path == "loop.glsl")
    text = "\n#include \"loop.glsl\"\n";
  else if (path == "missing.frag")
    text = "#version 450 core\n\n#include \"nowhere.glsl\"\n";
  else if (path == "unquoted.frag")
    text = "#version 450 core\n#include c.glsl\n";
  else if (path == "late.frag")
    text = "// hello\n#version 450 core\n";
  else if (path == "skipped.frag")  // what is skipped includes files that include others
    text =
        "#version 450 core\n"
        "#ifdef NOT_GIVEN\n"
        "#include \"b.glsl\"\n"
        "float skipped = undeclared;\n"
        "#if 1\n"
        "#include \"guarded.shared.h\"\n"
        "#endif\n"
        "#elif defined(GIVEN)\n"
        "  #  include \"c.glsl\"\n"
        "#else\n"
        "#include \"nested.glsl\"\n"
        "#endif\n"
        "#include \"b.glsl\"\n"
        "#include \"guarded.shared.h\"\n"
        "out vec4 colour;\n"
        "void main() { colour = vec4(vec3(b + c + GUARDED), WHERE); }\n";
  else if (path == "nested.glsl")
    text = "#ifdef NOT_GIVEN\n#include \"c.glsl\"\n#endif\n\nfloat d = IN_NESTED;\n";
  else if (path == "guarded.shared.h")
    text = "#ifndef GUARD\n#define GUARD\n#define GUARDED 1.0\n#endif\n";
  else if (path == "open.frag")
    text = "#version 450 core\n#include \"open.glsl\"\n";
  else if (path == "open.glsl")
    text = "\n#if 1\n#ifdef X\n#endif\n";
  else if (path == "closed.frag")
    text = "#version 450 core\n#if 1\n#include \"closed.glsl\"\n#endif\n";
  else if (path == "closed.glsl")
    text = "float e;\n# endif\n";
  else
    return false;
  return true;
}

// Where each line came from, "file:line" by line.
std::vector<std::string> origins(const ShaderText& source) {
  std::vector<std::string> out;
  for (const auto& [file, number] : source.lines) out.push_back(source.files[file] + ":" + std::to_string(number));
  return out;
}

TEST(Shader, IncludesArePastedAndEveryLineKnowsItsPlace) {
  const ShaderText out = assemble_shader("a.frag", {{"X", "3"}, {"Y", ""}}, read);
  EXPECT_EQ(out.files, (std::vector<std::string>{"a.frag", "b.glsl", "c.glsl"}));
  EXPECT_EQ(out.text, "#version 450 core\n#define X 3\n#define Y \n// b, line 1\nfloat c;\nfloat b;\nvoid main() {}\n");
  EXPECT_EQ(origins(out), (std::vector<std::string>{"a.frag:1", "a.frag:1", "a.frag:1", "b.glsl:1", "c.glsl:1",
                                                    "b.glsl:3", "a.frag:3"}));
}

TEST(Shader, AFileIsPastedOnce) {
  const ShaderText out = assemble_shader("twice.frag", {}, read);
  EXPECT_EQ(out.text.find("float c;"), out.text.rfind("float c;"));
}

// What an #if may skip is pasted again where it is asked for again, and guarded, so that the driver sees it once.
TEST(Shader, AFileIncludedWhereItMayBeSkippedIsThereWhereItIsNot) {
  const ShaderText out = assemble_shader("skipped.frag", {}, read);
  EXPECT_EQ(out.files,
            (std::vector<std::string>{"skipped.frag", "b.glsl", "c.glsl", "guarded.shared.h", "nested.glsl"}));
  const auto count = [&](const std::string& what) {
    size_t n = 0;
    for (size_t at = out.text.find(what); at != std::string::npos; at = out.text.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("float b;"), 2U);
  EXPECT_EQ(count("#ifndef CB_PASTED_1\n#define CB_PASTED_1\n// b, line 1\n"), 2U);
  EXPECT_EQ(count("#include"), 0U);
  EXPECT_EQ(count("#line"), 0U);
  EXPECT_EQ(static_cast<size_t>(std::count(out.text.begin(), out.text.end(), '\n')), out.lines.size());
}

TEST(Shader, FaultsNameFileAndLine) {
  const auto message = [](const char* path) {
    try {
      (void)assemble_shader(path, {}, read);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(message("nowhere.frag").find("nowhere.frag"), std::string::npos);
  EXPECT_NE(message("missing.frag").find("missing.frag:3"), std::string::npos) << message("missing.frag");
  EXPECT_NE(message("loop.frag").find("loop.glsl:2"), std::string::npos) << message("loop.frag");
  EXPECT_NE(message("unquoted.frag").find("unquoted.frag:2"), std::string::npos);
  EXPECT_NE(message("late.frag").find("late.frag:1"), std::string::npos);
  EXPECT_EQ(message("open.frag"), "open.glsl:2: #if without an #endif");
  EXPECT_EQ(message("closed.frag"), "closed.glsl:2: #endif without an #if before it");
}

TEST(Shader, LogsOfSeveralDriversAreMappedBack) {
  const ShaderText source{"", {"a.frag", "b.glsl"}, {{0, 1}, {0, 1}, {1, 12}, {0, 3}}};
  EXPECT_EQ(map_log("0:3(3): error: no", source), "b.glsl:12: error: no");
  EXPECT_EQ(map_log("0(4) : error C1008: no", source), "a.frag:3 : error C1008: no");
  EXPECT_EQ(map_log("ERROR: 0:3: 'x' : undeclared", source), "ERROR: b.glsl:12: 'x' : undeclared");
  EXPECT_EQ(map_log("0:1(1): error: a\n0:4(3): error: b\n", source), "a.frag:1: error: a\na.frag:3: error: b\n");
  EXPECT_EQ(map_log("0:5(1): error", source), "0:5: error") << "a line that is not there stays";
  EXPECT_EQ(map_log("0:0(1): error", source), "0:0: error");
  EXPECT_EQ(map_log("nothing of the kind", source), "nothing of the kind");
}

class ProgramGl : public renderers::testing::GlTest {};

// Points a variable at a folder of the test's own.
class ShaderFolder {
 public:
  explicit ShaderFolder(const char* variable = "CROWDBENCH_SHADER_DIR") : variable_(variable) {
    setenv(variable_, folder_.path().c_str(), 1);
  }
  ~ShaderFolder() { unsetenv(variable_); }
  void write(const std::string& path, std::string_view text) const {
    std::filesystem::create_directories((folder_ / path).parent_path());
    write_file(folder_ / path, text);
  }
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  const char* variable_;
  support::ScratchFolder folder_;
};

// The one line that making a program of this fragment shader ends with.
std::string fault_of(std::string_view fragment, const Defines& defines = {}) {
  gl::Context& context = renderers::testing::context();
  std::string message = "no error";
  try {
    const Program program(context, {"screen.vert", fragment}, defines);
  } catch (const Error& e) {
    message = e.what();
  }
  context.take_debug_messages();  // the driver reports the failed compilation there too
  return message;
}

constexpr const char* kScreen = "#version 450 core\nvoid main() { gl_Position = vec4(0.0); }\n";

TEST_F(ProgramGl, TheFolderTakesTheEmbeddedShadersPlace) {
  const ShaderFolder folder;
  folder.write("screen.vert", kScreen);
  folder.write("x/fine.frag", "#version 450 core\nout vec4 c;\nvoid main() { c = vec4(LEVEL); }\n");
  const Program fine(renderers::testing::context(), {"screen.vert", "x/fine.frag"}, {{"LEVEL", "0.5"}});
  EXPECT_NE(fine.name(), 0U);
  EXPECT_EQ(fault_of("renderers/shaders/ground.frag"),
            "renderers/shaders/ground.frag: there is no 'renderers/shaders/ground.frag' in '" + folder.path().string() +
                "', which CROWDBENCH_SHADER_DIR names; name the top of a whole checkout of crowdbench, or unset it");
  folder.write("x/asks.frag", "#version 450 core\n#include \"x/nowhere.glsl\"\n");
  EXPECT_EQ(fault_of("x/asks.frag").find("x/asks.frag:2: there is no 'x/nowhere.glsl' in '"), 0U)
      << fault_of("x/asks.frag");
  setenv("CROWDBENCH_SHADER_DIR", (folder.path() / "nowhere").c_str(), 1);
  EXPECT_EQ(fault_of("x/fine.frag"), "CROWDBENCH_SHADER_DIR: '" + (folder.path() / "nowhere").string() +
                                         "' is not a folder; name the top of a checkout of crowdbench, or unset it");
}

TEST_F(ProgramGl, ACompileErrorNamesFileAndLine) {
  const ShaderFolder folder;
  folder.write("screen.vert", kScreen);
  folder.write("x/part.glsl", "// one\nfloat half_of(float x) { return x * undeclared_name; }\n");
  folder.write("x/broken.frag",
               "#version 450 core\n#include \"x/part.glsl\"\nout vec4 c;\nvoid main() { c = vec4(half_of(1.0)); }\n");
  EXPECT_NE(fault_of("x/broken.frag").find(": x/part.glsl:2: error"), std::string::npos) << fault_of("x/broken.frag");
}

// Whatever is skipped before it, with all that it includes, an error has its own file and line.
TEST_F(ProgramGl, ACompileErrorAfterSkippedIncludesNamesFileAndLine) {
  const ShaderFolder folder;
  folder.write("screen.vert", kScreen);
  for (const char* name : {"skipped.frag", "b.glsl", "c.glsl", "nested.glsl", "guarded.shared.h"}) {
    std::string text;
    ASSERT_TRUE(read(name, text));
    folder.write(name, text);
  }
  const auto place = [](const Defines& defines) {
    const std::string message = fault_of("skipped.frag", defines);
    const size_t begin = message.find("not compile: ");
    if (begin == std::string::npos) return message;
    return message.substr(begin + 13, message.find(": error", begin) - begin - 13);
  };
  EXPECT_EQ(place({{"GIVEN", ""}}), "skipped.frag:16");  // WHERE, past two skipped groups
  EXPECT_EQ(place({}), "nested.glsl:5");
  EXPECT_EQ(place({{"IN_NESTED", "1.0"}}), "skipped.frag:16");
  EXPECT_EQ(place({{"NOT_GIVEN", ""}}), "skipped.frag:4");
  EXPECT_EQ(place({{"GIVEN", ""}, {"WHERE", "1.0"}}), "no error");
  EXPECT_EQ(place({{"IN_NESTED", "1.0"}, {"WHERE", "1.0"}}), "no error");
}

TEST_F(ProgramGl, EveryEmbeddedShaderFileAssembles) {
  size_t stages = 0;
  for (const EmbeddedShader& shader : embedded_shaders()) {
    const bool stage =
        shader.path.ends_with(".vert") || shader.path.ends_with(".frag") || shader.path.ends_with(".comp");
    if (!stage) continue;
    EXPECT_NO_THROW((void)load_shader(shader.path)) << shader.path;
    ++stages;
  }
  EXPECT_GE(stages, 6U);
}

}  // namespace
}  // namespace crowdbench::gl
