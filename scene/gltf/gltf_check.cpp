#include "scene/gltf/gltf_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace crowdbench::scene {

GltfCheck::GltfCheck(GltfSource& from, const GltfLimits& within)
    : GltfDocument(from, within), source(from), limits(within), pruned(std::make_unique<json>(json::object())) {}

GltfCheck::~GltfCheck() = default;

void GltfCheck::warn_once(const std::string& path, std::string_view what) {
  if (warned_.insert(what).second) warn(fmt::format("{}: {}", path, what));
}

void GltfCheck::keep(const char* list, json element) { (*pruned)[list].push_back(std::move(element)); }

}  // namespace crowdbench::scene
