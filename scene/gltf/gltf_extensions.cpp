#include "scene/gltf/gltf_extensions.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

constexpr const char* kInstances = "EXT_mesh_gpu_instancing";

constexpr std::array<std::string_view, 10> kRead = {"KHR_mesh_quantization",
                                                    "KHR_texture_transform",
                                                    "EXT_meshopt_compression",
                                                    "KHR_draco_mesh_compression",
                                                    "EXT_texture_webp",
                                                    "KHR_node_visibility",
                                                    "MSFT_lod",
                                                    "KHR_materials_unlit",
                                                    "KHR_materials_emissive_strength",
                                                    "KHR_materials_pbrSpecularGlossiness"};

// They change nothing that is drawn here, so that even a file that requires them is drawn as it should be: lights are
// the scenario's, materials are a base colour and light given off, nothing is heard, felt or followed. VRM says which
// node is which bone, which is read; its springs and constraints move what hangs.
bool changes_nothing(std::string_view name) {
  static constexpr std::array<std::string_view, 17> kNames = {"EXT_instance_features",
                                                              "EXT_lights_ies",
                                                              "EXT_lights_image_based",
                                                              "EXT_mesh_features",
                                                              "EXT_structural_metadata",
                                                              "KHR_collision_shapes",
                                                              "KHR_implicit_shapes",
                                                              "KHR_interactivity",
                                                              "KHR_lights_punctual",
                                                              "KHR_node_hoverability",
                                                              "KHR_node_selectability",
                                                              "KHR_physics_rigid_bodies",
                                                              "KHR_xmp",
                                                              "KHR_xmp_json_ld",
                                                              "MSFT_audio_emitter",
                                                              "MSFT_physics",
                                                              "VRM"};
  static constexpr std::array<std::string_view, 5> kFamilies = {"KHR_materials_", "VRMC_", "KHR_audio", "OMI_", "MOZ_"};
  return std::ranges::any_of(kFamilies, [&](std::string_view family) { return name.starts_with(family); }) ||
         std::ranges::find(kNames, name) != kNames.end();
}

// Of those that would change what is drawn.
std::string_view advice_on(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kAdvice = {{
      {kInstances, "make one mesh of the instances (gltf-transform uninstance)"},
      {"KHR_texture_basisu", "save the textures as PNG, JPEG or WebP (no KTX2)"},
      {"KHR_meshopt_compression", "compress with EXT_meshopt_compression (gltfpack -c), or not at all"},
      {"EXT_texture_avif", "save the textures as PNG, JPEG or WebP"},
      {"MSFT_texture_dds", "save the textures as PNG, JPEG or WebP"},
      {"KHR_animation_pointer", "animate nodes only"},
  }};
  const auto found = std::ranges::find(kAdvice, name, &std::pair<std::string_view, std::string_view>::first);
  return found == kAdvice.end() ? std::string_view() : found->second;
}

std::string_view what_helps(std::string_view name) {
  const std::string_view advice = advice_on(name);
  return advice.empty() ? "export the file without it" : advice;
}

// Nodes may have it though the file does not say that it is used.
bool has_instances(const GltfCheck& check) {
  const json* nodes = check.member(check.root(), "nodes");
  if (!nodes || !nodes->is_array()) return false;
  return std::ranges::any_of(*nodes, [](const json& node) {
    if (!node.is_object()) return false;
    const auto extensions = node.find("extensions");
    return extensions != node.end() && extensions->is_object() && extensions->contains(kInstances);
  });
}

std::vector<std::string> names_in(const GltfCheck& check, const char* key) {
  std::vector<std::string> names;
  const json* list = check.member(check.root(), key);
  if (!list) return names;
  const std::string path = std::string("/") + key;
  if (!list->is_array()) check.fail(path, fmt::format("is {}, not an array", list->type_name()));
  for (size_t i = 0; i < list->size(); ++i) {
    if (!(*list)[i].is_string()) check.fail(check.item(path, i), "is not a string");
    names.push_back((*list)[i].get<std::string>());
  }
  return names;
}

// The first eight, in alphabetical order: a hostile list is long.
template <typename Text>
std::string listed(const std::set<std::string>& names, const char* separator, const Text& text) {
  std::string out;
  size_t count = 0;
  for (const std::string& name : names) {
    if (count++ == 8) return out + separator + "...";
    out += (out.empty() ? "" : separator) + text(name);
  }
  return out;
}

std::string shown(const std::string& name) { return printable(name, 60); }

void refuse(const GltfCheck& check, const std::set<std::string>& names) {
  check.fail(
      "/extensionsRequired",
      fmt::format("requires {}, which {} not supported", listed(names, ", ", shown), names.size() == 1 ? "is" : "are"),
      listed(names, "; ", [&](const std::string& name) {
        return (names.size() == 1 ? "" : shown(name) + ": ") + std::string(what_helps(name));
      }));
}

}  // namespace

GltfExtensions check_extensions(GltfCheck& check) {
  std::set<std::string> refused;
  std::set<std::string> ignored;
  GltfExtensions found;
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    for (const std::string& name : names_in(check, key)) {
      if (name == "KHR_mesh_quantization") found.quantized = true;
      if (std::find(kRead.begin(), kRead.end(), name) != kRead.end()) continue;
      const bool required = std::string_view(key) == "extensionsRequired";
      (required && !changes_nothing(name) ? refused : ignored).insert(name);
    }
  }
  if (!refused.empty()) refuse(check, refused);
  if (has_instances(check)) ignored.insert(kInstances);
  for (const std::string& name : ignored)
    if (const std::string_view advice = advice_on(name); !advice.empty())
      check.warn(fmt::format("{} is ignored{}; to see it, {}", name,
                             name == kInstances ? ": of each node's instances one is drawn, at the node" : "", advice));
  std::erase_if(ignored, [](const std::string& name) { return !advice_on(name).empty(); });
  if (!ignored.empty()) check.warn("extensions ignored: " + listed(ignored, ", ", shown));
  return found;
}

}  // namespace crowdbench::scene
