// Small glTF files made by test code.
#pragma once
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/image_io.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::scene::test {

inline void append_u32(std::vector<uint8_t>& out, size_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

inline std::string base64(const std::vector<uint8_t>& bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

inline std::vector<uint8_t> glb_of(std::string json, std::vector<uint8_t> bin) {
  while (json.size() % 4 != 0) json += ' ';
  while (bin.size() % 4 != 0) bin.push_back(0);
  std::vector<uint8_t> out;
  append_u32(out, 0x46546C67);
  append_u32(out, 2);
  append_u32(out, 12 + 8 + json.size() + (bin.empty() ? 0 : 8 + bin.size()));
  append_u32(out, json.size());
  append_u32(out, 0x4E4F534A);
  out.insert(out.end(), json.begin(), json.end());
  if (bin.empty()) return out;
  append_u32(out, bin.size());
  append_u32(out, 0x004E4942);
  out.insert(out.end(), bin.begin(), bin.end());
  return out;
}

struct Builder {
  nlohmann::json doc = {{"asset", {{"version", "2.0"}}}};
  std::vector<uint8_t> bin;

  int view(const void* data, size_t size, size_t stride = 0) {
    doc.erase("buffers");  // made anew by glb()
    while (bin.size() % 4 != 0) bin.push_back(0);
    nlohmann::json v = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", size}};
    if (stride != 0) v["byteStride"] = stride;
    const auto* bytes = static_cast<const uint8_t*>(data);
    bin.insert(bin.end(), bytes, bytes + size);
    doc["bufferViews"].push_back(v);
    return static_cast<int>(doc["bufferViews"].size()) - 1;
  }

  template <typename T>
  static int component_type() {
    if (std::is_same_v<T, int8_t>) return 5120;
    if (std::is_same_v<T, uint8_t>) return 5121;
    if (std::is_same_v<T, int16_t>) return 5122;
    if (std::is_same_v<T, uint16_t>) return 5123;
    if (std::is_same_v<T, uint32_t>) return 5125;
    return 5126;
  }

  template <typename T>
  int accessor(const std::vector<T>& data, const std::string& type, bool normalized = false) {
    const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<size_t>(type[3] - '0');
    const size_t element = components * sizeof(T);
    // Vertex data steps by multiples of four bytes.
    const bool pad = element % 4 != 0 && type != "SCALAR";
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < data.size(); i += components) {
      const auto* p = reinterpret_cast<const uint8_t*>(&data[i]);
      bytes.insert(bytes.end(), p, p + element);
      while (pad && bytes.size() % 4 != 0) bytes.push_back(0);
    }
    nlohmann::json a = {{"bufferView", view(bytes.data(), bytes.size(), pad ? (element + 3) / 4 * 4 : 0)},
                        {"componentType", component_type<T>()},
                        {"count", data.size() / components},
                        {"type", type}};
    if (normalized) a["normalized"] = true;
    doc["accessors"].push_back(a);
    return static_cast<int>(doc["accessors"].size()) - 1;
  }

  void set_buffer() { doc["buffers"] = nlohmann::json::array({{{"byteLength", bin.size()}}}); }
  std::vector<uint8_t> glb() {
    if (!doc.contains("buffers") && !bin.empty()) set_buffer();
    return glb_of(doc.dump(), bin);
  }
  std::vector<uint8_t> gltf(const std::string& uri = {}) {
    set_buffer();
    doc["buffers"][0]["uri"] = uri.empty() ? "data:application/octet-stream;base64," + base64(bin) : uri;
    const std::string text = doc.dump();
    return {text.begin(), text.end()};
  }
};

inline std::vector<uint8_t> small_png() {
  Image8 image(2, 2, 4);
  for (size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<uint8_t>(i % 4 == 3 ? 255 : 40 * (i / 4) + i % 4);
  return encode_png(image);
}

// A card of 1 x 2 units in the plane z = 0 that bends about z at half its height: joint "hips" at the origin holds the
// lower edge, its child "arm" at (0, 1, 0) the upper. The clip "wave" turns the arm by 90 degrees about z from 0 s to
// 1 s, so that (0, 2, 0) goes to (-1, 1, 0).
// Nodes: 0 "body" (mesh 0, skin 0), 1 "hips", 2 "arm". Accessors: 0 POSITION, 1 NORMAL, 2 TEXCOORD_0, 3 JOINTS_0,
// 4 WEIGHTS_0, 5 indices, 6 inverse bind matrices, 7 times, 8 rotations; the picture's bytes are in view 9.
inline Builder bending_card() {
  Builder b;
  const int position = b.accessor<float>({0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0}, "VEC3");
  const int normal = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const int uv = b.accessor<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2");
  const int joints = b.accessor<uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const int weights = b.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const int indices = b.accessor<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  const int binds = b.accessor<float>(
      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}, "MAT4");
  const int times = b.accessor<float>({0, 1}, "SCALAR");
  const float h = 0.70710678F;
  const int turns = b.accessor<float>({0, 0, 0, 1, 0, 0, h, h}, "VEC4");
  const std::vector<uint8_t> png = small_png();
  const int picture = b.view(png.data(), png.size());
  b.doc["images"] = {{{"bufferView", picture}, {"mimeType", "image/png"}}};
  b.doc["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  b.doc["textures"] = {{{"source", 0}, {"sampler", 0}}};
  b.doc["materials"] = {
      {{"name", "cloth"},
       {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 1}}, {"baseColorTexture", {{"index", 0}}}}}}};
  b.doc["meshes"] = {{{"primitives",
                       {{{"attributes",
                          {{"POSITION", position},
                           {"NORMAL", normal},
                           {"TEXCOORD_0", uv},
                           {"JOINTS_0", joints},
                           {"WEIGHTS_0", weights}}},
                         {"indices", indices},
                         {"material", 0}}}}}};
  b.doc["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", binds}}};
  b.doc["nodes"] = {{{"name", "body"}, {"mesh", 0}, {"skin", 0}},
                    {{"name", "hips"}, {"children", {2}}},
                    {{"name", "arm"}, {"translation", {0, 1, 0}}}};
  b.doc["scenes"] = {{{"nodes", {0, 1}}}};
  b.doc["scene"] = 0;
  b.doc["animations"] = {{{"name", "wave"},
                          {"samplers", {{{"input", times}, {"output", turns}}}},
                          {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}}};
  return b;
}

inline LoadOptions as_is() {
  LoadOptions options;
  options.normalise.height = std::nullopt;
  return options;
}

inline Character load(const std::vector<uint8_t>& bytes, const LoadOptions& options = as_is()) {
  return load_character(bytes, "card.glb", {}, options);
}
inline Character load(Builder& b, const LoadOptions& options = as_is()) { return load(b.glb(), options); }

}  // namespace crowdbench::scene::test
