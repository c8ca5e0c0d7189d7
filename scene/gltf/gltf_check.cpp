#include "scene/gltf/gltf_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace crowdbench::scene {

GltfCheck::GltfCheck(GltfSource& from, const GltfLimits& within)
    : GltfDocument(from, within),
      source(from),
      limits(within),
      pruned(std::make_unique<json>(json::object())),
      decoded_left_(within.decoded_bytes) {}

GltfCheck::~GltfCheck() = default;

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

void GltfCheck::keep(const char* list, json element) { (*pruned)[list].push_back(std::move(element)); }

}  // namespace crowdbench::scene
