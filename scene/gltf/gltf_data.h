// Where the data of a glTF document lies: its buffers, buffer views and accessors. Internal to the loader.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_check.h"

namespace crowdbench::scene {

class GltfData {
 public:
  // Checks the three lists and fills GltfPlan::buffers and accessors. quantized: the file uses KHR_mesh_quantization.
  // check must outlive this. Throws Error.
  GltfData(GltfCheck& check, bool quantized);

  bool quantized() const { return quantized_; }
  std::span<const uint8_t> view_bytes(int view) const { return views_[static_cast<size_t>(view)].bytes; }
  const AccessorView& accessor(int index) const { return check_.plan.accessors[static_cast<size_t>(index)]; }

  struct Format {
    ComponentType type;
    int normalized;  // 0: must not be, 1: must be, 2: may be
  };
  // Throws Error naming `path` unless the accessor has that many components and one of the formats.
  void require_format(int index, const std::string& path, std::initializer_list<int> components,
                      std::initializer_list<Format> formats) const;

 private:
  using json = GltfDocument::json;
  struct View {
    std::span<const uint8_t> bytes;
    size_t offset = 0;  // in its buffer, for alignment
    size_t stride = 0;  // 0: tight
  };

  void check_buffers();
  void check_buffer_views();
  // The decoded bytes of a view that EXT_meshopt_compression describes.
  std::span<const uint8_t> decoded(const json& extension, const std::string& path, const json& view,
                                   const std::string& view_path);
  void check_accessors();
  void check_sparse_ranges(const json& sparse, const std::string& path, size_t size, AccessorView& view) const;
  ComponentType component_type(const json& object, const std::string& path) const;
  // Where `count` elements of `size` bytes begin; stride 0 means tight. Throws Error when they pass the end of the view
  // or are not aligned.
  const uint8_t* place(const View& view, const std::string& path, const char* what, uint64_t offset, uint64_t count,
                       size_t size, size_t stride, size_t alignment) const;

  GltfCheck& check_;
  bool quantized_;
  std::vector<std::span<const uint8_t>> buffers_;  // empty: the fallback of compressed views, which is not read
  std::vector<View> views_;
};

}  // namespace crowdbench::scene
