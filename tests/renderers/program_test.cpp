#include "renderers/gl/program.h"

#include <gtest/gtest.h>

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
  else
    return false;
  return true;
}

TEST(Shader, IncludesArePastedWithTheirLines) {
  const ShaderText out = assemble_shader("a.frag", {{"X", "3"}, {"Y", ""}}, read);
  EXPECT_EQ(out.files, (std::vector<std::string>{"a.frag", "b.glsl", "c.glsl"}));
  EXPECT_EQ(out.text,
            "#version 450 core\n#define X 3\n#define Y \n#line 2\n"
            "#line 100001\n// b, line 1\n#line 200001\nfloat c;\n#line 100003\nfloat b;\n#line 3\nvoid main() {}\n");
}

TEST(Shader, AFileIsPastedOnce) {
  const ShaderText out = assemble_shader("twice.frag", {}, read);
  EXPECT_EQ(out.text.find("float c;"), out.text.rfind("float c;"));
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
}

TEST(Shader, LogsOfSeveralDriversAreMappedBack) {
  const std::vector<std::string> files = {"a.frag", "b.glsl"};
  EXPECT_EQ(map_log("0:100012(3): error: no", files), "b.glsl:12: error: no");
  EXPECT_EQ(map_log("0(7) : error C1008: no", files), "a.frag:7 : error C1008: no");
  EXPECT_EQ(map_log("ERROR: 0:100004: 'x' : undeclared", files), "ERROR: b.glsl:4: 'x' : undeclared");
  EXPECT_EQ(map_log("0:1(1): error: a\n0:100002(3): error: b\n", files), "a.frag:1: error: a\nb.glsl:2: error: b\n");
  EXPECT_EQ(map_log("0:900001(1): error", files), "0:900001: error") << "a number that names no file stays";
  EXPECT_EQ(map_log("nothing of the kind", files), "nothing of the kind");
}

class ProgramGl : public renderers::testing::GlTest {};

// Points $CROWDBENCH_SHADER_DIR at a folder of the test's own.
class ShaderFolder {
 public:
  ShaderFolder() { setenv("CROWDBENCH_SHADER_DIR", folder_.path().c_str(), 1); }
  ~ShaderFolder() { unsetenv("CROWDBENCH_SHADER_DIR"); }
  void write(const std::string& path, std::string_view text) const { write_file(folder_ / path, text); }

 private:
  support::ScratchFolder folder_;
};

TEST_F(ProgramGl, TheFolderWinsAndACompileErrorNamesFileAndLine) {
  const ShaderFolder folder;
  folder.write("x/part.glsl", "// one\nfloat half_of(float x) { return x * undeclared_name; }\n");
  folder.write("x/broken.frag",
               "#version 450 core\n#include \"x/part.glsl\"\nout vec4 c;\nvoid main() { c = vec4(half_of(1.0)); }\n");
  folder.write("x/fine.frag", "#version 450 core\nout vec4 c;\nvoid main() { c = vec4(LEVEL); }\n");
  gl::Context& context = renderers::testing::context();
  try {
    const Program program(context, {"renderers/shaders/screen.vert", "x/broken.frag"});
    ADD_FAILURE() << "compiled";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("x/part.glsl:2"), std::string::npos) << e.what();
  }
  context.take_debug_messages();  // the driver reports the failed compilation there too
  const Program fine(context, {"renderers/shaders/screen.vert", "x/fine.frag"}, {{"LEVEL", "0.5"}});
  EXPECT_NE(fine.name(), 0U);
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
