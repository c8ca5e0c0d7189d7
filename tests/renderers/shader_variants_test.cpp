// Every text that is given to a driver also passes the reference compiler, glslangValidator: Mesa takes what strict
// drivers do not.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "core/files.h"
#include "gl_test_support.h"
#include "renderers/gl/counters.h"
#include "renderers/gl/embedded.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/cache_folder.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using testing::add_agent;
using testing::cast_of;
using testing::context;

// What a character may have that its shaders differ by.
struct Dress {
  bool colours = false, texture = false, two_sides = false;
  bool glow = false, glow_texture = false, glow_uvs = false;
};

scene::Cast dressed(const Dress& dress) {
  scene::Character character = scene::make_mannequin({.triangles = 500});
  scene::Mesh& mesh = character.mesh;
  const size_t vertices = mesh.positions.size();
  mesh.uvs.assign(vertices, glm::vec2(0.5F));
  if (dress.colours) mesh.colours.assign(vertices, glm::vec4(1.0F));
  if (dress.glow_uvs) mesh.emissive_uvs.assign(vertices, glm::vec2(0.25F));
  scene::Texture texture;
  texture.image = Image8(4, 4, 4);
  character.images = {texture};
  for (scene::Material& material : character.materials) {
    material.base_colour_image = dress.texture ? 0 : -1;
    material.double_sided = dress.two_sides;
    material.emissive = glm::vec3(dress.glow ? 0.5F : 0.0F);
    material.emissive_image = dress.glow_texture ? 0 : -1;
  }
  return cast_of(std::move(character), 10.0);
}

// Agents near and far, so that every tier, level and switch is drawn.
scene::Frame frame_of(const scene::Cast& cast, bool ground) {
  scene::Frame frame = testing::frame_of_one(3.0, 1.0, 64, 64);
  frame.ground = ground;
  for (int i = 0; i < 4; ++i)
    add_agent(frame, cast, {0.3 * i, 0, -std::array{0, 4, 15, 60}[static_cast<size_t>(i)]},
              static_cast<uint32_t>(i + 1));
  return frame;
}

constexpr Pass kIds{.ids = true};
const std::vector<Pass> kEveryPass = {{}, kIds, {.touched = true}, {.dithered = true}, {.ids = true, .dithered = true}};

void draw(const scene::Cast& cast, const std::string& spec, const std::vector<Pass>& passes) {
  SCOPED_TRACE(spec);
  const auto representation = testing::make(cast, spec, {.use_cache = true});
  Renderer renderer(context(), cast);
  std::vector<Pass> all = passes;
  if (representation->shows_texels()) all.push_back({.linear = true, .texels = true});
  for (const Pass& pass : all) {
    const Target target(context(), 64, 64, pass);
    renderer.draw(frame_of(cast, !pass.touched && !pass.dithered), *representation, target);
    renderer.finish();
  }
}

void draw_everything() {
  (void)gl::test_gpu_timer(context());
  for (const Dress& dress : std::vector<Dress>{{},
                                               {.colours = true, .texture = true, .two_sides = true},
                                               {.glow = true},
                                               {.texture = true, .glow = true, .glow_texture = true},
                                               {.colours = true,
                                               .texture = true,
                                               .two_sides = true,
                                               .glow = true,
                                               .glow_texture = true,
                                               .glow_uvs = true}}) {
    const scene::Cast cast = dressed(dress);
    draw(cast, "mesh", kEveryPass);
    draw(cast, "mesh:floor=1", {kIds});
    draw(cast, "rigid:poses=2", {kIds});
    draw(cast, "mesh:passes=2", {kIds});
    draw(cast, "preskinned", {kIds});
    draw(cast, "pseudo", {kIds});
    draw(cast, "posecache", {kIds});
    draw(cast, "dynamic", kEveryPass);
    draw(cast, "surfel:points=64", kEveryPass);
    draw(cast, "surfel:points=64,floor=1", {kIds});
  }
  const scene::Cast plain = dressed({.texture = true});
  const scene::Cast glowing = dressed({.glow = true});
  const std::string flat = "flat:views=sphere-4x1,frames=2,texels=32";
  const std::string polypostor = "polypostor:views=sphere-4x1,frames=2,texels=32";
  const std::string relief = "relief:map=32,capture=bind";
  draw(glowing, flat, kEveryPass);
  draw(glowing, flat + ",frames_between=move_blend", kEveryPass);
  draw(glowing, polypostor, kEveryPass);
  draw(glowing, "layered:views=sphere-4x1,frames=2,texels=32", kEveryPass);
  draw(glowing, "perjoint:views=cube-2,texels=32", kEveryPass);
  draw(glowing, "perjoint:views=cube-2,texels=32,depth=plane,floor=1", {kIds});
  draw(glowing, relief, kEveryPass);
  draw(glowing, relief + ",projection=cube", kEveryPass);
  for (const char* options : {"",
                              ",compress=bc",
                              ",depth=nailboard",
                              ",blend=3",
                              ",compress=bc,depth=nailboard",
                              ",compress=bc,blend=3",
                              ",depth=nailboard,blend=3",
                              ",compress=bc,depth=nailboard,blend=3",
                              ",shade=list",
                              ",quad=square",
                              ",floor=1",
                              ",floor=1,compress=bc",
                              ",floor=1,depth=nailboard",
                              ",floor=1,blend=3",
                              ",parallax=2",
                              ",parallax=2,blend=3",
                              ",parallax=2,compress=bc,depth=nailboard",
                              ",parallax=2,depth=nailboard,blend=3",
                              ",parallax=2,floor=1",
                              ",frames_between=blend",
                              ",frames_between=move",
                              ",frames_between=move_blend",
                              ",frames_between=move_blend,floor=1",
                              ",frames_between=move,parallax=2",
                              ",frames_between=move_blend,parallax=2,depth=nailboard",
                              ",frames_between=move,compress=bc",
                              ",frames_between=move_blend,compress=bc,depth=nailboard"})
    draw(plain, flat + options, {kIds});
  for (const char* options : {"", ",floor=1", ",debug=wire", ",debug=lines", ",debug=parts", ",debug=stretch"})
    draw(plain, polypostor + options, {kIds});
  draw(plain, polypostor + ",debug=lines", {{.dithered = true}});
  for (const char* search : {",search=adaptive", ",search=linear", ",search=cone"}) {
    for (const char* options : {"", ",floor=1", ",debug=steps"}) draw(plain, relief + search + options, {kIds});
    draw(plain, relief + search + ",proxy=box", {kIds});
  }
  for (const char* options : {",debug=boxes", ",debug=hit-face", ",debug=misses", ",depth=8"})
    draw(plain, relief + options, {kIds});
  for (const char* options : {"", ",floor=1", ",debug=steps", ",debug=hit-face", ",proxy=box"})
    draw(plain, relief + ",projection=cube" + options, {kIds});
  draw(testing::walker(), "hybrid(mesh," + flat + ",distance=5)", {kIds});
  // Few parts: their ids take four bits.
  draw(cast_of(testing::two_bones()), flat + ",compress=bc", {kIds});
}

// The validator's status, and what it says.
std::pair<int, std::string> validate(const fs::path& folder) {
  FILE* pipe = popen(("cd '" + folder.string() + "' && glslangValidator * 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, ""};
  std::string said;
  std::array<char, 4096> buffer{};
  while (const size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) said.append(buffer.data(), n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, said};
}

class ShaderVariantsGl : public testing::GlTest {};

TEST_F(ShaderVariantsGl, EveryOnePassesTheValidator) {
  if (std::system("command -v glslangValidator >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "glslangValidator is not installed (glslang-tools)";
  const support::CacheFolder bakes;  // one serves all options that bakes do not depend on
  const support::ScratchFolder folder;
  setenv("CROWDBENCH_DUMP_SHADERS", folder.path().c_str(), 1);
  draw_everything();
  unsetenv("CROWDBENCH_DUMP_SHADERS");

  std::set<std::string> stages;  // that were compiled, "relief.frag"
  size_t texts = 0;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    const std::string name = entry.path().stem().string();
    stages.insert(name.substr(0, name.rfind('-')) + entry.path().extension().string());
    ++texts;
  }
  for (const gl::EmbeddedShader& shader : gl::embedded_shaders()) {
    const fs::path path(shader.path);
    if (path.extension() == ".glsl" || path.extension() == ".h") continue;
    EXPECT_TRUE(stages.contains(path.filename().string())) << path << " is compiled by nothing that is drawn here";
  }
  EXPECT_GE(texts, 61U);
  const auto [status, said] = validate(folder.path());
  EXPECT_EQ(status, 0) << said;
  std::printf("%zu shader texts of %zu stages given to glslangValidator\n", texts, stages.size());

  // It does refuse what is wrong.
  const support::ScratchFolder wrong;
  write_file(wrong / "wrong.frag", "#version 450 core\nout vec4 c;\nvoid main() { c = vec4(undeclared); }\n");
  EXPECT_NE(validate(wrong.path()).first, 0);
}

}  // namespace
}  // namespace crowdbench::renderers
