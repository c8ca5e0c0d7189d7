// Based on: VRM Consortium, "VRM 0.0" (humanoid.humanBones, a list) and "VRMC_vrm-1.0" (humanoid.humanBones, by name).
#include "scene/gltf/gltf_human_bones.h"

#include <tiny_gltf.h>

#include <string>

namespace crowdbench::scene {
namespace {

void add(GltfAsset& asset, const std::string& name, const tinygltf::Value& node) {
  if (!node.IsInt() || node.GetNumberAsInt() < 0) return;
  const auto file_index = static_cast<size_t>(node.GetNumberAsInt());
  if (file_index >= asset.node_of.size() || asset.node_of[file_index] < 0) return;
  asset.character.skeleton.human_bones.push_back({name, asset.node_of[file_index]});
}

const tinygltf::Value* human_bones(const tinygltf::Model& model, const char* extension) {
  const auto found = model.extensions.find(extension);
  if (found == model.extensions.end() || !found->second.Has("humanoid")) return nullptr;
  const tinygltf::Value& humanoid = found->second.Get("humanoid");
  return humanoid.Has("humanBones") ? &humanoid.Get("humanBones") : nullptr;
}

}  // namespace

void read_human_bones(GltfAsset& asset) {
  if (const tinygltf::Value* list = human_bones(*asset.model, "VRM"); list != nullptr && list->IsArray())
    for (size_t i = 0; i < list->ArrayLen(); ++i) {
      const tinygltf::Value& bone = list->Get(i);
      if (bone.Has("bone") && bone.Get("bone").IsString() && bone.Has("node"))
        add(asset, bone.Get("bone").Get<std::string>(), bone.Get("node"));
    }
  if (const tinygltf::Value* named = human_bones(*asset.model, "VRMC_vrm"); named != nullptr && named->IsObject())
    for (const std::string& name : named->Keys())
      if (const tinygltf::Value& bone = named->Get(name); bone.Has("node")) add(asset, name, bone.Get("node"));
}

}  // namespace crowdbench::scene
