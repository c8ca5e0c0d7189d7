// FBX and COLLADA characters: the same figure as its glTF.
#include "scene/assimp/assimp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "assimp_walker.h"
#include "scene/cast/open_character.h"
#include "tests/support/driver.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::scene {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using support::ScratchFolder;
using namespace test;

class AssimpFormats : public testing::TestWithParam<AssimpFormat> {};
INSTANTIATE_TEST_SUITE_P(Both, AssimpFormats, testing::Values(AssimpFormat::fbx, AssimpFormat::collada),
                         [](const auto& test) { return test.param == AssimpFormat::fbx ? "Fbx" : "Collada"; });

// --- the figure of make_walker.mjs, in metres and with Y up ---

using Floats = std::vector<float>;

std::vector<float> about_x(double degrees) {
  const double half = degrees * 3.14159265358979323846 / 360;
  return {static_cast<float>(std::sin(half)), 0, 0, static_cast<float>(std::cos(half))};
}

// Turned by 30 degrees about x, then about the axis that points to the front.
std::vector<float> tilted(double degrees) {
  const double a = 15 * 3.14159265358979323846 / 180;
  const double b = degrees * 3.14159265358979323846 / 360;
  return {static_cast<float>(std::sin(a) * std::cos(b)), static_cast<float>(-std::sin(a) * std::sin(b)),
          static_cast<float>(std::cos(a) * std::sin(b)), static_cast<float>(std::cos(a) * std::cos(b))};
}

json channel(int sampler, int node, const char* path) {
  return {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}};
}

void add_clips(test::Builder& b) {
  Floats swing;
  for (const double degrees : {0, 20, 0, -20, 0})
    for (const float q : about_x(30 + degrees)) swing.push_back(q);
  Floats tilt = tilted(0);
  for (const float q : tilted(40)) tilt.push_back(q);
  const int walk = b.accessor<float>({0, 0.25F, 0.5F, 0.75F, 1}, "SCALAR");
  const int moved = b.accessor<float>({0, 0, 0, 0, 0.05F, 0.2F, 0, 0, 0.4F, 0, 0.05F, 0.6F, 0, 0, 0.8F}, "VEC3");
  const int swung = b.accessor<float>(swing, "VEC4");
  const int nod = b.accessor<float>({0, 0.5F}, "SCALAR");
  const int nodded = b.accessor<float>(tilt, "VEC4");
  b.doc["animations"] = {{{"name", "Walk"},
                          {"samplers", {{{"input", walk}, {"output", moved}}, {{"input", walk}, {"output", swung}}}},
                          {"channels", {channel(0, 1, "translation"), channel(1, 2, "rotation")}}},
                         {{"name", "Nod"},
                          {"samplers", {{{"input", nod}, {"output", nodded}}}},
                          {"channels", {channel(0, 2, "rotation")}}}};
}

Character walker_in_gltf() {
  test::Builder b;
  const int body =
      b.accessor<float>({-.2F, 0, 0, .2F, 0, 0, -.2F, .9F, 0, .2F, .9F, 0, -.2F, 1.8F, 0, .2F, 1.8F, 0}, "VEC3");
  const int front = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const int uv = b.accessor<float>({0, 1, 1, 1, 0, .5F, 1, .5F, 0, 0, 1, 0}, "VEC2");
  const int joints =
      b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const int weights =
      b.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, .5F, .5F, 0, 0, .5F, .5F, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const int quads = b.accessor<uint16_t>({0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4}, "SCALAR");
  const int hat = b.accessor<float>({0, 0, 0, .2F, 0, 0, .1F, .2F, 0}, "VEC3");
  const int hat_front = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const float c = std::cos(3.14159265F / 6);
  const float s = std::sin(3.14159265F / 6);
  const int binds = b.accessor<float>(
      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, 0, -.9F * c, .9F * s, 1},
      "MAT4");
  b.doc["materials"] = {{{"name", "cloth"}},
                        {{"name", "felt"}, {"pbrMetallicRoughness", {{"baseColorFactor", {.5, .25, .125, 1}}}}}};
  b.doc["meshes"] = {
      {{"primitives",
        {{{"attributes",
           {{"POSITION", body}, {"NORMAL", front}, {"TEXCOORD_0", uv}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
          {"indices", quads},
          {"material", 0}}}}},
      {{"primitives", {{{"attributes", {{"POSITION", hat}, {"NORMAL", hat_front}}}, {"material", 1}}}}}};
  b.doc["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}};
  b.doc["nodes"] = {{{"mesh", 0}, {"skin", 0}},
                    {{"name", "hips"}, {"children", {2}}},
                    {{"name", "chest"}, {"translation", {0, .9, 0}}, {"rotation", about_x(30)}, {"children", {3}}},
                    {{"name", "hat"}, {"mesh", 1}, {"translation", {0, .9, .1}}, {"scale", {-1, 1, 1}}}};
  b.doc["scenes"] = {{{"nodes", {0, 1}}}};
  add_clips(b);
  return test::load(b);
}

// Of each vertex of `reference` that of `c` that lies there in the bind pose.
std::vector<size_t> counterparts(const Character& reference, const Character& c) {
  const auto from = posed(reference, -1, 0);
  const auto to = posed(c, -1, 0);
  std::vector<size_t> out;
  for (const glm::dvec3& p : from)
    out.push_back(static_cast<size_t>(
        std::min_element(to.begin(), to.end(),
                         [&](const auto& a, const auto& b) { return glm::distance(a, p) < glm::distance(b, p); }) -
        to.begin()));
  return out;
}

void expect_same_clip(const Character& reference, const Character& c, int clip) {
  const std::vector<size_t> other = counterparts(reference, c);
  ASSERT_EQ(std::set<size_t>(other.begin(), other.end()).size(), reference.mesh.positions.size());
  const double seconds = reference.clips[static_cast<size_t>(clip)].duration();
  for (int step = -1; step <= 10; ++step) {
    const auto from = posed(reference, step < 0 ? -1 : clip, seconds * step / 10);
    const auto to = posed(c, step < 0 ? -1 : clip, seconds * step / 10);
    for (size_t v = 0; v < from.size(); ++v)
      EXPECT_LT(glm::distance(from[v], to[other[v]]), 1e-4 * 1.8) << "vertex " << v << ", step " << step;
  }
}

TEST_P(AssimpFormats, PosesAsTheSameFigureInGltf) {
  const Character reference = walker_in_gltf();
  const Character c = load_text(text_of(GetParam()), GetParam());
  ASSERT_EQ(c.mesh.positions.size(), reference.mesh.positions.size());
  expect_same_clip(reference, c, 0);
  EXPECT_EQ(c.clips[0].name, "Walk");
  EXPECT_NEAR(c.clips[0].duration(), 1.0, 1e-6);
  EXPECT_NEAR(c.placement.height, reference.placement.height, 1e-4);
  EXPECT_NEAR(c.motion[0].ground_speed, reference.motion[0].ground_speed, 1e-3);
  EXPECT_EQ(c.triangles(), reference.triangles());
  const std::vector<size_t> other = counterparts(reference, c);
  for (size_t v = 0; v < other.size(); ++v) {
    EXPECT_LT(glm::distance(c.mesh.uvs[other[v]], reference.mesh.uvs[v]), 1e-5F) << v;
    EXPECT_NEAR(c.mesh.weights[other[v]].x, reference.mesh.weights[v].x, 1e-5F) << v;
  }
}

TEST_P(AssimpFormats, WindingAndNormalsFollowMirroredNodes) {
  const Character reference = walker_in_gltf();
  const Character c = load_text(text_of(GetParam()), GetParam());
  ASSERT_EQ(c.mesh.primitives.size(), 2U);
  for (const Primitive& primitive : c.mesh.primitives) {
    EXPECT_EQ(primitive.mirrored, c.skeleton.joints[c.mesh.joints[primitive.first_vertex].x].rigid);
    const auto at = posed(c, -1, 0);
    const uint32_t* i = &c.mesh.indices[primitive.first_index];
    const glm::dvec3 normal = glm::cross(at[i[1]] - at[i[0]], at[i[2]] - at[i[0]]);
    EXPECT_GT(normal.z * (primitive.mirrored ? -1 : 1), 0);  // the card and the hat show their front
    EXPECT_FALSE(primitive.flat);
  }
}

// A part of the upper joint's place as an offset of its pivot, another as a pivot that it turns about and that is taken
// back: Assimp then has helper nodes, and animations that name them.
TEST(Assimp, FbxPivotsPoseExactly) {
  std::string text = changed(text_of(AssimpFormat::fbx), "\"Lcl Translation\", \"\", \"A\",0,0,90",
                             "\"Lcl Translation\", \"\", \"A\",0,0,80");
  const std::string turned = "P: \"PreRotation\", \"Vector3D\", \"\", \"A\",30,0,0\n";
  const std::string vector = "\"Vector3D\", \"\", \"A\",";
  const Character offset =
      load_text(changed(text, turned, turned + "P: \"RotationOffset\", " + vector + "0,0,10\n"), AssimpFormat::fbx);
  expect_same_clip(walker_in_gltf(), offset, 0);
  expect_same_clip(walker_in_gltf(), offset, 1);
  text = changed(text, turned,
                 turned + "P: \"RotationOffset\", " + vector + "0,0,-10\nP: \"RotationPivot\", " + vector +
                     "0,0,20\nP: \"ScalingOffset\", " + vector + "0,0,20\n");
  expect_same_clip(walker_in_gltf(), load_text(text, AssimpFormat::fbx), 0);
}

TEST(Assimp, FbxTakesAreClips) {
  const Character c = load_text(text_of(AssimpFormat::fbx), AssimpFormat::fbx);
  ASSERT_EQ(c.clips.size(), 2U);
  EXPECT_EQ(c.clips[1].name, "Nod");
  EXPECT_NEAR(c.clips[1].duration(), 0.5, 1e-6);
  EXPECT_EQ(c.placement.default_clip, 0);
  expect_same_clip(walker_in_gltf(), c, 1);
}

// walker.dae without its hat, as Blender 3.4 writes it: binary, the unit on its objects, a key a frame.
TEST(Assimp, BinaryFbxIsRead) {
  const Character c = open_character((kData / "walker_binary.fbx").string(), as_is());
  EXPECT_EQ(c.triangles(), 4U);
  EXPECT_NEAR(c.placement.height, 1.8, 1e-4);
  ASSERT_EQ(c.clips.size(), 1U);
  EXPECT_NEAR(c.motion[0].ground_speed, 0.8, 1e-3);
  const auto tallest = [](const Character& of, int clip, double time) {
    double y = 0;
    for (const glm::dvec3& p : posed(of, clip, time)) y = std::max(y, p.y);
    return y;
  };
  LoadOptions bare = as_is();
  bare.hide = {"hat"};
  const Character body = load_text(text_of(AssimpFormat::fbx), AssimpFormat::fbx, bare);
  const double start = c.clips[0].start;
  for (const double t : {0.0, 0.25, 0.75}) EXPECT_NEAR(tallest(c, 0, start + t), tallest(body, 0, t), 1e-3) << t;
}

TEST(Assimp, ColladaClipsAreSaidToPlayAtOnce) {
  const std::string text =
      changed(text_of(AssimpFormat::collada), "<library_visual_scenes>",
              "<library_animation_clips><animation_clip id=\"a\"><instance_animation url=\"#Walk\"/>"
              "</animation_clip></library_animation_clips><library_visual_scenes>");
  EXPECT_TRUE(has_warning(load_text(text, AssimpFormat::collada), "its clips are not told apart"));
}

// --- units and axes ---

glm::dvec3 extent(const Character& c) {
  glm::dvec3 low(1e9);
  glm::dvec3 high(-1e9);
  for (const glm::dvec3& p : posed(c, -1, 0)) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return high - low;
}

TEST(Assimp, UnitsBecomeMetres) {
  const std::string fbx = text_of(AssimpFormat::fbx);
  const double tall = extent(load_text(fbx, AssimpFormat::fbx)).y;
  EXPECT_NEAR(tall, 1.8026, 1e-3);
  const std::string unit = "\"UnitScaleFactor\", \"double\", \"Number\", \"\",";
  EXPECT_NEAR(extent(load_text(changed(fbx, unit + "1", unit + "2.54"), AssimpFormat::fbx)).y, 2.54 * tall, 1e-4);
  const std::string dae = text_of(AssimpFormat::collada);
  EXPECT_NEAR(extent(load_text(changed(dae, "meter=\"0.01\"", "meter=\"0.0254\""), AssimpFormat::collada)).y,
              2.54 * tall, 1e-4);
}

TEST(Assimp, AxesAreTurned) {
  const std::string axis = "\"int\", \"Integer\", \"\",";
  std::string fbx = changed(text_of(AssimpFormat::fbx), "\"UpAxis\", " + axis + "2", "\"UpAxis\", " + axis + "1");
  fbx = changed(fbx, "\"FrontAxis\", " + axis + "1", "\"FrontAxis\", " + axis + "2");
  const Character as_said = load_text(
      changed(fbx, "\"FrontAxisSign\", " + axis + "-1", "\"FrontAxisSign\", " + axis + "1"), AssimpFormat::fbx);
  EXPECT_NEAR(extent(as_said).z, 1.8026, 1e-3);  // the figure stands along the file's z, which now points to the front
  const Character dae = load_text(changed(text_of(AssimpFormat::collada), "Z_UP", "Y_UP"), AssimpFormat::collada);
  EXPECT_NEAR(extent(dae).z, 1.8026, 1e-3);
  const std::string two = changed(text_of(AssimpFormat::fbx), "\"UpAxis\", " + axis + "2", "\"UpAxis\", " + axis + "1");
  EXPECT_NE(error_of([&] { load_text(two, AssimpFormat::fbx); }).find("axes of which two are one"), std::string::npos);
}

// --- pictures ---

TEST_P(AssimpFormats, PicturesAreFoundByTheirNameInTheFolder) {
  const Character c = load_text(text_of(GetParam()), GetParam());
  ASSERT_EQ(c.images.size(), 1U);
  EXPECT_EQ(c.images[0].image.data[0], 255);  // red is the upper left texel
  EXPECT_EQ(c.images[0].image.data[1], 0);
  const auto cloth =
      std::find_if(c.materials.begin(), c.materials.end(), [](const auto& m) { return m.name == "cloth"; });
  ASSERT_NE(cloth, c.materials.end());
  EXPECT_EQ(cloth->base_colour, glm::vec4(1.0F));  // the picture stands in the colour's place
  EXPECT_EQ(cloth->base_colour_image, 0);
}

TEST_P(AssimpFormats, PicturesThatCannotBeReadAreWhiteAndSaid) {
  ScratchFolder outside;
  ScratchFolder folder;
  const std::string text = text_of(GetParam());
  const auto load = [&] { return load_text(text, GetParam(), as_is(), folder.path()); };
  Character c = load();
  EXPECT_TRUE(has_warning(c, "is not in the file's folder, and is drawn white"));
  EXPECT_TRUE(c.images.empty());
  fs::create_directory(folder / "walker.fbm");
  fs::copy_file(kData / "walker.png", folder / "walker.fbm/walker.png");
  EXPECT_EQ(load().images.size(), 1U);
  write_file(folder / "walker.png", "TRUEVISION-XFILE");
  c = load();
  EXPECT_TRUE(has_warning(c, "is not a PNG, JPEG or WebP picture, and is drawn white"));
  fs::remove_all(folder / "walker.fbm");
  fs::remove(folder / "walker.png");
  fs::copy_file(kData / "walker.png", outside / "walker.png");
  fs::create_symlink(outside / "walker.png", folder / "walker.png");
  EXPECT_TRUE(has_warning(load(), "is not in the file's folder"));
}

TEST(Assimp, WhatIsLostIsSaidOnce) {
  EXPECT_TRUE(
      has_warning(load_text(text_of(AssimpFormat::fbx), AssimpFormat::fbx), "lost, as nothing here shows it: lights"));
  EXPECT_FALSE(has_warning(load_text(text_of(AssimpFormat::collada), AssimpFormat::collada), "lost"));
  const std::string constrained = changed(text_of(AssimpFormat::fbx), "Material: 30",
                                          "Constraint: 60, \"Constraint::aim\", \"Aim\" {\n}\nMaterial: 30");
  EXPECT_TRUE(has_warning(load_text(constrained, AssimpFormat::fbx), "constraints, lights"));
}

// --- which files ---

TEST(Assimp, FormatsAreToldByTheirBytesElseByTheirName) {
  const auto told = [](const std::string& start, const char* path) {
    return assimp_format({reinterpret_cast<const uint8_t*>(start.data()), start.size()}, path);
  };
  EXPECT_EQ(told(std::string("Kaydara FBX Binary  \0\x1A", 22), "a"), AssimpFormat::fbx);
  EXPECT_EQ(told("; FBX 7.4.0 project file", "a.txt"), AssimpFormat::fbx);
  EXPECT_EQ(told("FBXHeaderExtension: {", "a.FBX"), AssimpFormat::fbx);
  EXPECT_EQ(told("\xEF\xBB\xBF<?xml version=\"1.0\"?><COLLADA>", "a.xml"), AssimpFormat::collada);
  EXPECT_EQ(told("<?xml version=\"1.0\"?>", "a.dae"), AssimpFormat::collada);
  EXPECT_EQ(told("glTF", "a.fbx"), std::nullopt);
  EXPECT_EQ(told("{\"asset\"", "a.dae"), std::nullopt);
  EXPECT_EQ(told("solid cube", "a.stl"), std::nullopt);
  EXPECT_EQ(told("", "a.glb"), std::nullopt);
}

TEST(Assimp, EveryCommandsCharacterMayBeSuchAFile) {
  EXPECT_EQ(open_character((kData / "walker.fbx").string(), as_is()).triangles(), 5U);
  EXPECT_EQ(open_character((kData / "walker.dae").string(), as_is()).triangles(), 5U);
  ScratchFolder folder;
  fs::copy_file(kData / "walker.dae", folder / "walker");
  const Character c = open_character((folder / "walker").string(), as_is());
  EXPECT_EQ(c.triangles(), 5U);
  save_character(c, folder / "saved.glb");
  expect_same_clip(c, load_character(folder / "saved.glb", as_is()), 0);
  LoadOptions bare = as_is();
  bare.hide = {"hat"};
  EXPECT_EQ(open_character((kData / "walker.fbx").string(), bare).triangles(), 4U);
}

TEST(Assimp, TheFilesAreWhatTheirScriptWrites) {
  if (support::run_shell("command -v node").status != 0) GTEST_SKIP() << "needs node";
  ScratchFolder folder;
  ASSERT_EQ(
      support::run_shell(fmt::format("node '{}' '{}'", (kData / "make_walker.mjs").string(), folder.path().string()))
          .status,
      0);
  for (const char* name : {"walker.fbx", "walker.dae", "walker.png"})
    EXPECT_EQ(read_file(folder / name), read_file(kData / name)) << name;
}

}  // namespace
}  // namespace crowdbench::scene
