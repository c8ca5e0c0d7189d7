// Valid but odd files load, and load right: every number here is worked out by hand.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "core/files.h"
#include "gltf_builder.h"
#include "scene/cast/open_character.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;
using test::as_is;
using test::bending_card;
using test::Builder;
using test::load;
namespace fs = std::filesystem;

std::vector<glm::dvec3> posed(const Character& c, int clip, double time) {
  return skin_positions(c.mesh, joint_matrices(c, clip, time));
}

void expect_point(const glm::dvec3& p, double x, double y, double z, double tolerance = 1e-6) {
  EXPECT_NEAR(p.x, x, tolerance);
  EXPECT_NEAR(p.y, y, tolerance);
  EXPECT_NEAR(p.z, z, tolerance);
}

bool warns(const Character& c, const std::string& fragment) {
  for (const std::string& w : c.warnings)
    if (w.find(fragment) != std::string::npos) return true;
  return false;
}

json& primitive(Builder& b) { return b.doc["meshes"][0]["primitives"][0]; }

struct TemporaryFolder {
  fs::path path = fs::temp_directory_path() / fmt::format("crowdbench-gltf-{}-{}", ::getpid(), counter()++);
  TemporaryFolder() { fs::create_directories(path); }
  ~TemporaryFolder() { fs::remove_all(path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  static int& counter() {
    static int n = 0;
    return n;
  }
};

TEST(GltfValid, CardLoadsAndBends) {
  Builder b = bending_card();
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U);
  EXPECT_EQ(c.skeleton.joints.size(), 2U);
  EXPECT_EQ(c.skeleton.joints[1].name, "arm");
  EXPECT_EQ(c.skeleton.nodes[static_cast<size_t>(c.skeleton.root_node)].name, "hips");
  ASSERT_EQ(c.clips.size(), 1U);
  EXPECT_EQ(c.clips[0].name, "wave");
  EXPECT_EQ(c.clips[0].duration(), 1.0);
  EXPECT_TRUE(c.warnings.empty()) << c.warnings[0];
  expect_point(posed(c, 0, 0.0)[3], 0, 2, 0);
  expect_point(posed(c, 0, 1.0)[3], -1, 1, 0);
  expect_point(posed(c, 0, 1.0)[2], -1, 2, 0);
  expect_point(posed(c, 0, 1.0)[0], 0, 0, 0);
  expect_point(posed(c, 0, 0.5)[3], -std::sqrt(0.5), 1 + std::sqrt(0.5), 0);
}

TEST(GltfValid, MaterialAndPicture) {
  Builder b = bending_card();
  const Character c = load(b);
  ASSERT_EQ(c.materials.size(), 1U);
  EXPECT_EQ(c.materials[0].name, "cloth");
  EXPECT_EQ(c.materials[0].base_colour, glm::vec4(0.5F, 0.25F, 1.0F, 1.0F));
  EXPECT_FALSE(c.materials[0].unlit);
  ASSERT_EQ(c.images.size(), 1U);
  const Texture& t = c.images[0];
  EXPECT_EQ(t.image.width, 2);
  EXPECT_EQ(t.image.channels, 4);
  EXPECT_EQ(t.image.at(1, 1)[0], 120);
  EXPECT_EQ(t.image.at(1, 1)[2], 122);
  EXPECT_FALSE(t.repeat_u);
  EXPECT_TRUE(t.repeat_v);
  EXPECT_TRUE(t.mirrored_v);
  EXPECT_TRUE(t.nearest);
  EXPECT_EQ(c.mesh.uvs[2], glm::vec2(1, 0));
}

// OpenGL's numbers; what is left out is trilinear and repeats.
TEST(GltfValid, SamplersOfEveryKind) {
  const auto with = [](const json& sampler) {
    Builder b = bending_card();
    b.doc["samplers"][0] = sampler;
    return load(b).images.at(0);
  };
  const std::vector<std::pair<int, MinFilter>> filters = {{9728, MinFilter::nearest},
                                                          {9729, MinFilter::linear},
                                                          {9984, MinFilter::nearest_mipmap_nearest},
                                                          {9985, MinFilter::linear_mipmap_nearest},
                                                          {9986, MinFilter::nearest_mipmap_linear},
                                                          {9987, MinFilter::linear_mipmap_linear}};
  for (const auto& [number, filter] : filters) EXPECT_EQ(with({{"minFilter", number}}).min_filter, filter) << number;
  const Texture usual = with(json::object());
  EXPECT_EQ(usual.min_filter, MinFilter::linear_mipmap_linear);
  EXPECT_FALSE(usual.nearest);
  EXPECT_TRUE(usual.repeat_u && usual.repeat_v && !usual.mirrored_u && !usual.mirrored_v);
  EXPECT_FALSE(with({{"magFilter", 9729}}).nearest);
  const Texture mixed = with({{"wrapS", 10497}, {"wrapT", 33071}});
  EXPECT_TRUE(mixed.repeat_u && !mixed.mirrored_u && !mixed.repeat_v);
}

TEST(GltfValid, ContainersAreAlike) {
  Builder b = bending_card();
  const Character glb = load(b);
  const Character embedded = load(b.gltf());
  EXPECT_EQ(glb.content_hash, embedded.content_hash);
  TemporaryFolder folder;
  fs::create_directories(folder.path / "sub");
  const std::vector<uint8_t> text = b.gltf("sub/my%20data.bin");
  write_file(folder.path / "sub/my data.bin", b.bin.data(), b.bin.size());
  write_file(folder.path / "card.gltf", text.data(), text.size());
  EXPECT_EQ(load_character(folder.path / "card.gltf", as_is()).content_hash, glb.content_hash);
  // From within the folder there is no parent path to look in.
  const fs::path here = fs::current_path();
  fs::current_path(folder.path);
  EXPECT_EQ(load_character("card.gltf", as_is()).content_hash, glb.content_hash);
  fs::current_path(here);
}

// A mark of the byte order, parameters of a data uri, uris that nobody encoded, chunks and bytes of others.
TEST(GltfValid, ContainersAsSomeExportersWriteThem) {
  Builder b = bending_card();
  const std::string hash = load(b).content_hash;
  std::vector<uint8_t> text = b.gltf("data:application/gltf-buffer;charset=utf-8;base64," + test::base64(b.bin));
  text.insert(text.begin(), {0xEF, 0xBB, 0xBF});
  EXPECT_EQ(load(text).content_hash, hash);

  TemporaryFolder folder;
  for (const char* name : {"my data.bin", "d\xC3\xA4ta+1.bin"}) {
    write_file(folder.path / name, b.bin.data(), b.bin.size());
    text = b.gltf(name);
    write_file(folder.path / "card.gltf", text.data(), text.size());
    EXPECT_EQ(load_character(folder.path / "card.gltf", as_is()).content_hash, hash) << name;
  }

  b.set_buffer();
  std::vector<uint8_t> glb = b.glb();
  const std::vector<uint8_t> chunk = {4, 0, 0, 0, 'X', 'T', 'R', 'A', 1, 2, 3, 4};
  glb.insert(glb.end(), chunk.begin(), chunk.end());
  EXPECT_EQ(load(glb).content_hash, hash) << "beyond the length that the header says";
  const auto length = static_cast<uint32_t>(glb.size());
  std::memcpy(&glb[8], &length, sizeof length);
  EXPECT_EQ(load(glb).content_hash, hash);
}

TEST(GltfValid, NamesMayHoldAnything) {
  Builder b = bending_card();
  const std::string name = "w\xC3\xA4ve \"two\"\n\t\\";
  b.doc["animations"][0]["name"] = name;
  b.doc["nodes"][2]["name"] = name;
  const Character c = load(b);
  EXPECT_EQ(require_clip(c, name), 0);
  EXPECT_EQ(c.skeleton.joints[1].name, name);
  TemporaryFolder folder;
  save_character(c, folder.path / "again.glb");
  EXPECT_EQ(load_character(folder.path / "again.glb", as_is()).clips[0].name, name);
}

TEST(GltfValid, HashChangesWithWhatIsDrawn) {
  Builder b = bending_card();
  const std::string hash = load(b).content_hash;
  b.doc["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][1] = 0.5;
  EXPECT_NE(load(b).content_hash, hash);
}

TEST(GltfValid, IntegersMayBeWrittenWithAPoint) {
  Builder b = bending_card();
  b.doc["accessors"][0]["count"] = 4.0;
  b.doc["accessors"][0]["componentType"] = 5126.0;
  b.doc["nodes"][0]["mesh"] = 0.0;
  EXPECT_EQ(load(b).triangles(), 2U);
}

TEST(GltfValid, MeshNodeTransformIsIgnoredAndArmaturesCount) {
  Builder b = bending_card();
  b.doc["nodes"][0]["translation"] = {5, 6, 7};
  b.doc["nodes"].push_back({{"name", "armature"}, {"scale", {100, 100, 100}}, {"children", {1}}});
  b.doc["scenes"][0]["nodes"] = {0, 3};
  const Character c = load(b);
  expect_point(posed(c, 0, 1.0)[3], -100, 100, 0, 1e-4);
  const Character scaled = load(b.glb(), LoadOptions{});
  EXPECT_NEAR(scaled.placement.height, 1.75, 1e-9);
  EXPECT_NEAR(scaled.placement.scale, 1.75 / 200, 1e-9);
}

TEST(GltfValid, ArmatureTurnedByAMatrix) {
  Builder b = bending_card();
  // 90 degrees about x: y to z.
  b.doc["nodes"].push_back({{"matrix", {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 3, 1}}, {"children", {1}}});
  b.doc["scenes"][0]["nodes"] = {0, 3};
  expect_point(posed(load(b), -1, 0)[3], 0, 0, 5);
}

TEST(GltfValid, MissingIndicesStripsAndFans) {
  Builder b = bending_card();
  primitive(b).erase("indices");
  primitive(b)["mode"] = 6;  // fan 0 1 2 3
  const Character fan = load(b);
  EXPECT_EQ(fan.mesh.indices, (std::vector<uint32_t>{1, 2, 0, 2, 3, 0}));
  primitive(b)["mode"] = 5;  // strip
  EXPECT_EQ(load(b).mesh.indices, (std::vector<uint32_t>{0, 1, 2, 1, 3, 2}));
  primitive(b)["mode"] = 4;
  primitive(b)["indices"] = b.accessor<uint8_t>({2, 3, 0}, "SCALAR");
  EXPECT_EQ(load(b).mesh.indices, (std::vector<uint32_t>{1, 2, 0}));  // vertex 1 is not drawn
  primitive(b)["indices"] = b.accessor<uint32_t>({3, 0, 1}, "SCALAR");
  EXPECT_EQ(load(b).mesh.indices, (std::vector<uint32_t>{2, 0, 1}));
}

TEST(GltfValid, PointsAndLinesAreSkippedWithAWarning) {
  Builder b = bending_card();
  json lines = primitive(b);
  lines["mode"] = 1;
  b.doc["meshes"][0]["primitives"].push_back(lines);
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U);
  EXPECT_EQ(c.mesh.positions.size(), 4U);
  EXPECT_TRUE(warns(c, "lines"));
}

TEST(GltfValid, MissingNormalsAreFlatAndKeepTheFilesVertices) {
  Builder b = bending_card();
  primitive(b)["attributes"].erase("NORMAL");
  EXPECT_EQ(load(b).mesh.positions.size(), 4U) << "coplanar faces share their vertices";
  // Two faces over the edge 0-2 at right angles: 3 leaves the plane.
  primitive(b)["attributes"]["POSITION"] = b.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
  json second = primitive(b);
  second["material"] = 1;
  b.doc["materials"].push_back(b.doc["materials"][0]);
  b.doc["meshes"][0]["primitives"].push_back(second);
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 4U);
  EXPECT_EQ(c.mesh.file_vertex_count(), 8U);
  EXPECT_EQ(c.mesh.positions.size(), 12U);
  EXPECT_EQ(c.mesh.file_vertices, (std::vector<uint32_t>{0, 1, 2, 3, 6, 7, 8, 9}));
  EXPECT_EQ(c.mesh.primitives[0].vertex_count, 6U);
  EXPECT_EQ(c.mesh.primitives[1].first_vertex, 6U);
  for (size_t t = 0; t < c.mesh.indices.size(); t += 3) {
    const glm::vec3 normal = (t / 3) % 2 == 0 ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
    for (size_t k = 0; k < 3; ++k) EXPECT_EQ(c.mesh.normals[c.mesh.indices[t + k]], normal);
  }
  EXPECT_TRUE(warns(c, "no normals"));
}

TEST(GltfValid, MissingUvsTexturesMaterialsAndBinds) {
  Builder b = bending_card();
  primitive(b)["attributes"].erase("TEXCOORD_0");
  const Character no_uv = load(b);
  EXPECT_EQ(no_uv.mesh.uvs[2], glm::vec2(0, 0));
  EXPECT_TRUE(warns(no_uv, "TEXCOORD_0"));
  primitive(b).erase("material");
  const Character plain = load(b);
  ASSERT_EQ(plain.materials.size(), 2U);
  EXPECT_EQ(plain.mesh.primitives[0].material, 1);
  EXPECT_EQ(plain.materials[1].base_colour, glm::vec4(1.0F));
  EXPECT_EQ(plain.images.size(), 0U) << "a picture that nothing shows is not decoded";
  b.doc["skins"][0].erase("inverseBindMatrices");
  expect_point(posed(load(b), -1, 0)[3], 0, 3, 0);  // identity binds: the arm's own height is added
}

TEST(GltfValid, WholeNumberWeights) {
  Builder b = bending_card();
  const std::vector<uint8_t> half = {128, 127, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0};
  primitive(b)["attributes"]["WEIGHTS_0"] = b.accessor<uint8_t>(half, "VEC4", true);
  Character c = load(b);
  EXPECT_FLOAT_EQ(c.mesh.weights[0].x, 1.0F) << "two influences of one joint are one";
  primitive(b)["attributes"]["JOINTS_0"] =
      b.accessor<uint16_t>({0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  c = load(b);
  EXPECT_FLOAT_EQ(c.mesh.weights[0].x, 128.0F / 255.0F);
  EXPECT_FLOAT_EQ(c.mesh.weights[0].y, 127.0F / 255.0F);
  EXPECT_EQ(c.mesh.joints[0], glm::u16vec4(0, 1, 0, 0));
  EXPECT_EQ(c.file_max_influences, 2);
  const std::vector<uint16_t> wide = {65535, 0, 0, 0, 65535, 0, 0, 0, 32768, 32767, 0, 0, 65535, 0, 0, 0};
  primitive(b)["attributes"]["WEIGHTS_0"] = b.accessor<uint16_t>(wide, "VEC4", false);
  c = load(b);
  EXPECT_TRUE(warns(c, "not marked as normalised"));
  EXPECT_FLOAT_EQ(c.mesh.weights[2].x, 32768.0F / 65535.0F);
}

TEST(GltfValid, TheFourLargestOfAllSetsAreKept) {
  Builder b = bending_card();
  // Six joints; vertex 0 has weights .05 .1 .1 .15 | .2 .4: kept .4 .2 .15 .1, lost .15.
  for (int i = 0; i < 4; ++i) {
    b.doc["nodes"].push_back({{"name", fmt::format("j{}", i)}});
    b.doc["nodes"][1]["children"].push_back(3 + i);
  }
  b.doc["skins"][0] = {{"joints", {1, 2, 3, 4, 5, 6}}};
  const std::vector<uint8_t> first = {0, 1, 2, 3, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  const std::vector<uint8_t> second = {4, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  primitive(b)["attributes"]["JOINTS_0"] = b.accessor<uint8_t>(first, "VEC4");
  primitive(b)["attributes"]["JOINTS_1"] = b.accessor<uint8_t>(second, "VEC4");
  primitive(b)["attributes"]["WEIGHTS_0"] =
      b.accessor<float>({.05F, .1F, .1F, .15F, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  primitive(b)["attributes"]["WEIGHTS_1"] =
      b.accessor<float>({.2F, .4F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const Character c = load(b);
  EXPECT_EQ(c.mesh.joints[0], glm::u16vec4(5, 4, 3, 1));
  EXPECT_NEAR(c.mesh.weights[0].x, 0.4 / 0.85, 1e-6);
  EXPECT_NEAR(c.mesh.weights[0].w, 0.1 / 0.85, 1e-6);
  EXPECT_EQ(c.file_max_influences, 6);
  EXPECT_TRUE(warns(c, "1 vertices have up to 6 influences")) << c.warnings.back();
  EXPECT_TRUE(warns(c, "15.00 % at most")) << c.warnings.back();
}

TEST(GltfValid, WeightsOfOtherSums) {
  Builder b = bending_card();
  primitive(b)["attributes"]["WEIGHTS_0"] =
      b.accessor<float>({0, 0, 0, 0, .1F, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const Character c = load(b);
  for (const glm::vec4& w : c.mesh.weights) EXPECT_EQ(w, glm::vec4(1, 0, 0, 0));
  EXPECT_EQ(c.mesh.joints[3].x, 1) << "without weights a vertex follows its own first joint";
  EXPECT_TRUE(warns(c, "2 vertices without any weight"));
  EXPECT_TRUE(warns(c, "2 vertices with weights that do not sum to 1"));
}

TEST(GltfValid, JointsOutOfRangeWithoutWeightAreNoFault) {
  Builder b = bending_card();
  primitive(b)["attributes"]["JOINTS_0"] =
      b.accessor<uint8_t>({0, 255, 255, 255, 0, 9, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  EXPECT_EQ(load(b).mesh.joints[0], glm::u16vec4(0));
}

TEST(GltfValid, SparseAccessors) {
  Builder b = bending_card();
  const std::vector<uint16_t> where = {1, 3};
  const std::vector<float> what = {1, 0, 5, 0, 2, 6};
  const int indices = b.view(where.data(), 4);
  const int values = b.view(what.data(), 24);
  b.doc["accessors"][0]["sparse"] = {{"count", 2},
                                     {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                     {"values", {{"bufferView", values}}}};
  Character c = load(b);
  EXPECT_EQ(c.mesh.positions[1], glm::vec3(1, 0, 5));
  EXPECT_EQ(c.mesh.positions[2], glm::vec3(1, 2, 0));
  EXPECT_EQ(c.mesh.positions[3], glm::vec3(0, 2, 6));
  b.doc["accessors"][0].erase("bufferView");  // zeros below
  c = load(b);
  EXPECT_EQ(c.mesh.positions[1], glm::vec3(1, 0, 5));
  EXPECT_EQ(c.mesh.positions[2], glm::vec3(0, 0, 0));
}

TEST(GltfValid, InterleavedVertices) {
  Builder b = bending_card();
  const std::vector<float> both = {0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 2, 0, 0, 0, 1, 0, 2, 0, 0, 0, 1};
  const int view = b.view(both.data(), both.size() * 4, 24);
  b.doc["accessors"][0]["bufferView"] = view;
  b.doc["accessors"][1]["bufferView"] = view;
  b.doc["accessors"][1]["byteOffset"] = 12;
  const Character c = load(b);
  EXPECT_EQ(c.mesh.positions[2], glm::vec3(1, 2, 0));
  EXPECT_EQ(c.mesh.normals[2], glm::vec3(0, 0, 1));
}

TEST(GltfValid, QuantizedMesh) {
  Builder b = bending_card();
  b.doc["extensionsUsed"] = {"KHR_mesh_quantization"};
  b.doc["extensionsRequired"] = {"KHR_mesh_quantization"};
  json& attributes = primitive(b)["attributes"];
  attributes["POSITION"] = b.accessor<int16_t>({0, 0, 0, 32767, 0, 0, 32767, -32768, 0, 0, -16384, 0}, "VEC3", true);
  attributes["NORMAL"] = b.accessor<int8_t>({0, 0, 127, 0, 0, 127, 0, 127, 0, 0, 0, -128}, "VEC3", true);
  attributes["TEXCOORD_0"] = b.accessor<uint16_t>({0, 0, 65535, 0, 0, 0, 0, 32768}, "VEC2", true);
  const Character c = load(b);
  EXPECT_EQ(c.mesh.positions[2], glm::vec3(1, -1, 0));
  EXPECT_FLOAT_EQ(c.mesh.positions[3].y, -16384.0F / 32767.0F);
  EXPECT_EQ(c.mesh.normals[2], glm::vec3(0, 1, 0));
  EXPECT_EQ(c.mesh.normals[3], glm::vec3(0, 0, -1));
  EXPECT_EQ(c.mesh.uvs[1], glm::vec2(1, 0));
  attributes["POSITION"] = b.accessor<uint8_t>({0, 0, 0, 3, 0, 0, 3, 200, 0, 0, 200, 0}, "VEC3");
  EXPECT_EQ(load(b).mesh.positions[2], glm::vec3(3, 200, 0));
}

TEST(GltfValid, TextureTransformIsFoldedIntoUvs) {
  Builder b = bending_card();
  b.doc["extensionsRequired"] = {"KHR_texture_transform"};
  json& texture = b.doc["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  texture["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.25, 0.5}}, {"rotation", 1.5707963267948966}, {"scale", {2, 4}}};
  // Scale first, then a quarter turn counter-clockwise as seen (v down), then the offset: (1, 0) -> (2, 0) -> (0, -2).
  const Character c = load(b);
  EXPECT_NEAR(c.mesh.uvs[2].x, 0.25, 1e-6);
  EXPECT_NEAR(c.mesh.uvs[2].y, -1.5, 1e-6);
  // (0, 1) -> (0, 4) -> (4, 0).
  EXPECT_NEAR(c.mesh.uvs[0].x, 4.25, 1e-6);
  EXPECT_NEAR(c.mesh.uvs[0].y, 0.5, 1e-6);
}

TEST(GltfValid, SecondUvSetForEmission) {
  Builder b = bending_card();
  b.doc["materials"][0]["emissiveFactor"] = {1, 0.5, 0};
  b.doc["materials"][0]["emissiveTexture"] = {{"index", 0}, {"texCoord", 1}};
  b.doc["materials"][0]["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", 4}};
  primitive(b)["attributes"]["TEXCOORD_1"] = b.accessor<float>({.1F, 0, .2F, 0, .3F, 0, .4F, 0}, "VEC2");
  const Character c = load(b);
  EXPECT_EQ(c.materials[0].emissive, glm::vec3(4, 2, 0));
  EXPECT_EQ(c.materials[0].emissive_image, 0) << "one picture with one sampler is decoded once";
  ASSERT_EQ(c.mesh.emissive_uvs.size(), 4U);
  EXPECT_EQ(c.mesh.emissive_uvs[2], glm::vec2(.3F, 0));
  EXPECT_EQ(c.mesh.uvs[2], glm::vec2(1, 0));
}

TEST(GltfValid, UnlitDoubleSidedAndAlpha) {
  Builder b = bending_card();
  b.doc["extensionsRequired"] = {"KHR_materials_unlit"};
  b.doc["extensionsUsed"] = {"KHR_materials_unlit", "KHR_materials_clearcoat"};
  b.doc["materials"][0]["extensions"]["KHR_materials_unlit"] = json::object();
  b.doc["materials"][0]["doubleSided"] = true;
  b.doc["materials"][0]["alphaMode"] = "BLEND";
  const Character c = load(b);
  EXPECT_TRUE(c.materials[0].unlit);
  EXPECT_TRUE(c.materials[0].double_sided);
  EXPECT_TRUE(warns(c, "BLEND is drawn as MASK at 0.5"));
  EXPECT_EQ(c.materials[0].alpha_cutoff, 0.5F);
  EXPECT_TRUE(warns(c, "KHR_materials_clearcoat"));
}

TEST(GltfValid, MaskHasACutoff) {
  Builder b = bending_card();
  json& material = b.doc["materials"][0];
  material["alphaCutoff"] = 0.25;  // of no effect while opaque
  const Character opaque = load(b);
  EXPECT_EQ(opaque.materials[0].alpha_cutoff, 0.0F);
  material["alphaMode"] = "MASK";
  const Character masked = load(b);
  EXPECT_EQ(masked.materials[0].alpha_cutoff, 0.25F);
  EXPECT_TRUE(masked.warnings.empty());
  EXPECT_NE(masked.content_hash, opaque.content_hash);
  material.erase("alphaCutoff");
  EXPECT_EQ(load(b).materials[0].alpha_cutoff, 0.5F);
}

TEST(GltfValid, VertexColoursOfZeroAreWarnedAbout) {
  Builder b = bending_card();
  primitive(b)["attributes"]["COLOR_0"] = b.accessor<float>(std::vector<float>(12, 0.0F), "VEC3");
  const Character c = load(b);
  EXPECT_EQ(c.mesh.colours[3], glm::vec4(0, 0, 0, 1));
  EXPECT_TRUE(warns(c, "COLOR_0 is black"));
}

TEST(GltfValid, VertexColours) {
  Builder b = bending_card();
  json second = primitive(b);
  primitive(b)["attributes"]["COLOR_0"] = b.accessor<uint8_t>({255, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", true);
  b.doc["meshes"][0]["primitives"].push_back(second);
  const Character c = load(b);
  ASSERT_EQ(c.mesh.colours.size(), 8U);
  EXPECT_EQ(c.mesh.colours[0], glm::vec4(1, 0, 0.2F, 1));
  EXPECT_EQ(c.mesh.colours[5], glm::vec4(1.0F));
  primitive(b)["attributes"]["COLOR_0"] =
      b.accessor<uint16_t>({0, 65535, 0, 13107, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", true);
  EXPECT_EQ(load(b).mesh.colours[0], glm::vec4(0, 1, 0, 0.2F));
}

TEST(GltfValid, StepAndCubicSplines) {
  Builder b = bending_card();
  json& sampler = b.doc["animations"][0]["samplers"][0];
  sampler["interpolation"] = "STEP";
  expect_point(posed(load(b), 0, 0.99)[3], 0, 2, 0);
  // A translation of the arm from y 1 to y 3, the in-tangents zero, out-tangents 2: h(1/2) = 1/2 1 + 1/8 2 + 1/2 3.
  sampler["interpolation"] = "CUBICSPLINE";
  sampler["output"] = b.accessor<float>({0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 3, 0, 0, 2, 0}, "VEC3");
  b.doc["animations"][0]["channels"][0]["target"]["path"] = "translation";
  expect_point(posed(load(b), 0, 0.5)[3], 0, 0.5 + 0.25 + 1.5 + 1.0, 0);
}

TEST(GltfValid, NormalisedIntegerRotations) {
  Builder b = bending_card();
  b.doc["animations"][0]["samplers"][0]["output"] =
      b.accessor<int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170}, "VEC4", true);
  expect_point(posed(load(b), 0, 1.0)[3], -1, 1, 0);
}

TEST(GltfValid, KeysAfterZeroAndZeroLength) {
  Builder b = bending_card();
  b.doc["animations"].push_back(b.doc["animations"][0]);
  b.doc["animations"][0]["samplers"][0]["input"] = b.accessor<float>({2, 3}, "SCALAR");
  b.doc["animations"][1]["samplers"][0]["input"] = b.accessor<float>({0.5F}, "SCALAR");
  b.doc["animations"][1]["samplers"][0]["output"] = b.accessor<float>({0, 0, 0, 1}, "VEC4");
  const Character c = load(b);
  EXPECT_EQ(c.clips[0].start, 2.0);
  EXPECT_EQ(c.clips[0].end, 3.0);
  expect_point(posed(c, 0, 1.0)[3], 0, 2, 0);
  expect_point(posed(c, 0, 3.0)[3], -1, 1, 0);
  EXPECT_EQ(c.clips[1].duration(), 0.0);
  EXPECT_EQ(c.placement.default_clip, 0);
  EXPECT_TRUE(warns(c, "1 clips have zero length: wave"));
}

TEST(GltfValid, RigidMeshOnAJointAndItsOptions) {
  Builder b = bending_card();
  json rigid = primitive(b);
  b.doc["meshes"].push_back({{"primitives", {rigid}}});
  b.doc["nodes"].push_back({{"name", "sword"}, {"mesh", 1}, {"scale", {-1, 1, 1}}});
  b.doc["nodes"][2]["children"] = {3};
  const Character c = load(b);
  ASSERT_EQ(c.skeleton.joints.size(), 3U);
  EXPECT_TRUE(c.skeleton.joints[2].rigid);
  EXPECT_EQ(c.mesh.joints[4].x, 2);
  EXPECT_FALSE(c.mesh.primitives[0].mirrored);
  EXPECT_TRUE(c.mesh.primitives[1].mirrored);
  expect_point(posed(c, -1, 0)[6], -1, 3, 0);   // (1, 2, 0) mirrored, on the arm
  expect_point(posed(c, 0, 1.0)[6], -2, 0, 0);  // and turned with it
  LoadOptions without = as_is();
  without.rigid_meshes = false;
  EXPECT_EQ(load(b, without).triangles(), 2U);
  LoadOptions hidden = as_is();
  hidden.hide = {"arm"};
  EXPECT_EQ(load(b, hidden).triangles(), 2U) << "what hangs from a hidden node is hidden";
  hidden.hide = {"swort"};
  try {
    load(b, hidden);
    FAIL() << "an unknown name was accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean sword?"), std::string::npos) << e.what();
  }
  hidden.hide = {"body", "sword"};
  EXPECT_THROW(load(b, hidden), Error);
}

TEST(GltfValid, AnimationWithoutSkin) {
  Builder b = bending_card();
  b.doc.erase("skins");
  b.doc["nodes"] = {{{"name", "torso"}, {"mesh", 0}, {"children", {1}}},
                    {{"name", "head"}, {"mesh", 0}, {"translation", {0, 2, 0}}}};
  b.doc["scenes"][0]["nodes"] = {0};
  b.doc["animations"][0]["channels"][0]["target"]["node"] = 1;
  const Character c = load(b);
  ASSERT_EQ(c.skeleton.joints.size(), 2U);
  EXPECT_TRUE(c.skeleton.joints[0].rigid);
  EXPECT_EQ(c.skeleton.root_node, -1);
  expect_point(posed(c, 0, 1.0)[3], 0, 2, 0);
  expect_point(posed(c, 0, 1.0)[7], -2, 2, 0);
}

TEST(GltfValid, ScenesAndNodesOutside) {
  Builder b = bending_card();
  b.doc["nodes"].push_back({{"name", "elsewhere"}, {"mesh", 0}});
  EXPECT_EQ(load(b).triangles(), 2U);
  b.doc["scenes"] = {{{"nodes", {3}}}, {{"nodes", {0}}}};
  b.doc["scene"] = 1;  // the joints are not in this scene, the skin moves the mesh all the same
  expect_point(posed(load(b), 0, 1.0)[3], -1, 1, 0);
  b.doc.erase("scene");
  b.doc["skins"] = json::array();
  b.doc["nodes"][0].erase("skin");
  EXPECT_TRUE(load(b).skeleton.joints[0].rigid) << "scene 0 is the default";
  b.doc.erase("scenes");
  const Character all = load(b);
  EXPECT_EQ(all.triangles(), 4U);
  EXPECT_TRUE(warns(all, "no scene"));
}

TEST(GltfValid, TwoSkinsAndOneSkinTwice) {
  Builder b = bending_card();
  b.doc["skins"].push_back({{"joints", {2, 1}}});
  b.doc["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  b.doc["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
  b.doc["scenes"][0]["nodes"] = {0, 1, 3, 4};
  const Character c = load(b);
  EXPECT_EQ(c.skeleton.joints.size(), 4U);
  EXPECT_EQ(c.mesh.joints[0].x, 0);
  EXPECT_EQ(c.mesh.joints[4].x, 2);
  EXPECT_EQ(c.skeleton.joints[2].name, "arm");
  EXPECT_EQ(c.mesh.joints[8].x, 0);
  EXPECT_EQ(c.mesh.primitives[2].gltf_node, 4);
}

TEST(GltfValid, MorphTargetsAreIgnored) {
  Builder b = bending_card();
  primitive(b)["targets"] = {{{"POSITION", 0}}};
  b.doc["animations"][0]["channels"].push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}});
  const Character c = load(b);
  EXPECT_TRUE(warns(c, "morph targets are ignored"));
  EXPECT_EQ(c.clips[0].channels.size(), 1U);
}

TEST(GltfValid, AnimatedMatrixIsTakenApart) {
  Builder b = bending_card();
  b.doc["nodes"][2] = {{"name", "arm"}, {"matrix", {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 1, 0, 1}}};
  const Character c = load(b);
  expect_point(posed(c, 0, 1.0)[3], -2, 1, 0);
  EXPECT_TRUE(warns(c, "has a matrix"));
}

TEST(GltfValid, DegenerateShapesLoad) {
  Builder b = bending_card();
  primitive(b)["indices"] = b.accessor<uint16_t>({0, 0, 0}, "SCALAR");
  primitive(b)["attributes"].erase("NORMAL");
  const Character c = load(b);
  ASSERT_EQ(c.mesh.normals.size(), c.mesh.positions.size());
  ASSERT_FALSE(c.mesh.normals.empty());
  for (const glm::vec3& n : c.mesh.normals) EXPECT_NEAR(glm::length(n), 1.0F, 1e-6F);
  b.doc["nodes"][1]["scale"] = {0, 0, 0};
  EXPECT_NO_THROW(load(b.glb(), LoadOptions{}));
}

TEST(GltfValid, SavedFileIsTheSameCharacter) {
  Builder b = bending_card();
  json rigid = primitive(b);
  rigid.erase("material");
  b.doc["meshes"].push_back({{"primitives", {rigid, rigid}}});
  b.doc["nodes"].push_back({{"name", "sword"}, {"mesh", 1}, {"scale", {-1, 1, 1}}});
  b.doc["nodes"][2]["children"] = {3};
  b.doc["materials"][0]["emissiveFactor"] = {1, 0.5, 0};
  b.doc["materials"][0]["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", 4}};
  const Character c = load(b);
  TemporaryFolder folder;
  save_character(c, folder.path / "saved.glb");
  const Character again = load_character(folder.path / "saved.glb", as_is());
  EXPECT_EQ(again.triangles(), c.triangles());
  EXPECT_EQ(again.mesh.indices, c.mesh.indices);
  EXPECT_EQ(again.mesh.uvs, c.mesh.uvs);
  EXPECT_EQ(again.mesh.normals, c.mesh.normals);
  EXPECT_EQ(again.images[0].image, c.images[0].image);
  EXPECT_TRUE(again.images[0].mirrored_v);
  EXPECT_EQ(again.materials[0].emissive, c.materials[0].emissive);
  EXPECT_EQ(again.materials[0].name, "cloth");
  EXPECT_TRUE(again.mesh.primitives[1].mirrored);
  for (const double t : {0.0, 0.3, 1.0}) {
    const auto p = posed(c, 0, t);
    const auto q = posed(again, 0, t);
    for (size_t v = 0; v < p.size(); ++v) expect_point(q[v], p[v].x, p[v].y, p[v].z);
  }
  EXPECT_THROW(save_character(c, folder.path / "saved.obj"), Error);
}

TEST(GltfValid, MannequinSurvivesASave) {
  for (const char* name : {"mannequin", "mannequin:triangles=500,joints=53"}) {
    SCOPED_TRACE(name);
    const Character c = open_character(name, as_is());
    TemporaryFolder folder;
    save_character(c, folder.path / "mannequin.glb");
    const Character again = load_character(folder.path / "mannequin.glb", as_is());
    EXPECT_EQ(again.mesh.indices, c.mesh.indices);
    EXPECT_EQ(again.skeleton.joints.size(), c.skeleton.joints.size());
    ASSERT_EQ(again.clips.size(), c.clips.size());
    ASSERT_EQ(again.materials.size(), c.materials.size());
    for (size_t i = 0; i < c.materials.size(); ++i) EXPECT_EQ(again.materials[i].name, c.materials[i].name);
    ASSERT_EQ(again.images.size(), c.images.size());
    EXPECT_EQ(again.images[0].image, c.images[0].image);
    EXPECT_TRUE(again.warnings.empty()) << again.warnings[0];
    for (size_t clip = 0; clip < c.clips.size(); ++clip) {
      EXPECT_EQ(again.clips[clip].name, c.clips[clip].name);
      const double t = c.clips[clip].start + 0.37 * c.clips[clip].duration();
      const auto p = posed(c, static_cast<int>(clip), t);
      const auto q = posed(again, static_cast<int>(clip), t);
      ASSERT_EQ(p.size(), q.size());
      double worst = 0;
      for (size_t v = 0; v < p.size(); ++v) worst = std::max(worst, glm::length(p[v] - q[v]));
      EXPECT_LT(worst, 1e-6);
    }
  }
}

TEST(GltfValid, OpenCharacterRefusesUnknownOptions) {
  EXPECT_THROW(open_character("mannequin:triangels=500"), Error);
  EXPECT_THROW(open_character("mannequin:triangles=many"), Error);
  EXPECT_THROW(open_character("mannequin:joints"), Error);
  EXPECT_THROW(open_character("no-such-file.glb"), Error);
}

// A name is the first clip that has it; the warning says how the others are reached.
TEST(GltfValid, ClipsThatANameDoesNotReachAreSaid) {
  Builder b = bending_card();
  const json wave = b.doc["animations"][0];
  json& animations = b.doc["animations"];
  for (const char* name : {"walk", "wave", "", "", "0", "9"}) {
    json one = wave;
    one["name"] = name;
    animations.push_back(one);
  }
  TemporaryFolder folder;
  const std::vector<uint8_t> bytes = b.glb();
  write_file(folder.path / "card.glb", bytes.data(), bytes.size());
  const Character c = open_character((folder.path / "card.glb").string(), as_is());
  EXPECT_TRUE(warns(c, "2 clips are named 'wave': the name stands for clip 0; name the other by its number: 2"));
  EXPECT_TRUE(warns(c, "clip 5 is named '0': that stands for it, and not for clip 0"));
  EXPECT_EQ(c.warnings.size(), 2U) << "clips without a name, and a number that no clip has, hide nothing";
  EXPECT_EQ(require_clip(c, "wave"), 0);
  EXPECT_EQ(require_clip(c, "2"), 2);
  EXPECT_EQ(require_clip(c, "0"), 5);
}

// Decoded once, sampled as each texture says, and each counted towards the limit.
TEST(GltfValid, TwoTexturesOfOnePicture) {
  Builder b = bending_card();
  b.doc["textures"].push_back({{"source", 0}});
  b.doc["materials"][0]["emissiveTexture"] = {{"index", 1}};
  b.doc["materials"][0]["emissiveFactor"] = {1, 1, 1};
  const Character c = load(b);
  ASSERT_EQ(c.images.size(), 2U);
  EXPECT_EQ(c.images[0].image, c.images[1].image);
  EXPECT_TRUE(c.images[0].nearest);
  EXPECT_FALSE(c.images[1].nearest);
  LoadOptions options = as_is();
  options.limits.image_bytes = 31;
  EXPECT_THROW(load(b, options), Error);
  options.limits.image_bytes = 32;
  EXPECT_NO_THROW(load(b, options));
}

TEST(GltfValid, SkinsThatShareJointsAreSavedApart) {
  Builder b = bending_card();
  b.doc["skins"].push_back({{"joints", {2, 1}}});
  b.doc["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  b.doc["scenes"][0]["nodes"] = {0, 1, 3};
  const Character c = load(b);
  TemporaryFolder folder;
  save_character(c, folder.path / "saved.glb");
  const Character again = load_character(folder.path / "saved.glb", as_is());
  const auto p = posed(c, 0, 0.7);
  const auto q = posed(again, 0, 0.7);
  ASSERT_EQ(p.size(), q.size());
  for (size_t v = 0; v < p.size(); ++v) expect_point(q[v], p[v].x, p[v].y, p[v].z);
}

}  // namespace
}  // namespace crowdbench::scene
