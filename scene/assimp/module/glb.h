// A glTF document in the making: lists of JSON objects, and the bytes that they refer to. Internal to the module.
// Based on: Khronos Group, "glTF 2.0 Specification" (GLB container, accessors).
#pragma once
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace crowdbench::scene::assimp_module {

class Glb {
 public:
  nlohmann::json document = {{"asset", {{"version", "2.0"}}}};

  // Appends to a list of the document; its index there.
  int add(const char* list, nlohmann::json element) {
    document[list].push_back(std::move(element));
    return static_cast<int>(document[list].size()) - 1;
  }

  int view(const void* data, size_t size) {
    while (bytes_.size() % 4 != 0) bytes_.push_back(0);
    const auto* from = static_cast<const uint8_t*>(data);
    const size_t offset = bytes_.size();
    bytes_.insert(bytes_.end(), from, from + size);
    return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
  }

  // data holds `count` elements of `type`, of float, uint16_t or uint32_t.
  template <typename T>
  int accessor(const std::vector<T>& data, const char* type, size_t count) {
    constexpr int component = std::is_same_v<T, uint16_t> ? 5123 : std::is_same_v<T, uint32_t> ? 5125 : 5126;
    return add("accessors", {{"bufferView", view(data.data(), data.size() * sizeof(T))},
                             {"componentType", component},
                             {"count", count},
                             {"type", type}});
  }

  std::vector<uint8_t> container() {
    if (!bytes_.empty()) document["buffers"] = {{{"byteLength", bytes_.size()}}};
    std::string text = document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    while (text.size() % 4 != 0) text += ' ';
    while (bytes_.size() % 4 != 0) bytes_.push_back(0);
    std::vector<uint8_t> out;
    out.reserve(28 + text.size() + bytes_.size());
    const auto word = [&](size_t value) {
      for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(value >> (8 * i)));
    };
    word(0x46546C67);  // "glTF"
    word(2);
    word(20 + text.size() + (bytes_.empty() ? 0 : 8 + bytes_.size()));
    word(text.size());
    word(0x4E4F534A);  // "JSON"
    out.insert(out.end(), text.begin(), text.end());
    if (bytes_.empty()) return out;
    word(bytes_.size());
    word(0x004E4942);  // "BIN"
    out.insert(out.end(), bytes_.begin(), bytes_.end());
    return out;
  }

 private:
  std::vector<uint8_t> bytes_;
};

}  // namespace crowdbench::scene::assimp_module
