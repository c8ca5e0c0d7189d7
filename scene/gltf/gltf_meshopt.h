// Buffer views compressed by EXT_meshopt_compression. Internal to the loader.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/gltf_check.h"

namespace crowdbench::scene {

// The bytes of a compressed view. extension: its member, at `path`; packed: the buffer that it names; size: byteLength
// of the view. Counts towards GltfLimits::decoded_bytes. Throws Error.
std::vector<uint8_t> decode_meshopt(GltfCheck& check, const nlohmann::json& extension, const std::string& path,
                                    std::span<const uint8_t> packed, uint64_t size);

}  // namespace crowdbench::scene
