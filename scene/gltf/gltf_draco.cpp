// Based on: Khronos Group, "KHR_draco_mesh_compression".
#include "scene/gltf/gltf_draco.h"

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/module.h"
#include "scene/gltf/module/draco_api.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;
constexpr const char* kName = "KHR_draco_mesh_compression";

const draco_module::Api& api() {
  static const draco_module::Api& loaded = []() -> const draco_module::Api& {
    const auto function = reinterpret_cast<draco_module::ApiFunction>(
        module_symbol("draco", draco_module::kApiSymbol, "reading meshes compressed by Draco"));
    const draco_module::Api& found = *function();
    if (found.version != draco_module::kApiVersion)
      throw Error("crowdbench_draco.so", "is of another version than the program", "rebuild with ./run build");
    return found;
  }();
  return loaded;
}

int gltf_type(ComponentType type) {
  static constexpr std::array<int, 6> kTypes = {5120, 5121, 5122, 5123, 5125, 5126};
  return kTypes[type];
}

// Decoded bytes as a further accessor of the plan.
int add_accessor(GltfCheck& check, AccessorView view, std::vector<uint8_t> bytes) {
  check.plan.buffers.push_back(std::move(bytes));
  view.base = check.plan.buffers.back().data();
  view.stride = component_size(view.type) * static_cast<size_t>(view.components);
  view.sparse_count = 0;
  check.plan.accessors.push_back(std::move(view));
  return static_cast<int>(check.plan.accessors.size()) - 1;
}

using DracoMesh = std::unique_ptr<draco_module::Mesh, void (*)(draco_module::Mesh*)>;

DracoMesh decoded(const GltfCheck& check, std::span<const uint8_t> bytes, const std::string& path) {
  const auto count = [](size_t limit) { return static_cast<uint32_t>(std::min<size_t>(limit, UINT32_MAX / 3)); };
  const draco_module::Limits limits{count(check.limits.vertices), count(check.limits.triangles), check.decoded_left()};
  std::array<char, draco_module::kMessageBytes> message{};
  DracoMesh mesh(api().decode(bytes.data(), bytes.size(), &limits, message.data()), api().free);
  if (!mesh) check.fail(path, message.data(), "the file is damaged or too large; compress it anew or not at all");
  return mesh;
}

}  // namespace

std::optional<DracoAccessors> decode_draco(GltfCheck& check, const GltfData& data, const json& primitive,
                                           const std::string& primitive_path) {
  const json* extension = check.extension(primitive, primitive_path, kName);
  if (!extension) return std::nullopt;
  const std::string path = primitive_path + "/extensions/" + kName;
  const std::string at = path + "/attributes";
  const json* ids = check.member(*extension, "attributes");
  if (!ids) check.fail(path, "has no attributes");
  check.require_object(*ids, at);
  const int view = check.required_index(*extension, path, "bufferView", "bufferViews");
  const DracoMesh mesh = decoded(check, data.view_bytes(view), path);
  const size_t points = api().points(mesh.get());
  const size_t faces = api().faces(mesh.get());
  DracoAccessors out;
  const json* attributes = check.member(primitive, "attributes");
  for (const auto& [name, id] : ids->items()) {
    const std::string where = at + "/" + printable(name, 60);
    const uint64_t unique_id = check.integer(id, where, 0, UINT32_MAX);
    if (!attributes || !attributes->is_object() || !attributes->contains(name))
      check.fail(where, "is not an attribute of the primitive");
    AccessorView accessor = data.accessor(check.index((*attributes)[name], where, "accessors"));
    accessor.count = points;
    const size_t size = points * component_size(accessor.type) * static_cast<size_t>(accessor.components);
    check.spend_decoded(size, where);
    std::vector<uint8_t> bytes(size);
    if (!api().attribute(mesh.get(), static_cast<uint32_t>(unique_id), gltf_type(accessor.type), accessor.components,
                         bytes.data()))
      check.fail(where, fmt::format("is {}, which is not an attribute of {} components in the compressed mesh",
                                    unique_id, accessor.components));
    out.attributes[name] = add_accessor(check, std::move(accessor), std::move(bytes));
  }
  AccessorView corners;
  corners.path = path;
  corners.type = kU32;
  corners.count = faces * 3;
  check.spend_decoded(faces * 12, path);
  std::vector<uint8_t> bytes(faces * 12);
  if (faces == 0) check.fail(path, "has no triangle");
  api().indices(mesh.get(), reinterpret_cast<uint32_t*>(bytes.data()));
  out.indices = add_accessor(check, std::move(corners), std::move(bytes));
  return out;
}

}  // namespace crowdbench::scene
