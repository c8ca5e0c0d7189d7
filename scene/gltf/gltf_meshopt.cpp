// Based on: A. Kapoulkine, "EXT_meshopt_compression" (Khronos Group, glTF extensions); the decoders are
// meshoptimizer's, which are made for hostile bytes. They trust their arguments, so those are checked here.
#include "scene/gltf/gltf_meshopt.h"

#include <meshoptimizer.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

struct Coding {
  std::string_view mode, filter;
  uint64_t count = 0, stride = 0;
};

bool sizes_fit(const Coding& c) {
  if (c.mode == "TRIANGLES") return c.count % 3 == 0 && (c.stride == 2 || c.stride == 4);
  if (c.mode == "INDICES") return c.stride == 2 || c.stride == 4;
  if (c.filter == "OCTAHEDRAL") return c.stride == 4 || c.stride == 8;
  if (c.filter == "QUATERNION") return c.stride == 8;
  return c.stride % 4 == 0;
}

Coding coding_of(const GltfCheck& check, const json& extension, const std::string& path) {
  const auto word = [&](const char* key, std::initializer_list<std::string_view> allowed) -> std::string_view {
    const std::string* text = check.text_or_none(extension, path, key);
    if (!text && std::string_view(key) == "filter") return "NONE";
    if (!text) check.fail(path, fmt::format("has no {}", key));
    for (const std::string_view a : allowed)
      if (*text == a) return a;
    check.fail(path + "/" + key, fmt::format("is {}, which is unknown", printable(*text, 20)));
  };
  Coding c;
  c.mode = word("mode", {"ATTRIBUTES", "TRIANGLES", "INDICES"});
  c.filter = word("filter", {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"});
  c.count = check.required_integer(extension, path, "count", 1, UINT32_MAX);
  c.stride = check.required_integer(extension, path, "byteStride", 1, 256);
  if (c.filter != "NONE" && c.mode != "ATTRIBUTES") check.fail(path + "/filter", "is only for ATTRIBUTES");
  if (!sizes_fit(c))
    check.fail(path, fmt::format("{} elements of {} bytes do not go with {} and filter {}", c.count, c.stride, c.mode,
                                 c.filter));
  return c;
}

int decode(const Coding& c, std::span<const uint8_t> packed, std::vector<uint8_t>& out) {
  if (c.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(out.data(), c.count, c.stride, packed.data(), packed.size());
  if (c.mode == "INDICES")
    return meshopt_decodeIndexSequence(out.data(), c.count, c.stride, packed.data(), packed.size());
  return meshopt_decodeVertexBuffer(out.data(), c.count, c.stride, packed.data(), packed.size());
}

void undo_filter(const Coding& c, std::vector<uint8_t>& out) {
  if (c.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), c.count, c.stride);
  if (c.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), c.count, c.stride);
  if (c.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), c.count, c.stride);
}

}  // namespace

std::vector<uint8_t> decode_meshopt(GltfCheck& check, const json& extension, const std::string& path,
                                    std::span<const uint8_t> packed, uint64_t size) {
  const Coding c = coding_of(check, extension, path);
  if (c.count * c.stride != size)
    check.fail(path,
               fmt::format("{} elements of {} bytes are not the view's byteLength of {}", c.count, c.stride, size));
  const uint64_t offset = check.integer_or(extension, path, "byteOffset", 0, 0, UINT64_MAX);
  const uint64_t length = check.required_integer(extension, path, "byteLength", 1, UINT64_MAX);
  if (offset > packed.size() || length > packed.size() - offset)
    check.fail(path, fmt::format("byteOffset {} and byteLength {} pass the end of its buffer of {} bytes", offset,
                                 length, packed.size()));
  check.spend_decoded(size, path);
  std::vector<uint8_t> out(size);
  if (decode(c, packed.subspan(offset, length), out) != 0)
    check.fail(path, "does not decode", "the file is damaged, or written by a later meshoptimizer; compress it anew");
  undo_filter(c, out);
  return out;
}

}  // namespace crowdbench::scene
