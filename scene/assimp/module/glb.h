// A glTF document in the making: lists of JSON objects, and the bytes that they refer to. Internal to the module.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <type_traits>
#include <vector>

namespace crowdbench::scene::assimp_module {

class Glb {
 public:
  Glb();
  ~Glb();
  Glb(const Glb&) = delete;
  Glb& operator=(const Glb&) = delete;

  nlohmann::json& document() { return *document_; }
  // Appends to a list of the document; its index there.
  int add(const char* list, nlohmann::json element);
  int view(const void* data, size_t size);
  // data holds `count` elements of `type`, of float, uint16_t or uint32_t.
  template <typename T>
  int accessor(const std::vector<T>& data, const char* type, size_t count) {
    constexpr int component = std::is_same_v<T, uint16_t> ? 5123 : std::is_same_v<T, uint32_t> ? 5125 : 5126;
    return add_accessor(view(data.data(), data.size() * sizeof(T)), component, type, count);
  }
  // The whole file.
  std::vector<uint8_t> container();

 private:
  int add_accessor(int view, int component, const char* type, size_t count);
  std::unique_ptr<nlohmann::json> document_;
  std::vector<uint8_t> bytes_;
};

}  // namespace crowdbench::scene::assimp_module
