// Based on: Khronos Group, "glTF 2.0 Specification" (GLB container, accessors).
#include "scene/assimp/module/glb.h"

#include <nlohmann/json.hpp>
#include <string>

namespace crowdbench::scene::assimp_module {

using nlohmann::json;

Glb::Glb() : document_(std::make_unique<json>(json{{"asset", {{"version", "2.0"}}}})) {}
Glb::~Glb() = default;

int Glb::add(const char* list, json element) {
  json& all = (*document_)[list];
  all.push_back(std::move(element));
  return static_cast<int>(all.size()) - 1;
}

int Glb::view(const void* data, size_t size) {
  while (bytes_.size() % 4 != 0) bytes_.push_back(0);
  const auto* from = static_cast<const uint8_t*>(data);
  const size_t offset = bytes_.size();
  bytes_.insert(bytes_.end(), from, from + size);
  return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
}

int Glb::add_accessor(int view, int component, const char* type, size_t count) {
  return add("accessors", {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
}

std::vector<uint8_t> Glb::container() {
  while (bytes_.size() % 4 != 0) bytes_.push_back(0);
  if (!bytes_.empty()) (*document_)["buffers"] = {{{"byteLength", bytes_.size()}}};
  std::string text = document_->dump(-1, ' ', false, json::error_handler_t::replace);
  while (text.size() % 4 != 0) text += ' ';
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

}  // namespace crowdbench::scene::assimp_module
