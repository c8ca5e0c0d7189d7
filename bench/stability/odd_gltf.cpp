#include "bench/stability/odd_gltf.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

namespace crowdbench::bench {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

// All that the file holds; each odd one changes something.
struct Contents {
  std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0, 1};
  std::vector<uint8_t> joints = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
  std::vector<float> weights = {1, 0, 0, 0, 1, 0, 0, 0, 0.5F, 0.5F, 0, 0};
  std::vector<uint16_t> indices = {0, 1, 2};
  std::vector<float> bind = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                             1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::vector<float> times = {0, 1};
  std::vector<float> rotations = {0, 0, 0, 1, 0, 0, 0.70710678F, 0.70710678F};
  bool skin = true;
};

void append_word(std::vector<uint8_t>& out, size_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

// The buffer, with its views and accessors as JSON.
struct Buffer {
  std::vector<uint8_t> bytes;
  std::string views, accessors;
  int count = 0;

  template <typename T>
  int add(const std::vector<T>& values, int component, const char* type, size_t elements,
          const std::string& more = {}) {
    while (bytes.size() % 4 != 0) bytes.push_back(0);
    const char* comma = count > 0 ? "," : "";
    views += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", comma, bytes.size(),
                         values.size() * sizeof(T));
    accessors += fmt::format(R"({}{{"bufferView":{},"componentType":{},"type":"{}","count":{}{}}})", comma, count,
                             component, type, elements, more);
    const auto* data = reinterpret_cast<const uint8_t*>(values.data());
    bytes.insert(bytes.end(), data, data + values.size() * sizeof(T));
    return count++;
  }
};

std::vector<uint8_t> glb_of(const Contents& contents) {
  Buffer buffer;
  const int positions = buffer.add(contents.positions, 5126, "VEC3", 3, R"(,"min":[0,0,0],"max":[1,1,0])");
  const int indices = buffer.add(contents.indices, 5123, "SCALAR", 3);
  std::string attributes = fmt::format(R"("POSITION":{})", positions);
  if (!contents.normals.empty())
    attributes += fmt::format(R"(,"NORMAL":{})", buffer.add(contents.normals, 5126, "VEC3", 3));
  std::string skins;
  if (contents.skin) {
    const int joints = buffer.add(contents.joints, 5121, "VEC4", 3);
    const int weights = buffer.add(contents.weights, 5126, "VEC4", 3);
    const int bind = buffer.add(contents.bind, 5126, "MAT4", 2);
    attributes += fmt::format(R"(,"JOINTS_0":{},"WEIGHTS_0":{})", joints, weights);
    skins = fmt::format(R"("skins":[{{"joints":[1,2],"inverseBindMatrices":{}}}],)", bind);
  }
  const int times = buffer.add(contents.times, 5126, "SCALAR", contents.times.size(),
                               fmt::format(R"(,"min":[0],"max":[{}])", contents.times.size() > 1 ? 1 : 0));
  const int rotations = buffer.add(contents.rotations, 5126, "VEC4", contents.times.size());
  std::string json = fmt::format(R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],)"
                                 R"("nodes":[{{"mesh":0{}}},{{"name":"a","children":[2]}},{{"name":"b"}}],{})"
                                 R"("meshes":[{{"primitives":[{{"attributes":{{{}}},"indices":{}}}]}}],)"
                                 R"("animations":[{{"name":"turn","samplers":[{{"input":{},"output":{}}}],)"
                                 R"("channels":[{{"sampler":0,"target":{{"node":2,"path":"rotation"}}}}]}}],)"
                                 R"("bufferViews":[{}],"accessors":[{}],"buffers":[{{"byteLength":{}}}]}})",
                                 contents.skin ? R"(,"skin":0)" : "", skins, attributes, indices, times, rotations,
                                 buffer.views, buffer.accessors, buffer.bytes.size());
  while (json.size() % 4 != 0) json += ' ';
  while (buffer.bytes.size() % 4 != 0) buffer.bytes.push_back(0);
  std::vector<uint8_t> out;
  append_word(out, 0x46546C67);
  append_word(out, 2);
  append_word(out, 12 + 8 + json.size() + 8 + buffer.bytes.size());
  append_word(out, json.size());
  append_word(out, 0x4E4F534A);
  out.insert(out.end(), json.begin(), json.end());
  append_word(out, buffer.bytes.size());
  append_word(out, 0x004E4942);
  out.insert(out.end(), buffer.bytes.begin(), buffer.bytes.end());
  return out;
}

}  // namespace

std::vector<OddGltf> odd_gltfs() {
  std::vector<OddGltf> all;
  const auto add = [&](const char* name, bool refused, const std::function<void(Contents&)>& change) {
    Contents contents;
    change(contents);
    all.push_back({name, refused, glb_of(contents)});
  };
  add("as it should be", false, [](Contents&) {});
  add("weights that sum to 0", false, [](Contents& p) { p.weights.assign(12, 0.0F); });
  add("weights that sum to 0.1", false, [](Contents& p) { p.weights[8] = p.weights[9] = 0.05F; });
  add("weights that sum to 2", false, [](Contents& p) { p.weights[8] = p.weights[9] = 1; });
  add("a subnormal weight", false, [](Contents& p) { p.weights[9] = 1e-40F; });
  add("a weight that is NaN", true, [](Contents& p) { p.weights[9] = kNan; });
  add("an infinite weight", true, [](Contents& p) { p.weights[9] = kInfinite; });
  add("a negative weight", true, [](Contents& p) { p.weights[9] = -0.5F; });
  add("a joint out of range", true, [](Contents& p) { p.joints[9] = 7; });
  add("an index out of range", true, [](Contents& p) { p.indices[2] = 9; });
  add("a place that is NaN", true, [](Contents& p) { p.positions[4] = kNan; });
  add("an infinite place", true, [](Contents& p) { p.positions[4] = kInfinite; });
  add("a bind matrix that holds NaN", true, [](Contents& p) { p.bind[5] = kNan; });
  add("a time that is NaN", true, [](Contents& p) { p.times[1] = kNan; });
  add("a rotation that is NaN", true, [](Contents& p) { p.rotations[6] = kNan; });
  add("a clip of zero length", false, [](Contents& p) { p.times[1] = 0; });
  add("opposite quaternions", false, [](Contents& p) { p.rotations = {0, 0, 0, 1, 0, 0, 0, -1}; });
  add("one key", false, [](Contents& p) {
    p.times = {0};
    p.rotations.resize(4);
  });
  add("no normals", false, [](Contents& p) { p.normals.clear(); });
  add("no skin", false, [](Contents& p) { p.skin = false; });
  return all;
}

}  // namespace crowdbench::bench
