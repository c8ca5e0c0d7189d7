// Extensions of glTF: what is read, what is ignored, what is refused. Compressed data comes from the libraries' own
// encoders; what it must load as is the same card uncompressed.
#include <draco/compression/encode.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
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
  EXPECT_EQ(warnings_with(load(b), "gltf-transform uninstance"), 1U) << "what helps";
  b.doc["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {{"attributes", json::object()}};
  b.doc.erase("extensionsUsed");
  EXPECT_EQ(warnings_with(load(b), "EXT_mesh_gpu_instancing"), 1U) << "not said to be used";
}

TEST(GltfExtensions, VrmAndOthersMayBeRequired) {
  Builder b = bending_card();
  for (const char* name : {"VRM", "VRMC_vrm", "VRMC_springBone", "VRMC_materials_mtoon", "MSFT_lod",
                           "KHR_audio_emitter", "KHR_physics_rigid_bodies"}) {
    b.doc["extensionsUsed"] = {name};
    b.doc["extensionsRequired"] = {name};
    EXPECT_EQ(warnings_with(load(b), name), name == std::string("MSFT_lod") ? 0U : 1U) << name;
  }
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

TEST(GltfVisibility, HiddenNodesHaveNoSay) {
  Builder b = bending_card();
  const Character plain = load(b);
  // Far above the card, and below a node that is not shown.
  b.doc["nodes"].push_back({{"mesh", 0}, {"translation", {0, 100, 0}}});
  b.doc["nodes"].push_back({{"children", {3}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  b.doc["scenes"][0]["nodes"].push_back(4);
  b.doc["extensionsUsed"] = {"KHR_node_visibility"};
  const Character hidden = load(b);
  EXPECT_EQ(hidden.triangles(), plain.triangles());
  EXPECT_EQ(hidden.placement.height, plain.placement.height);
  EXPECT_TRUE(hidden.warnings.empty()) << hidden.warnings[0];
  b.doc["nodes"][4]["extensions"]["KHR_node_visibility"]["visible"] = true;
  EXPECT_EQ(load(b).triangles(), 2 * plain.triangles());
  b.doc["nodes"][4]["extensions"]["KHR_node_visibility"]["visible"] = 1;
  EXPECT_THROW(load(b), Error);
}

TEST(GltfMasks, AFigureThatIsCutAwayWhollyIsSaid) {
  Builder b = bending_card();
  b.doc["materials"] = {
      {{"alphaMode", "MASK"}, {"alphaCutoff", 0.9}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.7}}}}}};
  primitive(b)["material"] = 0;
  const Character c = load(b);
  ASSERT_EQ(c.warnings.size(), 1U);
  EXPECT_NE(c.warnings[0].find("nothing of it can be seen"), std::string::npos) << c.warnings[0];
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

// --- KHR_draco_mesh_compression ---

struct DracoCard {
  std::vector<uint8_t> bytes;
  json attributes;  // ids by name
};

// A grid of side x side quads over the card, as Draco's encoder writes it.
DracoCard draco_card(bool sequential, int side = 1) {
  const int row = side + 1;
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<uint32_t>(row * row));
  DracoCard out;
  const auto add = [&](const char* name, draco::GeometryAttribute::Type type, draco::DataType data, int components,
                       const auto& value_of) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, int8_t(components), data, false, components * draco::DataTypeLength(data), 0);
    const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
    for (int i = 0; i < row * row; ++i) {
      const auto value = value_of(float(i % row) / float(side), float(i / row) / float(side));
      mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(uint32_t(i)), value.data());
    }
    out.attributes[name] = mesh.attribute(id)->unique_id();
  };
  using Attribute = draco::GeometryAttribute;
  add("POSITION", Attribute::POSITION, draco::DT_FLOAT32, 3, [](float u, float v) {
    return std::array<float, 3>{u, 2 * v, 0};
  });
  add("NORMAL", Attribute::NORMAL, draco::DT_FLOAT32, 3, [](float, float) { return std::array<float, 3>{0, 0, 1}; });
  add("TEXCOORD_0", Attribute::TEX_COORD, draco::DT_FLOAT32, 2, [](float u, float v) {
    return std::array<float, 2>{u, 1 - v};
  });
  add("JOINTS_0", Attribute::GENERIC, draco::DT_UINT8, 4, [](float, float v) {
    return std::array<uint8_t, 4>{uint8_t(v > 0.5F), 0, 0, 0};
  });
  add("WEIGHTS_0", Attribute::GENERIC, draco::DT_FLOAT32, 4, [](float, float) {
    return std::array<float, 4>{1, 0, 0, 0};
  });
  for (int i = 0; i < side * side; ++i) {
    const auto a = uint32_t(i / side * row + i % side);
    const auto up = uint32_t(row);
    mesh.AddFace({draco::PointIndex(a), draco::PointIndex(a + 1), draco::PointIndex(a + up + 1)});
    mesh.AddFace({draco::PointIndex(a), draco::PointIndex(a + up + 1), draco::PointIndex(a + up)});
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(Attribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  out.bytes.assign(buffer.data(), buffer.data() + buffer.size());
  return out;
}

Builder with_draco(const DracoCard& card, size_t points = 4, size_t corners = 6) {
  Builder b = bending_card();
  const int view = b.view(card.bytes.data(), card.bytes.size());
  json& p = primitive(b);
  p["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", card.attributes}};
  for (const auto& [name, accessor] : p["attributes"].items()) {
    b.doc["accessors"][accessor.get<size_t>()].erase("bufferView");
    b.doc["accessors"][accessor.get<size_t>()]["count"] = points;
  }
  b.doc["accessors"][p["indices"].get<size_t>()].erase("bufferView");
  b.doc["accessors"][p["indices"].get<size_t>()]["count"] = corners;
  b.doc["extensionsUsed"] = b.doc["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return b;
}

class GltfDraco : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Methods, GltfDraco, testing::Bool(),
                         [](const auto& test) { return test.param ? "Sequential" : "Edgebreaker"; });

TEST_P(GltfDraco, CompressedCardIsTheCard) {
  Builder b = with_draco(draco_card(GetParam()));
  const Character c = load(b);
  EXPECT_TRUE(c.warnings.empty()) << c.warnings[0];
  ASSERT_EQ(c.mesh.positions.size(), 4U);
  ASSERT_EQ(c.triangles(), 2U);
  // The encoder may turn vertices and triangles around: each is where its texture coordinate says, on its joint.
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(c.mesh.positions[i].x, c.mesh.uvs[i].x, 1e-3);
    EXPECT_NEAR(c.mesh.positions[i].y, 2 * (1 - c.mesh.uvs[i].y), 1e-3);
    EXPECT_EQ(c.mesh.joints[i].x, c.mesh.uvs[i].y < 0.5F ? 1 : 0);
    EXPECT_NEAR(c.mesh.normals[i].z, 1.0F, 1e-3);
  }
  double area = 0;
  for (size_t t = 0; t < 6; t += 3) {
    const glm::vec3 a = c.mesh.positions[c.mesh.indices[t]];
    area += glm::cross(c.mesh.positions[c.mesh.indices[t + 1]] - a, c.mesh.positions[c.mesh.indices[t + 2]] - a).z / 2;
  }
  EXPECT_NEAR(area, 2.0, 1e-3);  // both counter-clockwise
}

TEST_P(GltfDraco, ABombEndsAtTheLimit) {
  const DracoCard card = draco_card(GetParam(), 40);  // 1681 vertices, 3200 triangles
  Builder b = with_draco(card, 1681, 9600);
  EXPECT_EQ(load(b).triangles(), 3200U);
  LoadOptions options = as_is();
  options.limits.triangles = 3199;
  EXPECT_NE(error_of(b.glb(), options).find("3200 triangles, more than the limits"), std::string::npos);
  options = as_is();
  options.limits.decoded_bytes = 50000;
  const std::string error = error_of(b.glb(), options);
  EXPECT_NE(error.find("more than the 50000 that are left"), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST_P(GltfDraco, MutatedBytesNeverDoMoreThanThrow) {
  const DracoCard card = draco_card(GetParam(), 4);
  size_t loaded = 0;
  for (uint64_t run = 0; run < 2000; ++run) {
    DracoCard changed = card;
    for (uint64_t c = 0; c <= random_below(3, run, 0, 3); ++c)
      changed.bytes[random_below(3, run, 2 * c + 1, card.bytes.size())] =
          static_cast<uint8_t>(random_bits(3, run, 2 * c + 2));
    try {
      Builder b = with_draco(changed, 25, 96);
      load(b);
      ++loaded;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(loaded, 20U);
}

TEST(GltfDracoMembers, AreChecked) {
  const DracoCard card = draco_card(false);
  const auto refused = [&](const char* pointer, const json& value) {
    Builder b = with_draco(card);
    b.doc[json::json_pointer(std::string("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression") + pointer)] =
        value;
    return error_of(b.glb());
  };
  EXPECT_NE(refused("/bufferView", 99).find("bufferView: is 99"), std::string::npos);
  EXPECT_NE(refused("/bufferView", 0).find("is not Draco data"), std::string::npos);
  EXPECT_NE(refused("/attributes/POSITION", 77).find("is 77, which is not an attribute"), std::string::npos);
  EXPECT_NE(refused("/attributes/TANGENT", 0).find("is not an attribute of the primitive"), std::string::npos);
}

// --- EXT_texture_webp ---

// One red pixel, lossless, as OpenImageIO writes it.
std::vector<uint8_t> red_webp() {
  return {0x52, 0x49, 0x46, 0x46, 0x16, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56, 0x50, 0x38,
          0x4c, 0x0a, 0x00, 0x00, 0x00, 0x2f, 0x00, 0x00, 0x00, 0x00, 0xc8, 0xfe, 0x47, 0xff, 0x03};
}

TEST(GltfWebp, IsPreferredToItsFallback) {
  Builder b = bending_card();
  const std::vector<uint8_t> webp = red_webp();
  b.doc["images"].push_back({{"bufferView", b.view(webp.data(), webp.size())}, {"mimeType", "image/webp"}});
  b.doc["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  b.doc["extensionsUsed"] = {"EXT_texture_webp"};
  const Character c = load(b);
  EXPECT_TRUE(c.warnings.empty());
  ASSERT_EQ(c.images.size(), 1U);
  ASSERT_EQ(c.images[0].image.data.size(), 4U);
  const std::vector<uint8_t> red = {255, 1, 0, 255};  // the encoder has its own idea of green
  EXPECT_EQ(c.images[0].image.data, red);
  b.doc["textures"][0].erase("source");
  b.doc["extensionsRequired"] = {"EXT_texture_webp"};
  EXPECT_EQ(load(b).images.size(), 1U);
  b.doc["bufferViews"].back()["byteLength"] = 26;
  EXPECT_FALSE(error_of(b.glb()).empty());
}

}  // namespace
}  // namespace crowdbench::scene
