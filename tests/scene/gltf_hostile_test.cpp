// Malformed and hostile files: each is refused by one line that names the fault, quickly and in little memory.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <limits>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "gltf_builder.h"
#include "scene/pose/pose.h"
#include "tests/support/sanitized.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;
using test::as_is;
using test::bending_card;
using test::Builder;
using test::load;
namespace fs = std::filesystem;

// More CPU time than this is a hang. Not wall time: a busy machine is no fault of the loader's.
constexpr double kMostSeconds = support::kSanitized ? 30.0 : 5.0;

// What f throws, or kNoError.
constexpr const char* kNoError = "no error";
template <typename F>
std::string error_of(F&& f) {
  const std::clock_t start = std::clock();
  std::string what = kNoError;
  try {
    f();
  } catch (const Error& e) {
    what = e.what();
  }
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, kMostSeconds);
  return what;
}

// The peak of this process so far; CTest runs each test in one of its own.
void expect_little_memory() {
  rusage usage{};
  ASSERT_EQ(::getrusage(RUSAGE_SELF, &usage), 0);
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(usage.ru_maxrss, 1 << 20) << "KiB";
#endif
}

void expect_refused(const std::vector<uint8_t>& bytes, const std::string& fragment) {
  const std::string what = error_of([&] { load(bytes, LoadOptions{}); });
  EXPECT_NE(what, kNoError);
  EXPECT_NE(what.find("; "), std::string::npos) << "no advice: " << what;
  EXPECT_NE(what.find(fragment), std::string::npos) << "expected: " << fragment << "\n     got: " << what;
  EXPECT_EQ(what.find('\n'), std::string::npos);
  expect_little_memory();
}

void expect_text_refused(const std::string& text, const std::string& fragment) {
  expect_refused({text.begin(), text.end()}, fragment);
}

// --- one member of the valid card set to something else ---

struct Mutation {
  const char* pointer;
  json value;  // discarded (json::value_t::discarded): the member is erased
  const char* fragment;
};

const json kErased = json(json::value_t::discarded);
const json kBig = 4294967295U;
const json kHuge = 18446744073709551615U;

std::vector<Mutation> mutations() {
  const json nan_text = "NaN";
  return {
      // the document
      {"/asset", kErased, "no asset"},
      {"/asset", json::array(), "/asset: is array"},
      {"/asset/version", kErased, "/asset: has no version"},
      {"/asset/version", "1.0", "/asset/version: is 1.0"},
      {"/asset/version", 2.0, "/asset/version: is number"},
      {"/asset/minVersion", "2.1", "/asset/minVersion: is 2.1"},
      {"/extensionsRequired", {"KHR_texture_basisu"}, "requires KHR_texture_basisu, which is not supported; save the"},
      {"/extensionsRequired",
       {"KHR_texture_basisu", "KHR_lights_punctual", "EXT_mesh_gpu_instancing", "ACME_x"},
       "requires ACME_x, EXT_mesh_gpu_instancing, KHR_texture_basisu, which are not supported; ACME_x: export the file "
       "without it; EXT_mesh_gpu_instancing: make one mesh of the instances (gltf-transform uninstance); "
       "KHR_texture_basisu: save the textures"},
      {"/extensionsRequired", {7}, "/extensionsRequired/0: is not a string"},
      {"/extensionsRequired", "KHR_materials_unlit", "/extensionsRequired: is string"},
      {"/accessors", json::object(), "/accessors: is object"},
      {"/accessors/0", 5, "/accessors/0: is number"},
      {"/nodes", nullptr, "/nodes: is null"},
      // buffers and views
      {"/buffers", kErased, "/bufferViews/0/buffer: is 0, but there are 0 buffers"},
      {"/buffers/0/byteLength", kErased, "/buffers/0: has no byteLength"},
      {"/buffers/0/byteLength", 0, "/buffers/0/byteLength: is 0"},
      {"/buffers/0/byteLength", -4, "/buffers/0/byteLength: is -4"},
      {"/buffers/0/byteLength", 1e300, "/buffers/0/byteLength: is 1e+300"},
      {"/buffers/0/byteLength", kBig, "/buffers/0/byteLength: is 4294967295"},
      {"/buffers/0/byteLength", 100000, "but its data has"},
      {"/buffers/0/byteLength", "12", "/buffers/0/byteLength: is string"},
      {"/buffers/0/uri", "", "/buffers/0/uri: is an empty uri"},
      {"/buffers/0/uri", 5, "/buffers/0/uri: is number"},
      {"/bufferViews/0/buffer", 1, "/bufferViews/0/buffer: is 1"},
      {"/bufferViews/0/buffer", -1, "/bufferViews/0/buffer: is -1"},
      {"/bufferViews/0/buffer", kErased, "/bufferViews/0: has no buffer"},
      {"/bufferViews/0/byteOffset", kHuge, "pass the end of its buffer"},
      {"/bufferViews/0/byteLength", kHuge, "pass the end of its buffer"},
      {"/bufferViews/0/byteLength", 0, "/bufferViews/0/byteLength: is 0"},
      {"/bufferViews/0/byteStride", 3, "/bufferViews/0/byteStride: is 3"},
      {"/bufferViews/0/byteStride", 6, "not a multiple of 4"},
      {"/bufferViews/0/byteStride", 256, "/bufferViews/0/byteStride: is 256"},
      {"/bufferViews/0/byteStride", 8, "overlap at a byteStride of 8"},
      // accessors
      {"/accessors/0/count", kErased, "/accessors/0: has no count"},
      {"/accessors/0/count", 0, "/accessors/0/count: is 0"},
      {"/accessors/0/count", kBig, "/accessors/0: data: 4294967295 elements"},
      {"/accessors/0/count", kHuge, "/accessors/0/count: is 18446744073709551615"},
      {"/accessors/0/count", 4.5, "/accessors/0/count: is 4.5"},
      {"/accessors/0/count", -4, "/accessors/0/count: is -4"},
      {"/accessors/0/count", {4}, "/accessors/0/count: is array"},
      {"/accessors/0/count", 5, "pass the end of a view"},
      {"/accessors/0/count", 3, "has 4 elements, POSITION has 3"},
      {"/accessors/0/byteOffset", 4, "pass the end of a view"},
      {"/accessors/0/byteOffset", 2, "not aligned to 4"},
      {"/accessors/0/byteOffset", kHuge, "/accessors/0: data at byte offset 18446744073709551615"},
      {"/accessors/0/byteOffset", 18446744073709551612U, "pass the end of a view"},
      {"/accessors/0/componentType", 5124, "/accessors/0/componentType: is 5124"},
      {"/accessors/0/componentType", 5123, "need KHR_mesh_quantization"},
      {"/accessors/0/componentType", kErased, "/accessors/0: has no componentType"},
      {"/accessors/0/type", "VEC5", "/accessors/0/type: is VEC5"},
      {"/accessors/0/type", "VEC2", "POSITION: names accessor 0 with 2 components"},
      {"/accessors/0/type", 3, "/accessors/0/type: is number"},
      {"/accessors/0/normalized", true, "cannot be normalised"},
      {"/accessors/0/normalized", "yes", "/accessors/0/normalized: is string"},
      {"/accessors/0/bufferView", 99, "/accessors/0/bufferView: is 99, but there are"},
      {"/accessors/0/bufferView", 2147483648U, "/accessors/0/bufferView: is 2147483648"},
      {"/accessors/3/componentType", 5126, "pass the end of a view"},
      {"/accessors/3/normalized", true, "JOINTS_0: names accessor 3 of normalised unsigned byte"},
      {"/accessors/5/componentType", 5126, "pass the end of a view"},
      {"/accessors/5/count", 5, "has 5 corners of triangles"},
      {"/accessors/5/bufferView", kErased, "indices: names an accessor without a bufferView"},
      {"/accessors/5/type", "VEC3", "pass the end of a view"},
      {"/accessors/6/count", 1, "has 1 matrices for 2 joints"},
      {"/accessors/6/type", "VEC4", "inverseBindMatrices: names accessor 6"},
      {"/accessors/7/count", 1, "output has 2 values, 1 keys need 1"},
      {"/accessors/8/type", "VEC3", "output: names accessor 8 with 3 components"},
      {"/accessors/0/sparse", 1, "/accessors/0/sparse: is number"},
      {"/accessors/0/sparse", {{"count", 1}}, "/accessors/0/sparse: has no indices"},
      {"/accessors/0/sparse", {{"count", 5}}, "/accessors/0/sparse/count: is 5, outside 1..4"},
      {"/accessors/0/sparse",
       {{"count", 2}, {"indices", {{"bufferView", 5}, {"componentType", 5126}}}, {"values", {{"bufferView", 0}}}},
       "sparse/indices/componentType: is not an unsigned"},
      {"/accessors/0/sparse",
       {{"count", 4}, {"indices", {{"bufferView", 5}, {"componentType", 5125}}}, {"values", {{"bufferView", 0}}}},
       "sparse/indices: indices: 4 elements"},
      {"/accessors/0/sparse",
       {{"count", 4}, {"indices", {{"bufferView", 5}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}},
       "sparse/indices: index 3 is 0, not above"},
      {"/accessors/0/sparse",
       {{"count", 2}, {"indices", {{"bufferView", 4}, {"componentType", 5123}}}, {"values", {{"bufferView", 5}}}},
       "sparse/values: values: 2 elements"},
      {"/accessors/0/sparse",
       {{"count", 1}, {"indices", {{"bufferView", 4}, {"componentType", 5125}}}, {"values", {{"bufferView", 0}}}},
       "/accessors/0/sparse/indices: index 0 is 1065353216, of 4 elements"},
      // meshes
      {"/meshes", kErased, "/nodes/0/mesh: is 0, but there are 0 meshes"},
      {"/meshes/0/primitives", kErased, "/meshes/0: has no primitives"},
      {"/meshes/0/primitives", json::array(), "/meshes/0: has no primitives"},
      {"/meshes/0/primitives/0", nullptr, "/meshes/0/primitives/0: is null"},
      {"/meshes/0/primitives/0/attributes", kErased, "has no attributes"},
      {"/meshes/0/primitives/0/attributes", {1, 2}, "attributes: is array"},
      {"/meshes/0/primitives/0/attributes/POSITION", kErased, "has no triangles"},
      {"/meshes/0/primitives/0/attributes/POSITION", 77, "POSITION: is 77, but there are 9 accessors"},
      {"/meshes/0/primitives/0/attributes/POSITION", "0", "POSITION: is string"},
      {"/meshes/0/primitives/0/attributes/_THING", 77, "_THING: is 77"},
      {"/meshes/0/primitives/0/attributes/JOINTS_0", kErased, "has 0 sets of joints and 1 of weights"},
      {"/meshes/0/primitives/0/attributes/JOINTS_0", 4, "JOINTS_0: names accessor 4 of float"},
      {"/meshes/0/primitives/0/attributes/WEIGHTS_0", 0, "WEIGHTS_0: names accessor 0 with 3 components"},
      {"/meshes/0/primitives/0/attributes/WEIGHTS_0", 5, "WEIGHTS_0: names accessor 5 with 1 components"},
      {"/meshes/0/primitives/0/attributes/WEIGHTS_0", 6, "WEIGHTS_0: names accessor 6 with 16"},
      {"/meshes/0/primitives/0/attributes/NORMAL", 2, "NORMAL: names accessor 2 with 2"},
      {"/meshes/0/primitives/0/attributes/COLOR_0", 3, "COLOR_0: names accessor 3 of unsigned byte"},
      {"/meshes/0/primitives/0/indices", 4, "indices: names accessor 4 with 4"},
      {"/meshes/0/primitives/0/indices", 7, "indices: names accessor 7 of float"},
      {"/meshes/0/primitives/0/indices", -1, "indices: is -1"},
      {"/meshes/0/primitives/0/mode", 7, "mode: is 7"},
      {"/meshes/0/primitives/0/mode", "TRIANGLES", "mode: is string"},
      {"/meshes/0/primitives/0/mode", 1, "has no triangles"},
      {"/meshes/0/primitives/0/material", 3, "material: is 3"},
      {"/meshes/0/primitives/0/targets", 3, "targets: is number"},
      // nodes and scenes
      {"/nodes/1/children", {1}, "its own child"},
      {"/nodes/1/children", {2, 2}, "node 2 has two parents"},
      {"/nodes/1/children", {9}, "/nodes/1/children/0: is 9"},
      {"/nodes/1/children", 2, "/nodes/1/children: is number"},
      {"/nodes/2/children", {1}, "belongs to a cycle"},
      {"/nodes/2/children", {0}, "/scenes/0/nodes/0: names node 0, which is a child"},
      {"/nodes/0/mesh", 1, "/nodes/0/mesh: is 1"},
      {"/nodes/0/skin", 1, "/nodes/0/skin: is 1"},
      {"/nodes/0/mesh", kErased, "has no triangles"},
      {"/nodes/1/rotation", {0, 0, 0, 0}, "/nodes/1/rotation: is a quaternion of length zero"},
      {"/nodes/1/rotation", {0, 0, 1}, "/nodes/1/rotation: has 3 numbers"},
      {"/nodes/1/scale", {1, 1, nullptr}, "/nodes/1/scale/2: is null"},
      {"/nodes/1/translation", {1e30, 0, 0}, "/nodes/1/translation/0: is 1e+30"},
      {"/nodes/1/translation", {nan_text, 0, 0}, "/nodes/1/translation/0: is string"},
      {"/nodes/1/matrix", {1, 2, 3}, "/nodes/1/matrix: has 3 numbers"},
      {"/nodes/1/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "/nodes/1/matrix: is not affine"},
      {"/nodes/2/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "has both a matrix and"},
      {"/nodes/1/name", 5, "/nodes/1/name: is number"},
      {"/scene", 1, "/scene: is 1, but there are 1 scenes"},
      {"/scene", -1, "/scene: is -1"},
      {"/scenes/0/nodes", {0, 0}, "/scenes/0/nodes/1: names node 0 twice"},
      {"/scenes/0/nodes", {7}, "/scenes/0/nodes/0: is 7"},
      {"/scenes/0/nodes", json::array(), "has no triangles"},
      {"/scenes/0/nodes", {2}, "names node 2, which is a child of node 1"},
      // skins
      {"/skins/0/joints", kErased, "/skins/0: has no joints"},
      {"/skins/0/joints", json::array(), "/skins/0: has no joints"},
      {"/skins/0/joints", {1, 40}, "/skins/0/joints/1: is 40, but there are 3 nodes"},
      {"/skins/0/joints", {1, 1}, "names node 1 twice"},
      {"/skins/0/joints", {1}, "vertex 2 names joint 1, its skin has 1"},
      {"/skins/0/skeleton", 40, "/skins/0/skeleton: is 40"},
      {"/skins/0/inverseBindMatrices", 4, "inverseBindMatrices: names accessor 4"},
      {"/skins/0/inverseBindMatrices", 99, "inverseBindMatrices: is 99"},
      // animations
      {"/animations/0/channels", kErased, "/animations/0: has no channels"},
      {"/animations/0/samplers", 3, "/animations/0/samplers: is number"},
      {"/animations/0/samplers/0/input", kErased, "/animations/0/samplers/0: has no input"},
      {"/animations/0/samplers/0/input", 99, "input: is 99"},
      {"/animations/0/samplers/0/input", 5, "input: names accessor 5 of unsigned short"},
      {"/animations/0/samplers/0/output", 7, "output: names accessor 7 with 1"},
      {"/animations/0/samplers/0/interpolation", "BEZIER", "interpolation: is BEZIER"},
      {"/animations/0/samplers/0/interpolation", "CUBICSPLINE", "output has 2 values, 2 keys need 6"},
      {"/animations/0/channels/0/sampler", 1, "/animations/0/channels/0/sampler: is 1"},
      {"/animations/0/channels/0/target", kErased, "has no target"},
      {"/animations/0/channels/0/target/path", "spin", "path: is spin"},
      {"/animations/0/channels/0/target/path", kErased, "target: has no path"},
      {"/animations/0/channels/0/target/node", 12, "node: is 12"},
      {"/animations/0/channels/1", {{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}, "second channel"},
      // materials, textures, pictures
      {"/materials/0/pbrMetallicRoughness", 1, "pbrMetallicRoughness: is number"},
      {"/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 1, 1}, "baseColorFactor: has 3 numbers"},
      {"/materials/0/pbrMetallicRoughness/baseColorTexture/index", 4, "baseColorTexture/index: is 4"},
      {"/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord", kBig, "texCoord: is 4294967295"},
      {"/materials/0/pbrMetallicRoughness/baseColorTexture/extensions",
       {{"KHR_texture_transform", {{"scale", {1}}}}},
       "scale: has 1 numbers"},
      {"/materials/0/doubleSided", 1, "doubleSided: is number"},
      {"/materials/0/alphaMode", "GLASS", "alphaMode: is GLASS"},
      {"/materials/0/extensions", 1, "extensions: is number"},
      {"/materials/0/emissiveFactor", "red", "emissiveFactor: is string"},
      {"/textures/0/source", 3, "/textures/0/source: is 3"},
      {"/textures/0/sampler", 3, "/textures/0/sampler: is 3"},
      {"/samplers/0/wrapS", 1, "/samplers/0/wrapS: is 1"},
      {"/samplers/0/magFilter", 9984, "/samplers/0/magFilter: is 9984"},
      {"/images/0/bufferView", kErased, "/images/0: has neither"},
      {"/images/0/bufferView", 88, "/images/0/bufferView: is 88"},
      {"/images/0/bufferView", 0, "neither PNG nor JPEG"},
      {"/images/0/uri", "a.png", "has both a uri and a bufferView"},
      {"/bufferViews/9/byteLength", 60, "PNG does not decode"},
      {"/bufferViews/9/byteLength", 20, "PNG has no header"},
  };
}

TEST(GltfHostile, EveryMutationIsRefusedByName) {
  for (const Mutation& m : mutations()) {
    SCOPED_TRACE(fmt::format("{} = {}", m.pointer, m.value.dump().substr(0, 80)));
    Builder b = bending_card();
    b.set_buffer();
    const json::json_pointer pointer(m.pointer);
    if (m.value.is_discarded())
      b.doc[pointer.parent_pointer()].erase(pointer.back());
    else
      b.doc[pointer] = m.value;
    expect_refused(test::glb_of(b.doc.dump(), b.bin), m.fragment);
  }
}

// --- numbers in the data ---

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

void with_floats(const char* pointer, const std::vector<float>& data, const char* type, const char* fragment) {
  SCOPED_TRACE(fragment);
  Builder b = bending_card();
  b.doc[json::json_pointer(pointer)] = b.accessor<float>(data, type);
  expect_refused(b.glb(), fragment);
}

TEST(GltfHostile, NumbersThatAreNotFiniteOrNotInOrder) {
  const char* attributes = "/meshes/0/primitives/0/attributes/";
  const auto attribute = [&](const char* name) { return std::string(attributes) + name; };
  with_floats(attribute("POSITION").c_str(), {0, 0, 0, 1, kNan, 0, 1, 2, 0, 0, 2, 0}, "VEC3", "element 1 holds nan");
  with_floats(attribute("POSITION").c_str(), {0, 0, 0, 1, 0, 0, 1, kInf, 0, 0, 2, 0}, "VEC3", "element 2 holds inf");
  with_floats(attribute("POSITION").c_str(), {0, 0, 0, 1, 0, 0, 1, 1e30F, 0, 0, 2, 0}, "VEC3", "element 2 holds 1e+30");
  with_floats(attribute("NORMAL").c_str(), {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, kNan}, "VEC3", "element 3 holds nan");
  with_floats(attribute("TEXCOORD_0").c_str(), {0, 0, 0, 0, 0, 0, 0, kInf}, "VEC2", "element 3 holds inf");
  with_floats(attribute("WEIGHTS_0").c_str(), {1, 0, 0, 0, 1, kNan, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4",
              "the weight of vertex 1 is nan");
  with_floats(attribute("WEIGHTS_0").c_str(), {1, 0, 0, 0, 1, -.5F, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4",
              "the weight of vertex 1 is -0.5");
  with_floats("/animations/0/samplers/0/input", {0, kNan}, "SCALAR", "element 1 holds nan");
  with_floats("/animations/0/samplers/0/input", {1, 0.5F}, "SCALAR", "is before key 0");
  with_floats("/animations/0/samplers/0/input", {-4000, 0.5F}, "SCALAR", "before 0");
  with_floats("/animations/0/samplers/0/input", {0, 1e6F}, "SCALAR", "the limit is 3600");
  with_floats("/animations/0/samplers/0/output", {0, 0, 0, 1, 0, 0, 0, 0}, "VEC4", "quaternion of length zero");
  with_floats("/animations/0/samplers/0/output", {0, 0, 0, 1, 0, 0, 0, kInf}, "VEC4", "element 1 holds inf");
  std::vector<float> binds(32, 0.0F);
  for (const size_t i : {0, 5, 10, 15, 16, 21, 26, 31, 3}) binds[i] = 1.0F;
  with_floats("/skins/0/inverseBindMatrices", binds, "MAT4", "is not affine");
  binds[7] = kNan;
  with_floats("/skins/0/inverseBindMatrices", binds, "MAT4", "element 0 holds nan");
}

TEST(GltfHostile, IndexPastTheVertices) {
  Builder b = bending_card();
  b.doc["meshes"][0]["primitives"][0]["indices"] = b.accessor<uint16_t>({0, 1, 4}, "SCALAR");
  expect_refused(b.glb(), "index 2 is 4, but /meshes/0/primitives/0 has 4 vertices");
  b.doc["meshes"][0]["primitives"][0]["indices"] = b.accessor<uint32_t>({0, 4294967295U, 1}, "SCALAR");
  expect_refused(b.glb(), "index 1 is 4294967295");
  b.doc["meshes"][0]["primitives"][0]["indices"] = b.accessor<uint16_t>({0, 1, 2, 65535, 0, 2, 3}, "SCALAR");
  b.doc["meshes"][0]["primitives"][0]["mode"] = 5;
  expect_refused(b.glb(), "strips do not restart at the largest index: export triangles");
}

TEST(GltfHostile, ASceneThatShowsNothingBesideOneThatDoes) {
  Builder b = bending_card();
  b.doc["scenes"] = {{{"nodes", json::array()}}, {{"nodes", {0, 1}}}};
  expect_refused(b.glb(), "others have some: make one of these its `scene`");
  b.doc["scene"] = 1;
  EXPECT_EQ(load(b).triangles(), 2U);
}

// --- containers and JSON ---

TEST(GltfHostile, Containers) {
  Builder b = bending_card();
  const std::vector<uint8_t> good = b.glb();
  expect_refused({}, "is empty");
  expect_text_refused("hello", "neither a GLB container nor a JSON object");
  expect_text_refused("[]", "neither a GLB container nor a JSON object");
  expect_text_refused("glTF", "header is cut short");
  expect_refused({good.begin(), good.begin() + 11}, "header is cut short");
  expect_refused({good.begin(), good.begin() + 40}, "GLB header says");
  const auto patched = [&](size_t at, uint32_t value) {
    std::vector<uint8_t> bytes = good;
    std::memcpy(bytes.data() + at, &value, 4);
    return bytes;
  };
  expect_refused(patched(4, 1), "version is 1");
  expect_refused(patched(4, 3), "version is 3");
  expect_refused(patched(8, 0xFFFFFFFF), "GLB header says 4294967295");
  expect_refused(patched(8, 4), "GLB header says 4 bytes");
  expect_refused(patched(8, 12), "no JSON chunk");
  expect_refused(patched(8, 16), "chunk header at byte 12 is cut short");
  expect_refused(patched(12, 0xFFFFFFFC), "chunk at byte 12 says 4294967292");
  expect_refused(patched(12, 21), "not a multiple of 4");
  expect_refused(patched(16, 0x004E4942), "first GLB chunk is not JSON");
  std::vector<uint8_t> twice = good;
  std::vector<uint8_t> chunk;
  test::append_u32(chunk, 4);
  test::append_u32(chunk, 0x004E4942);
  test::append_u32(chunk, 0);
  twice.insert(twice.end(), chunk.begin(), chunk.end());
  const auto size = static_cast<uint32_t>(twice.size());
  std::memcpy(twice.data() + 8, &size, 4);
  expect_refused(twice, "second BIN chunk");
  expect_refused(test::glb_of(b.doc.dump(), {}), "no BIN chunk");
  std::vector<uint8_t> cut(good.begin(), good.end() - 200);
  const auto cut_size = static_cast<uint32_t>(cut.size());
  std::memcpy(cut.data() + 8, &cut_size, 4);
  expect_refused(cut, "284 are left");
}

TEST(GltfHostile, EveryPrefixIsRefused) {
  Builder b = bending_card();
  const std::vector<uint8_t> good = b.glb();
  for (size_t n = 0; n < good.size(); n += 7)
    EXPECT_NE(error_of([&] { load({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n)}); }), kNoError) << n;
}

TEST(GltfHostile, Json) {
  expect_text_refused("{", "JSON does not parse");
  expect_text_refused("{} x", "JSON does not parse");
  expect_text_refused("{}", "has no asset");
  expect_text_refused(R"({"asset":{"version":"2.0"},"asset":{"version":"2.0"}})", "member asset twice");
  expect_text_refused(R"({"asset":{"version":"2.0","version":"1.0"}})", "member version twice");
  expect_text_refused("{\"asset\":{\"version\":\"2.\xff\"}}", "JSON does not parse");
  expect_text_refused(R"({"asset":{"version":"2.0"},"scene":1e999})", "JSON does not parse");
  expect_text_refused(R"({"asset":{"version":"2.0"}})", "has no triangles");
  expect_text_refused(std::string("{\"asset\"\0:{}}", 12), "NUL byte");
  const std::string deep = std::string(100000, '[');
  expect_text_refused("{\"extras\":" + deep, "nests deeper than 64");
  expect_text_refused("{\"extras\":" + deep + std::string(100000, ']') + "}", "nests deeper than 64");
  std::string objects = "{\"a\":";
  for (int i = 0; i < 200; ++i) objects += "{\"a\":";
  expect_text_refused(objects, "nests deeper than 64");
  std::string wide = "{\"extras\":[0";
  for (int i = 0; i < 1'100'000; ++i) wide += ",0";
  expect_text_refused(wide + "]}", "more than 1000000 values");
  // Within the limit, and quick: no step may be quadratic in the length of an array or an object.
  std::string objects_in_a_row = R"({"asset":{"version":"2.0"},"extras":[{"a":0})";
  for (int i = 0; i < 300'000; ++i) objects_in_a_row += R"(,{"a":0})";
  expect_text_refused(objects_in_a_row + "]}", "has no triangles");
  std::string members = R"({"asset":{"version":"2.0"},"extras":{"a":0)";
  for (int i = 0; i < 450'000; ++i) members += fmt::format(R"(,"{}":0)", i);
  expect_text_refused(members + "}}", "has no triangles");
}

// --- uris ---

struct Folder {
  fs::path path = fs::temp_directory_path() / fmt::format("crowdbench-hostile-{}", ::getpid());
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path / "asset/sub");
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

TEST(GltfHostile, UrisThatLeaveTheFolder) {
  Folder folder;
  Builder b = bending_card();
  b.set_buffer();
  // Each of these exists, so that a loader that followed it would succeed.
  for (const char* name : {"outside.bin", "asset/inside.bin"})
    write_file(folder.path / name, b.bin.data(), b.bin.size());
  fs::create_symlink("../outside.bin", folder.path / "asset/link.bin");
  fs::create_directory_symlink("..", folder.path / "asset/up");
  ASSERT_EQ(::mkfifo((folder.path / "asset/pipe.bin").c_str(), 0600), 0);
  const auto result = [&](const std::string& uri) {
    const std::vector<uint8_t> text = b.gltf(uri);
    write_file(folder.path / "asset/card.gltf", text.data(), text.size());
    return error_of([&] { load_character(folder.path / "asset/card.gltf"); });
  };
  EXPECT_EQ(result("inside.bin"), kNoError);
  EXPECT_NE(result("./sub/.././inside.bin").find("leaves the asset's folder"), std::string::npos)
      << "parents are refused even within";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"../outside.bin", "leaves the asset's folder"},
      {"sub/../../outside.bin", "leaves the asset's folder"},
      {"%2e%2e/outside.bin", "leaves the asset's folder"},
      {"%2E%2E%2Foutside.bin", "leaves the asset's folder"},
      {"..%2foutside.bin", "leaves the asset's folder"},
      {"..\\outside.bin", "backslash"},
      {"..%5Coutside.bin", "backslash"},
      {(folder.path / "outside.bin").string(), "absolute path"},
      {"%2Fetc%2Fpasswd", "absolute path"},
      {"file://" + (folder.path / "outside.bin").string(), "not a relative path"},
      {"file:inside.bin", "not a relative path"},
      {"http://example.com/inside.bin", "not a relative path"},
      {"http%3A//example.com/inside.bin", "not a relative path"},
      {"C:/inside.bin", "not a relative path"},
      {"link.bin", "through a link"},
      {"up/outside.bin", "through a link"},
      {"sub", "is not a regular file"},
      {".", "is not a regular file"},
      {"pipe.bin", "is not a regular file"},
      {"missing.bin", "cannot open missing.bin"},
      {"inside.bin%00.png", "control character"},
      {"inside.bin?x=1", "query"},
      {"inside%zz.bin", "broken percent escape"},
      {"inside%2", "broken percent escape"},
      {"data:application/octet-stream,abc", "data uri without base64"},
      {"data:application/octet-stream;base64", "data uri without base64"},
      {"data:;base64,abc!", "broken base64"},
      {"data:;base64,AAAAA", "broken base64"},
      {"data:;base64,AAAA", "but its data has 3 bytes"},
      {std::string(10000, 'a'), "cannot open"},
  };
  for (const auto& [uri, fragment] : cases) {
    const std::string what = result(uri);
    EXPECT_NE(what.find(fragment), std::string::npos) << uri << "\n" << what;
    EXPECT_NE(what.find("/buffers/0"), std::string::npos) << what;
  }
}

TEST(GltfHostile, PictureUrisAreCheckedEvenIfUnused) {
  Builder b = bending_card();
  b.doc["images"].push_back({{"uri", "../../secret.png"}});
  expect_refused(b.glb(), "/images/1/uri: leaves the asset's folder");
  b.doc["images"][1]["uri"] = "normal-map.png";
  EXPECT_EQ(load(b).images.size(), 1U) << "a picture that nothing shows is not fetched";
}

TEST(GltfHostile, NothingIsReadWithoutAFolder) {
  Builder b = bending_card();
  expect_refused(b.gltf("card.bin"), "cannot be read without a folder");
}

TEST(GltfHostile, WhatIsNotAFile) {
  Folder folder;
  EXPECT_NE(error_of([&] { load_character(folder.path); }).find("not a regular file"), std::string::npos);
  EXPECT_NE(error_of([&] { load_character(folder.path / "none.glb"); }).find("cannot open"), std::string::npos);
  EXPECT_NE(error_of([&] { load_character("/dev/zero"); }).find("not a regular file"), std::string::npos);
  EXPECT_NE(error_of([&] { load_character(""); }), kNoError);
}

// --- limits ---

TEST(GltfHostile, AMeshOnManyNodes) {
  Builder b = bending_card();
  b.doc["meshes"][0]["primitives"] = json(500, b.doc["meshes"][0]["primitives"][0]);
  for (int i = 0; i < 20000; ++i) {
    b.doc["nodes"].push_back({{"mesh", 0}, {"skin", 0}});
    b.doc["scenes"][0]["nodes"].push_back(3 + i);
  }
  expect_refused(b.glb(), "primitives, the limit is 65536");
}

TEST(GltfHostile, ManyVerticesWithoutData) {
  Builder b = bending_card();
  b.doc["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 3'000'000'000U}});
  b.doc["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 9}}}};
  b.doc["nodes"][0].erase("skin");
  expect_refused(b.glb(), "3000000000 vertices, the limit is 2000000");
  // The picture of this limit from below: a million vertices without data are allowed and cost little.
  b.doc["accessors"][9]["count"] = 999999;
  EXPECT_EQ(load(b).triangles(), 333333U);
}

TEST(GltfHostile, ManyJoints) {
  Builder b = bending_card();
  for (int i = 0; i < 1100; ++i) {
    b.doc["nodes"].push_back({{"mesh", 0}});
    b.doc["scenes"][0]["nodes"].push_back(3 + i);
  }
  expect_refused(b.glb(), "joints and rigid meshes, the limit is 1024");
}

TEST(GltfHostile, ManyNodesDeepBelowEachOther) {
  Builder b = bending_card();
  for (int i = 0; i < 60000; ++i) {
    b.doc["nodes"].push_back(json::object());
    b.doc["nodes"][static_cast<size_t>(2 + i)]["children"] = {3 + i};
  }
  EXPECT_EQ(load(b).triangles(), 2U);
  for (int i = 0; i < 6000; ++i) b.doc["nodes"].push_back(json::object());
  expect_refused(b.glb(), "more than the limit of 65536");
}

TEST(GltfHostile, ManyKeys) {
  Builder b = bending_card();
  b.doc["accessors"].push_back({{"componentType", 5126}, {"type", "SCALAR"}, {"count", 3'000'000}});
  b.doc["accessors"].push_back({{"componentType", 5126}, {"type", "VEC4"}, {"count", 3'000'000}});
  b.doc["animations"][0]["samplers"][0] = {{"input", 9}, {"output", 10}};
  expect_refused(b.glb(), "numbers, the limit is 10000000");
}

TEST(GltfHostile, ManyClipsOfManyNodes) {
  Builder b = bending_card();
  b.doc["animations"] = json(4000, b.doc["animations"][0]);
  for (int i = 0; i < 2000; ++i) b.doc["nodes"].push_back(json::object());
  expect_refused(b.glb(), "4000 clips of 2003 nodes");
  b.doc["animations"] = json(5000, b.doc["animations"][0]);
  expect_refused(b.glb(), "has 5000 clips, the limit is 4096");
}

TEST(GltfHostile, TransformsThatOverflow) {
  Builder b = bending_card();
  for (int i = 0; i < 60; ++i) {
    b.doc["nodes"].push_back({{"scale", {1e8, 1e8, 1e8}}});
    b.doc["nodes"][static_cast<size_t>(2 + i)]["children"] = {3 + i};
  }
  b.doc["skins"][0]["joints"] = {1, 62};
  expect_refused(b.glb(), "/nodes/4: lies beyond");
  b = bending_card();
  b.doc["animations"][0]["samplers"][0]["output"] = b.accessor<float>({1e8F, 1, 1, 1, 1e8F, 1}, "VEC3");
  b.doc["animations"][0]["channels"][0]["target"]["path"] = "scale";
  b.doc["nodes"][1]["scale"] = {1e8, 1, 1};
  expect_refused(b.glb(), "/nodes/2: lies beyond");
}

std::vector<uint8_t> png_claiming(uint32_t width, uint32_t height) {
  std::vector<uint8_t> png = test::small_png();
  for (int i = 0; i < 4; ++i) {
    png[static_cast<size_t>(16 + i)] = static_cast<uint8_t>(width >> (24 - 8 * i));
    png[static_cast<size_t>(20 + i)] = static_cast<uint8_t>(height >> (24 - 8 * i));
  }
  return png;
}

void with_picture(const std::vector<uint8_t>& bytes, const char* fragment) {
  Builder b = bending_card();
  b.doc["images"][0]["bufferView"] = b.view(bytes.data(), bytes.size());
  expect_refused(b.glb(), fragment);
}

TEST(GltfHostile, Pictures) {
  with_picture(png_claiming(9000, 2), "picture is 9000 x 2, the limit is 8192 a side");
  with_picture(png_claiming(0, 2), "claims to be 0 x 2");
  with_picture(png_claiming(0xFFFFFFFF, 0xFFFFFFFF), "claims to be");
  with_picture(png_claiming(3, 3), "PNG does not decode");
  // The header of a JPEG of 8192 x 8192.
  with_picture({0xFF, 0xD8, 0xFF, 0xC0, 0, 17, 8, 0x20, 0, 0x20, 0, 3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0},
               "the limit for JPEG");
  with_picture({0xFF, 0xD8, 0xFF, 0xC0, 0, 17, 8, 0, 8, 0, 8, 3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0},
               "JPEG does not decode");
  with_picture({0xFF, 0xD8, 0xFF, 0xE0, 0, 2}, "JPEG has no frame header");
  with_picture({'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P'}, "WebP");
  with_picture({0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB}, "KTX2");
  // Four textures of one picture with different wrap modes are four pictures in memory.
  Builder b = bending_card();
  const std::vector<uint8_t> large = png_claiming(8192, 4096);
  b.doc["images"][0]["bufferView"] = b.view(large.data(), large.size());
  LoadOptions options = as_is();
  options.limits.image_bytes = 100'000'000;
  const std::string what = error_of([&] { load(b, options); });
  EXPECT_NE(what.find("brings all textures above 100000000 bytes"), std::string::npos) << what;
}

TEST(GltfHostile, FileLargerThanTheLimit) {
  Builder b = bending_card();
  LoadOptions options = as_is();
  options.limits.file_bytes = 500;
  EXPECT_NE(error_of([&] { load(b, options); }).find("more than the limit of 500"), std::string::npos);
  options.limits.file_bytes = b.glb().size();
  options.limits.json_bytes = 100;
  EXPECT_NE(error_of([&] { load(b, options); }).find("more than the limit of 100"), std::string::npos);
}

// --- a small deterministic fuzzer; the libFuzzer target goes further ---

TEST(GltfHostile, MutatedBytesNeverDoMoreThanThrow) {
  Builder b = bending_card();
  const std::vector<uint8_t> glb = b.glb();
  const std::vector<uint8_t> gltf = b.gltf();
  size_t loaded = 0;
  size_t refused = 0;
  constexpr uint64_t kRuns = 6000;
  for (uint64_t run = 0; run < kRuns; ++run) {
    std::vector<uint8_t> bytes = run % 3 == 0 ? gltf : glb;
    const uint64_t changes = 1 + random_below(1, run, 0, 4);
    for (uint64_t c = 0; c < changes; ++c) {
      const uint64_t purpose = 10 * (c + 1);
      const size_t at = random_below(1, run, purpose, bytes.size());
      switch (random_below(1, run, purpose + 1, 5)) {
        case 0: bytes[at] = static_cast<uint8_t>(random_bits(1, run, purpose + 2)); break;
        case 1: bytes[at] ^= static_cast<uint8_t>(1U << random_below(1, run, purpose + 2, 8)); break;
        case 2: bytes[at] = "0123456789-eE.\"[]{},:"[random_below(1, run, purpose + 2, 21)]; break;
        case 3: bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at)); break;
        default: bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes[at]); break;
      }
    }
    try {
      const Character character = load(bytes, LoadOptions{});
      // What loads is sound: every pose is finite.
      for (const glm::dvec3& p :
           skin_positions(character.mesh, model_matrices(character, character.placement.default_clip, 0.3)))
        ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) << "run " << run;
      ++loaded;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_EQ(loaded + refused, kRuns);
  EXPECT_GT(loaded, 100U);
  EXPECT_GT(refused, 100U);
}

}  // namespace
}  // namespace crowdbench::scene
