#include "scene/gltf/gltf_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace crowdbench::scene {

GltfCheck::GltfCheck(GltfSource& from, const GltfLimits& within)
    : GltfDocument(from, within), source(from), limits(within), decoded_left_(within.decoded_bytes) {}

void GltfCheck::warn_once(const std::string& path, std::string_view what) {
  if (warned_.insert(what).second) warn(fmt::format("{}: {}", path, what));
}

void GltfCheck::spend_decoded(uint64_t bytes, const std::string& path) {
  if (bytes > decoded_left_)
    fail(path,
         fmt::format("decodes to {} bytes, which brings all compressed data above the limit of {}", bytes,
                     limits.decoded_bytes),
         "use a smaller character");
  decoded_left_ -= bytes;
}

}  // namespace crowdbench::scene
