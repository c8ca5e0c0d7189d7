// The files that a glTF asset names beside itself.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crowdbench::scene {

// Called with each uri as it is written, and with the bytes behind it: nothing where they cannot be read.
using GltfFileFound = std::function<void(const std::string& uri, const std::optional<std::vector<uint8_t>>& bytes)>;

// Of buffers and images, each uri once, by the loader's rules: nothing outside of the asset's folder is read, and of
// all files together no more than GltfLimits::file_bytes. bytes: of a .gltf or .glb file; of any other, or of a broken
// one, nothing is found. Data that the asset holds itself is left out.
void each_gltf_file(std::span<const uint8_t> bytes, const std::filesystem::path& folder, const GltfFileFound& found);

}  // namespace crowdbench::scene
