// Based on: VRM Consortium, "VRM 0.0" (humanoid.humanBones, a list) and "VRMC_vrm-1.0" (humanoid.humanBones, by name).
#include "scene/gltf/gltf_human_bones.h"

#include <nlohmann/json.hpp>

namespace crowdbench::scene {
namespace {

using nlohmann::json;

const json* member(const json* value, const char* name) {
  if (value == nullptr || !value->is_object()) return nullptr;
  const auto found = value->find(name);
  return found == value->end() ? nullptr : &*found;
}

void add(std::vector<GltfHumanBone>& bones, const std::string& name, const json* node, size_t nodes) {
  if (node == nullptr || !node->is_number_unsigned() || node->get<uint64_t>() >= nodes) return;
  bones.push_back({name, node->get<int>()});
}

}  // namespace

std::vector<GltfHumanBone> gltf_human_bones(const json& document, size_t nodes) {
  std::vector<GltfHumanBone> bones;
  const json* extensions = member(&document, "extensions");
  const json* list = member(member(member(extensions, "VRM"), "humanoid"), "humanBones");
  if (list != nullptr && list->is_array())
    for (const json& bone : *list)
      if (const json* name = member(&bone, "bone"); name != nullptr && name->is_string())
        add(bones, name->get<std::string>(), member(&bone, "node"), nodes);
  const json* named = member(member(member(extensions, "VRMC_vrm"), "humanoid"), "humanBones");
  if (named != nullptr && named->is_object())
    for (const auto& [name, bone] : named->items()) add(bones, name, member(&bone, "node"), nodes);
  return bones;
}

}  // namespace crowdbench::scene
