#include "scene/gltf/gltf_data.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "scene/gltf/gltf_meshopt.h"

namespace crowdbench::scene {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";

}  // namespace

GltfData::GltfData(GltfCheck& check, bool quantized) : check_(check), quantized_(quantized) {
  check_buffers();
  check_buffer_views();
  check_accessors();
}

void GltfData::check_buffers() {
  size_t total = 0;
  check_.each("buffers", [&](const json& buffer, const std::string& path) {
    const uint64_t length = check_.required_integer(buffer, path, "byteLength", 1, UINT64_MAX);
    if (length > check_.limits.file_bytes - total)
      check_.fail(path + "/byteLength",
                  fmt::format("is {}; all buffers may have {} bytes", length, check_.limits.file_bytes));
    total += length;
    std::span<const uint8_t> bytes;
    const json* meshopt = check_.extension(buffer, path, kMeshopt);
    if (meshopt && check_.boolean_or(*meshopt, path + "/extensions", "fallback", false)) {
      buffers_.emplace_back();
      return;
    }
    if (const std::string* uri = check_.text_or_none(buffer, path, "uri")) {
      check_.plan.buffers.push_back(check_.source.fetch(*uri, path + "/uri"));
      bytes = check_.plan.buffers.back();
    } else if (check_.source.is_glb() && buffers_.empty()) {
      if (check_.source.bin().empty()) check_.fail(path, "has no uri and the GLB has no BIN chunk");
      bytes = check_.source.bin();
    } else {
      check_.fail(path, "has no uri");
    }
    if (bytes.size() < length)
      check_.fail(path + "/byteLength", fmt::format("is {}, but its data has {} bytes", length, bytes.size()),
                  "the file is truncated or damaged; get it again");
    buffers_.push_back(bytes.first(length));
  });
}

void GltfData::check_buffer_views() {
  check_.each("bufferViews", [&](const json& view, const std::string& path) {
    if (const json* meshopt = check_.extension(view, path, kMeshopt)) {
      const uint64_t step = check_.integer_or(view, path, "byteStride", 0, 1, 256);
      views_.push_back({decoded(*meshopt, path + "/extensions/" + kMeshopt, view, path), 0, static_cast<size_t>(step)});
      return;
    }
    const auto& buffer = buffers_[static_cast<size_t>(check_.required_index(view, path, "buffer", "buffers"))];
    const uint64_t offset = check_.integer_or(view, path, "byteOffset", 0, 0, UINT64_MAX);
    const uint64_t length = check_.required_integer(view, path, "byteLength", 1, UINT64_MAX);
    if (offset > buffer.size() || length > buffer.size() - offset)
      check_.fail(path, fmt::format("byteOffset {} and byteLength {} pass the end of its buffer of {} bytes", offset,
                                    length, buffer.size()));
    const uint64_t stride = check_.integer_or(view, path, "byteStride", 0, 4, 252);
    if (stride % 4 != 0) check_.fail(path + "/byteStride", fmt::format("is {}, not a multiple of 4", stride));
    views_.push_back({buffer.subspan(offset, length), static_cast<size_t>(offset), static_cast<size_t>(stride)});
  });
}

std::span<const uint8_t> GltfData::decoded(const json& extension, const std::string& path, const json& view,
                                           const std::string& view_path) {
  const int buffer = check_.required_index(extension, path, "buffer", "buffers");
  check_.plan.buffers.push_back(decode_meshopt(check_, extension, path, buffers_[static_cast<size_t>(buffer)],
                                               check_.required_integer(view, view_path, "byteLength", 1, UINT64_MAX)));
  return check_.plan.buffers.back();
}

ComponentType GltfData::component_type(const json& object, const std::string& path) const {
  switch (check_.required_integer(object, path, "componentType", 0, UINT64_MAX)) {
    case 5120: return kI8;
    case 5121: return kU8;
    case 5122: return kI16;
    case 5123: return kU16;
    case 5125: return kU32;
    case 5126: return kF32;
    default: break;
  }
  check_.fail(path + "/componentType",
              fmt::format("is {}, not one of 5120, 5121, 5122, 5123, 5125, 5126", object["componentType"].dump()));
}

const uint8_t* GltfData::place(const View& view, const std::string& path, const char* what, uint64_t offset,
                               uint64_t count, size_t size, size_t stride, size_t alignment) const {
  if ((view.offset + offset) % alignment != 0 || offset % alignment != 0)
    check_.fail(path, fmt::format("{} at byte offset {} are not aligned to {} bytes", what, offset, alignment));
  const size_t length = view.bytes.size();
  const uint64_t step = stride == 0 ? size : stride;
  // count - 1 steps and one element, without overflow: step is at most 252.
  if (offset > length || size > length - offset || (count - 1) > (length - offset - size) / step)
    check_.fail(path, fmt::format("{}: {} elements of {} bytes at offset {} pass the end of a view of {} bytes", what,
                                  count, size, offset, length));
  return view.bytes.data() + offset;
}

void GltfData::check_accessors() {
  static constexpr std::array<std::pair<std::string_view, int>, 7> kTypes = {
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  check_.each("accessors", [&](const json& accessor, const std::string& path) {
    AccessorView view;
    view.path = path;
    view.type = component_type(accessor, path);
    const std::string* type = check_.text_or_none(accessor, path, "type");
    if (!type) check_.fail(path, "has no type");
    const auto found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.first == *type; });
    if (found == kTypes.end())
      check_.fail(path + "/type", fmt::format("is {}, not an accessor type", printable(*type, 20)));
    view.components = found->second;
    view.count = check_.required_integer(accessor, path, "count", 1, UINT32_MAX);
    view.normalized = check_.boolean_or(accessor, path, "normalized", false);
    if (view.normalized && (view.type == kF32 || view.type == kU32))
      check_.fail(path + "/normalized", "is true for a component type that cannot be normalised");
    const size_t component = component_size(view.type);
    size_t size = component * static_cast<size_t>(view.components);
    // Columns of small matrices start at multiples of four bytes.
    if (*type == "MAT2" && component == 1) size = 8;
    if (*type == "MAT3" && component < 4) size = component == 1 ? 12 : 24;
    const uint64_t offset = check_.integer_or(accessor, path, "byteOffset", 0, 0, UINT64_MAX);
    if (const auto index = check_.index_or_none(accessor, path, "bufferView", "bufferViews")) {
      const View& bytes = views_[static_cast<size_t>(*index)];
      if (bytes.stride != 0 && bytes.stride < size)
        check_.fail(path, fmt::format("elements of {} bytes overlap at a byteStride of {}", size, bytes.stride));
      view.base = place(bytes, path, "data", offset, view.count, size, bytes.stride, component);
      view.stride = bytes.stride == 0 ? size : bytes.stride;
    } else if (offset != 0) {
      check_.fail(path + "/byteOffset", "is set without a bufferView");
    }
    if (const json* sparse = check_.member(accessor, "sparse"))
      check_sparse_ranges(*sparse, path + "/sparse", size, view);
    check_.plan.accessors.push_back(std::move(view));
  });
}

void GltfData::check_sparse_ranges(const json& sparse, const std::string& path, size_t size, AccessorView& view) const {
  check_.require_object(sparse, path);
  view.sparse_count = check_.required_integer(sparse, path, "count", 1, view.count);
  const auto part = [&](const char* key) -> const json& {
    const json* value = check_.member(sparse, key);
    if (!value) check_.fail(path, fmt::format("has no {}", key));
    check_.require_object(*value, path + "/" + key);
    return *value;
  };
  const json& indices = part("indices");
  const std::string indices_path = path + "/indices";
  view.sparse_index_type = component_type(indices, indices_path);
  if (view.sparse_index_type != kU8 && view.sparse_index_type != kU16 && view.sparse_index_type != kU32)
    check_.fail(indices_path + "/componentType", "is not an unsigned integer type");
  const auto bytes_of = [&](const json& object, const std::string& where) -> const View& {
    const View& bytes = views_[static_cast<size_t>(check_.required_index(object, where, "bufferView", "bufferViews"))];
    if (bytes.stride != 0) check_.fail(where + "/bufferView", "names a view with a byteStride");
    return bytes;
  };
  const size_t index_size = component_size(view.sparse_index_type);
  view.sparse_indices = place(bytes_of(indices, indices_path), indices_path, "indices",
                              check_.integer_or(indices, indices_path, "byteOffset", 0, 0, UINT64_MAX),
                              view.sparse_count, index_size, 0, index_size);
  const json& values = part("values");
  const std::string values_path = path + "/values";
  view.sparse_values = place(bytes_of(values, values_path), values_path, "values",
                             check_.integer_or(values, values_path, "byteOffset", 0, 0, UINT64_MAX), view.sparse_count,
                             size, 0, component_size(view.type));
}

void GltfData::require_format(int index, const std::string& path, std::initializer_list<int> components,
                              std::initializer_list<Format> formats) const {
  const AccessorView& view = accessor(index);
  if (std::find(components.begin(), components.end(), view.components) == components.end())
    check_.fail(path, fmt::format("names accessor {} with {} components an element", index, view.components));
  for (const Format& f : formats)
    if (f.type == view.type && (f.normalized == 2 || (f.normalized == 1) == view.normalized)) return;
  static constexpr std::array<const char*, 6> kNames = {"signed byte",    "unsigned byte", "signed short",
                                                        "unsigned short", "unsigned int",  "float"};
  check_.fail(path,
              fmt::format("names accessor {} of {}{}, which cannot be used here", index,
                          view.normalized ? "normalised " : "", kNames[view.type]),
              view.type != kF32 && !quantized_ ? "integer positions, normals and uvs need KHR_mesh_quantization" : "");
}

}  // namespace crowdbench::scene
