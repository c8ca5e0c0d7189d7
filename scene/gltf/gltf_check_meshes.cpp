// What a glTF document says of meshes: attributes, indices, and how much of them there is.
#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/error.h"
#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"
#include "scene/gltf/gltf_draco.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

void check_attribute(GltfCheck& check, const GltfData& data, const std::string& name, int index,
                     const std::string& path) {
  const std::initializer_list<GltfData::Format> any_small = {{kF32, 0}, {kI8, 2}, {kU8, 2}, {kI16, 2}, {kU16, 2}};
  if (name == "POSITION") {
    if (data.quantized())
      data.require_format(index, path, {3}, any_small);
    else
      data.require_format(index, path, {3}, {{kF32, 0}});
  } else if (name == "NORMAL") {
    if (data.quantized())
      data.require_format(index, path, {3}, {{kF32, 0}, {kI8, 1}, {kI16, 1}});
    else
      data.require_format(index, path, {3}, {{kF32, 0}});
  } else if (name.starts_with("TEXCOORD_")) {
    if (data.quantized())
      data.require_format(index, path, {2}, any_small);
    else
      data.require_format(index, path, {2}, {{kF32, 0}, {kU8, 1}, {kU16, 1}});
  } else if (name == "COLOR_0") {
    data.require_format(index, path, {3, 4}, {{kF32, 0}, {kU8, 1}, {kU16, 1}});
  } else if (name.starts_with("JOINTS_")) {
    data.require_format(index, path, {4}, {{kU8, 0}, {kU16, 0}});
  } else if (name.starts_with("WEIGHTS_")) {
    data.require_format(index, path, {4}, {{kF32, 0}, {kU8, 2}, {kU16, 2}});
    const AccessorView& view = data.accessor(index);
    if (view.type != kF32 && !view.normalized)
      check.warn_once(path, "integer weights are not marked as normalised; they are taken as such");
  }
}

void check_targets(GltfCheck& check, const json& primitive, const std::string& path) {
  const json* targets = check.member(primitive, "targets");
  if (!targets) return;
  if (!targets->is_array()) check.fail(path + "/targets", fmt::format("is {}, not an array", targets->type_name()));
  if (!targets->empty()) check.warn_once(path, kMorphTargets);
}

GltfPrimitive check_primitive(GltfCheck& check, const GltfData& data, const json& primitive, const std::string& path,
                              GltfMeshSize& size) {
  check.require_object(primitive, path);
  const json* attributes = check.member(primitive, "attributes");
  if (!attributes) check.fail(path, "has no attributes");
  const std::string at = path + "/attributes";
  check.require_object(*attributes, at);
  auto mode = check.integer_or(primitive, path, "mode", 4, 0, 6);
  const std::optional<DracoAccessors> draco = decode_draco(check, data, primitive, path);
  if (draco) mode = 4;
  const auto decoded_or = [&](const std::string& name, int accessor) {
    const auto found = draco ? draco->attributes.find(name) : decltype(draco->attributes.end()){};
    return draco && found != draco->attributes.end() ? found->second : accessor;
  };
  GltfPrimitive out;
  out.mode = static_cast<int>(mode);
  std::optional<size_t> count;
  if (const auto position = check.index_or_none(*attributes, at, "POSITION", "accessors"))
    count = data.accessor(decoded_or("POSITION", *position)).count;
  int joint_sets = 0;
  int weight_sets = 0;
  for (const auto& [name, value] : attributes->items()) {
    const bool used = name == "POSITION" || name == "NORMAL" || name == "COLOR_0" || name.starts_with("TEXCOORD_") ||
                      name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
    const std::string where = at + "/" + printable(name, 60);
    const int index_value = decoded_or(name, check.index(value, where, "accessors"));
    if (!used) continue;
    check_attribute(check, data, name, index_value, where);
    const size_t own = data.accessor(index_value).count;
    if (count && own != *count) check.fail(where, fmt::format("has {} elements, POSITION has {}", own, *count));
    if (name.starts_with("JOINTS_")) ++joint_sets;
    if (name.starts_with("WEIGHTS_")) ++weight_sets;
    out.attributes.emplace(name, index_value);
  }
  if (joint_sets != weight_sets)
    check.fail(at, fmt::format("has {} sets of joints and {} of weights", joint_sets, weight_sets));
  if (joint_sets > check.limits.influence_sets)
    check.fail(at, fmt::format("has {} sets of joints, more than the {} that are read", joint_sets,
                               check.limits.influence_sets));
  for (int set = 0; set < joint_sets; ++set)
    for (const char* kind : {"JOINTS_", "WEIGHTS_"})
      if (!attributes->contains(fmt::format("{}{}", kind, set))) check.fail(at, fmt::format("has no {}{}", kind, set));
  std::optional<size_t> corners = count;
  std::optional<int> indices = check.index_or_none(primitive, path, "indices", "accessors");
  if (draco) indices = draco->indices;
  if (indices) {
    const std::string where = path + "/indices";
    data.require_format(*indices, where, {1}, {{kU8, 0}, {kU16, 0}, {kU32, 0}});
    if (data.accessor(*indices).base == nullptr) check.fail(where, "names an accessor without a bufferView");
    if (data.accessor(*indices).stride != component_size(data.accessor(*indices).type))
      check.fail(where, "names an accessor with a byteStride");
    corners = data.accessor(*indices).count;
    out.indices = *indices;
  }
  if (const auto material = check.index_or_none(primitive, path, "material", "materials")) out.material = *material;
  check_targets(check, primitive, path);
  ++size.primitives;
  if (mode < 4) {
    check.warn_once(path, "points and lines are not drawn");
  } else if (!count) {
    check.warn(fmt::format("{}: has no POSITION and is not drawn", path));
  } else {
    if (mode == 4 && *corners % 3 != 0)
      check.fail(path, fmt::format("has {} corners of triangles, not a multiple of 3", *corners));
    if (*corners < 3) check.fail(path, fmt::format("has {} corners, too few for a triangle", *corners));
    size.vertices += std::min(*count, *corners);  // what no triangle names is not read
    size.triangles += mode == 4 ? *corners / 3 : *corners - 2;
  }
  return out;
}

}  // namespace

std::vector<GltfMeshSize> check_meshes(GltfCheck& check, const GltfData& data) {
  std::vector<GltfMeshSize> sizes;
  check.each("meshes", [&](const json& mesh, const std::string& path) {
    check.name_of(mesh, path);
    const json* primitives = check.member(mesh, "primitives");
    if (!primitives || !primitives->is_array() || primitives->empty()) check.fail(path, "has no primitives");
    GltfMeshSize size;
    std::vector<GltfPrimitive> out;
    for (size_t i = 0; i < primitives->size(); ++i)
      out.push_back(check_primitive(check, data, (*primitives)[i], check.item(path + "/primitives", i), size));
    check.plan.model.meshes.push_back(std::move(out));
    sizes.push_back(size);
  });
  return sizes;
}

}  // namespace crowdbench::scene
