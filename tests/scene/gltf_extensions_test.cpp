// Extensions of glTF: what is read, what is ignored, what is refused. Compressed data comes from the libraries' own
// encoders; what it must load as is the same card uncompressed.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "core/random.h"
#include "gltf_builder.h"
#include "test_paths.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;
using test::as_is;
using test::bending_card;
using test::Builder;
using test::load;

std::string error_of(const std::vector<uint8_t>& bytes, const LoadOptions& options = as_is()) {
  try {
    load(bytes, options);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

size_t warnings_with(const Character& c, const std::string& fragment) {
  return static_cast<size_t>(std::count_if(c.warnings.begin(), c.warnings.end(), [&](const std::string& w) {
    return w.find(fragment) != std::string::npos;
  }));
}

json& primitive(Builder& b) { return b.doc["meshes"][0]["primitives"][0]; }

TEST(GltfExtensions, WhatChangesNothingIsIgnoredEvenIfRequired) {
  Builder b = bending_card();
  const std::vector<std::string> names = {"KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_materials_specular",
                                          "KHR_materials_variants"};
  b.doc["extensionsUsed"] = names;
  b.doc["extensionsRequired"] = names;
  b.doc["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  b.doc["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const Character c = load(b);
  EXPECT_EQ(c.triangles(), 2U);
  ASSERT_EQ(c.warnings.size(), 1U);
  for (const std::string& name : names) EXPECT_EQ(warnings_with(c, name), 1U) << name;
}

TEST(GltfExtensions, InstancesThatAreNotRequiredAreDrawnOnceWithAWarning) {
  Builder b = bending_card();
  b.doc["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  b.doc["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 0;
  EXPECT_EQ(warnings_with(load(b), "EXT_mesh_gpu_instancing"), 1U);
}

TEST(GltfExtensions, DiffuseOfTheOlderMaterialModelIsTheBaseColour) {
  Builder b = bending_card();
  json& material = b.doc["materials"][0];
  material.erase("pbrMetallicRoughness");
  material["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
                                                                   {"diffuseTexture", {{"index", 0}}}};
  b.doc["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
  const Character c = load(b);
  EXPECT_EQ(c.materials[0].base_colour, glm::vec4(0.5F, 0.25F, 0.125F, 1.0F));
  EXPECT_EQ(c.materials[0].base_colour_image, 0);
  EXPECT_TRUE(c.warnings.empty());
}

// --- EXT_meshopt_compression ---

// The last view's bytes are what they were, encoded.
void mark_packed(Builder& b, const char* mode, const char* filter, size_t count, size_t stride, bool vertices) {
  json& view = b.doc["bufferViews"].back();
  const json packed = {{"buffer", 0},
                       {"byteOffset", view["byteOffset"]},
                       {"byteLength", view["byteLength"]},
                       {"byteStride", stride},
                       {"count", count},
                       {"mode", mode},
                       {"filter", filter}};
  view = {{"buffer", 1}, {"byteOffset", 0}, {"byteLength", count * stride}};
  view["extensions"]["EXT_meshopt_compression"] = packed;
  if (vertices) view["byteStride"] = stride;
}

int add_accessor(Builder& b, int component, const char* type, size_t count, bool normalized) {
  b.doc["accessors"].push_back({{"bufferView", b.doc["bufferViews"].size() - 1},
                                {"componentType", component},
                                {"type", type},
                                {"count", count},
                                {"normalized", normalized}});
  return static_cast<int>(b.doc["accessors"].size()) - 1;
}

int packed_vertices(Builder& b, const void* data, size_t count, size_t stride, const char* filter,
                    bool vertices = true) {
  std::vector<uint8_t> packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), data, count, stride));
  b.view(packed.data(), packed.size());
  mark_packed(b, "ATTRIBUTES", filter, count, stride, vertices);
  return static_cast<int>(b.doc["bufferViews"].size()) - 1;
}

std::vector<uint8_t> packed_card(Builder b = bending_card()) {
  json& attributes = primitive(b)["attributes"];
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0};
  packed_vertices(b, positions.data(), 4, 12, "NONE");
  attributes["POSITION"] = add_accessor(b, 5126, "VEC3", 4, false);

  const std::vector<float> normals = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::vector<int8_t> oct(16);
  meshopt_encodeFilterOct(oct.data(), 4, 4, 8, normals.data());
  packed_vertices(b, oct.data(), 4, 4, "OCTAHEDRAL");
  attributes["NORMAL"] = add_accessor(b, 5120, "VEC3", 4, true);

  const std::vector<float> times = {0, 1};
  std::vector<uint8_t> exponents(8);
  meshopt_encodeFilterExp(exponents.data(), 2, 4, 15, times.data());
  packed_vertices(b, exponents.data(), 2, 4, "EXPONENTIAL", false);
  json& sampler = b.doc["animations"][0]["samplers"][0];
  sampler["input"] = add_accessor(b, 5126, "SCALAR", 2, false);

  const float h = 0.70710678F;
  const std::vector<float> turns = {0, 0, 0, 1, 0, 0, h, h};
  std::vector<int16_t> quaternions(8);
  meshopt_encodeFilterQuat(quaternions.data(), 2, 8, 16, turns.data());
  packed_vertices(b, quaternions.data(), 2, 8, "QUATERNION", false);
  sampler["output"] = add_accessor(b, 5122, "VEC4", 2, true);

  const std::vector<unsigned> indices = {0, 1, 2, 0, 2, 3};
  std::vector<uint8_t> triangles(meshopt_encodeIndexBufferBound(6, 4));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 6));
  b.view(triangles.data(), triangles.size());
  mark_packed(b, "TRIANGLES", "NONE", 6, 2, false);
  primitive(b)["indices"] = add_accessor(b, 5123, "SCALAR", 6, false);

  b.doc["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  b.doc["buffers"] = {{{"byteLength", b.bin.size()}},
                      {{"byteLength", 1000}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  return b.glb();
}

TEST(GltfMeshopt, PackedCardIsTheCard) {
  Builder b = bending_card();
  const Character plain = load(b);
  const Character c = load(packed_card());
  EXPECT_TRUE(c.warnings.empty()) << c.warnings[0];
  EXPECT_EQ(c.mesh.positions, plain.mesh.positions);
  // The encoder turns triangles, not their order or their winding.
  ASSERT_EQ(c.mesh.indices.size(), 6U);
  for (size_t t = 0; t < 6; t += 3) {
    std::vector<uint32_t> corners(c.mesh.indices.begin() + long(t), c.mesh.indices.begin() + long(t) + 3);
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    EXPECT_EQ(corners, (t == 0 ? std::vector<uint32_t>{0, 1, 2} : std::vector<uint32_t>{0, 2, 3}));
  }
  for (const glm::vec3& n : c.mesh.normals) EXPECT_NEAR(n.z, 1.0F, 1e-6F);
  const Channel& channel = c.clips.at(0).channels.at(0);
  EXPECT_EQ(channel.times, (std::vector<double>{0, 1}));
  const std::vector<double> turns = {0, 0, 0, 1, 0, 0, 0.70710678, 0.70710678};
  ASSERT_EQ(channel.values.size(), turns.size());
  for (size_t i = 0; i < turns.size(); ++i) EXPECT_NEAR(channel.values[i], turns[i], 1e-4);
}

TEST(GltfMeshopt, SequencesOfIndices) {
  Builder b = bending_card();
  const std::vector<unsigned> indices = {0, 1, 2, 0, 2, 3};
  std::vector<uint8_t> packed(meshopt_encodeIndexSequenceBound(6, 4));
  packed.resize(meshopt_encodeIndexSequence(packed.data(), packed.size(), indices.data(), 6));
  b.view(packed.data(), packed.size());
  mark_packed(b, "INDICES", "NONE", 6, 4, false);
  primitive(b)["indices"] = add_accessor(b, 5125, "SCALAR", 6, false);
  b.doc["buffers"] = {{{"byteLength", b.bin.size()}},
                      {{"byteLength", 24}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  EXPECT_EQ(load(b).mesh.indices, indices);
}

// The view of the packed positions with one member set to something else.
void expect_packed_refused(const char* member, const json& value, const std::string& fragment) {
  SCOPED_TRACE(fmt::format("{} = {}", member, value.dump()));
  const std::vector<uint8_t> glb = packed_card();
  const size_t json_size = glb[12] | size_t{glb[13]} << 8;
  json doc = json::parse(glb.begin() + 20, glb.begin() + 20 + long(json_size));
  doc["bufferViews"][10]["extensions"]["EXT_meshopt_compression"][member] = value;
  const std::vector<uint8_t> bin(glb.begin() + 28 + long(json_size), glb.end());
  EXPECT_NE(error_of(test::glb_of(doc.dump(), bin)).find(fragment), std::string::npos)
      << error_of(test::glb_of(doc.dump(), bin));
}

TEST(GltfMeshopt, EveryMemberIsChecked) {
  expect_packed_refused("mode", "POINTS", "mode: is POINTS");
  expect_packed_refused("filter", "SQUARE", "filter: is SQUARE");
  expect_packed_refused("filter", "QUATERNION", "do not go with");
  expect_packed_refused("mode", "TRIANGLES", "do not go with");
  expect_packed_refused("count", 4000000000U, "are not the view's byteLength of 48");
  expect_packed_refused("byteStride", 10, "do not go with");
  expect_packed_refused("byteLength", 4000000000U, "pass the end of its buffer");
  expect_packed_refused("byteOffset", 4000000000U, "pass the end of its buffer");
  expect_packed_refused("byteLength", 5, "does not decode");
  expect_packed_refused("buffer", 1, "pass the end of its buffer of 0 bytes");
  expect_packed_refused("buffer", 2, "buffer: is 2, but there are 2 buffers");
}

TEST(GltfMeshopt, ABombEndsAtTheLimit) {
  LoadOptions options = as_is();
  options.limits.decoded_bytes = 99;  // it decodes to 100
  const std::string error = error_of(packed_card(), options);
  EXPECT_NE(error.find("above the limit of 99"), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST(GltfMeshopt, MutatedBytesNeverDoMoreThanThrow) {
  const std::vector<uint8_t> glb = packed_card();
  size_t loaded = 0;
  for (uint64_t run = 0; run < 3000; ++run) {
    std::vector<uint8_t> bytes = glb;
    const size_t from = glb.size() / 2;  // data rather than JSON
    for (uint64_t c = 0; c <= random_below(2, run, 0, 4); ++c)
      bytes[from + random_below(2, run, 2 * c + 1, bytes.size() - from)] =
          static_cast<uint8_t>(random_bits(2, run, 2 * c + 2));
    try {
      load(bytes);
      ++loaded;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(loaded, 100U);
}

}  // namespace
}  // namespace crowdbench::scene
