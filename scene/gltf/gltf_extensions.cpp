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
// the scenario's, materials are a base colour and light given off.
bool changes_nothing(std::string_view name) {
  static constexpr std::array<std::string_view, 5> kNames = {"KHR_lights_punctual", "KHR_xmp", "KHR_xmp_json_ld",
                                                             "EXT_lights_image_based", "EXT_lights_ies"};
  return name.starts_with("KHR_materials_") || std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

std::string_view what_helps(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kAdvice = {{
      {"EXT_mesh_gpu_instancing", "make one mesh of the instances (gltf-transform uninstance)"},
      {"KHR_texture_basisu", "save the textures as PNG, JPEG or WebP (no KTX2)"},
      {"KHR_meshopt_compression", "compress with EXT_meshopt_compression (gltfpack -c), or not at all"},
      {"EXT_texture_avif", "save the textures as PNG, JPEG or WebP"},
      {"MSFT_texture_dds", "save the textures as PNG, JPEG or WebP"},
      {"KHR_animation_pointer", "animate nodes only"},
  }};
  const auto found = std::find_if(kAdvice.begin(), kAdvice.end(), [&](const auto& a) { return a.first == name; });
  return found == kAdvice.end() ? "export the file without it" : found->second;
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
  if (!ignored.empty()) check.warn("extensions ignored: " + listed(ignored, ", ", shown));
  return found;
}

}  // namespace crowdbench::scene
