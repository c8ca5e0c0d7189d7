// Primitives compressed by KHR_draco_mesh_compression. Internal to the loader.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"

namespace crowdbench::scene {

// The accessors that stand for those of a compressed primitive.
struct DracoAccessors {
  std::map<std::string, int> attributes;  // by name
  int indices = -1;                       // a list of triangles
};

// std::nullopt: the primitive is not compressed. Draco is loaded at the first that is; what is decoded counts towards
// GltfLimits::decoded_bytes. Throws Error.
std::optional<DracoAccessors> decode_draco(GltfCheck& check, const GltfData& data, const nlohmann::json& primitive,
                                           const std::string& path);

}  // namespace crowdbench::scene
