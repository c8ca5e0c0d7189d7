// Based on: Khronos Group, "glTF 2.0 Specification" and the specifications of KHR_mesh_quantization,
// KHR_texture_transform, KHR_materials_unlit and KHR_materials_emissive_strength.
// Differs from the source: what the specification forbids but every engine shows alike (weights without `normalized`,
// colour factors out of range, an animated node with a matrix) is loaded with a warning.
#include "scene/gltf/gltf_validate.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"
#include "scene/gltf/gltf_extensions.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

void check_asset(GltfCheck& check) {
  const json* asset = check.member(check.root(), "asset");
  if (!asset)
    throw Error(check.source.where(), "JSON has no asset, so it is not glTF 2.0",
                "name a glTF 2.0 file (.glb or .gltf)");
  check.require_object(*asset, "/asset");
  const auto major_of = [&](const char* key, bool required) {
    const std::string* version = check.text_or_none(*asset, "/asset", key);
    if (!version) {
      if (required) check.fail("/asset", "has no version");
      return std::string("2.0");
    }
    return *version;
  };
  const std::string version = major_of("version", true);
  const bool two = version.size() >= 3 && version.starts_with("2.") &&
                   std::all_of(version.begin() + 2, version.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!two)
    check.fail("/asset/version", fmt::format("is {}, not 2.0", printable(version, 20)), "convert the file to glTF 2.0");
  const std::string minimum = major_of("minVersion", false);
  if (minimum != "2.0") check.fail("/asset/minVersion", fmt::format("is {}; 2.0 is read", printable(minimum, 20)));
}

}  // namespace

GltfPlan validate_gltf(GltfSource& source, const GltfLimits& limits) {
  GltfCheck check(source, limits);
  check_asset(check);
  const GltfExtensions extensions = check_extensions(check);
  // In the order in which later ones refer to earlier ones.
  const GltfData data(check, extensions.quantized);
  check_materials(check, data);
  const std::vector<GltfMeshSize> meshes = check_meshes(check, data);
  check_nodes(check, data, meshes);
  check_animations(check, data);
  check.plan.human_bones = gltf_human_bones(check.root(), check.plan.node_parent.size());
  return std::move(check.plan);
}

void check_sparse(const AccessorView& view, const GltfSource& source) {
  for (size_t i = 0; i < view.sparse_count; ++i) {
    const size_t index = view.sparse_index(i);
    const std::string path = view.path + "/sparse/indices";
    if (index >= view.count) source.fail(path, fmt::format("index {} is {}, of {} elements", i, index, view.count));
    if (i > 0 && index <= view.sparse_index(i - 1))
      source.fail(path, fmt::format("index {} is {}, not above the one before it", i, index));
  }
}

}  // namespace crowdbench::scene
