// glTF 2.0 (.glb, .gltf) characters: loaded through tinygltf after our own validation, saved for other engines.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scene/character.h"

namespace crowdbench::scene {

// What is refused before memory is spent on it. `inspect --help` prints these.
struct GltfLimits {
  size_t file_bytes = size_t{256} << 20;  // each file of the asset
  size_t json_bytes = size_t{64} << 20;
  int json_depth = 64;
  size_t nodes = 65536;
  size_t joints = 1024;  // palette entries over all skins
  size_t vertices = 4'000'000;
  size_t triangles = 4'000'000;
  size_t keys = 20'000'000;  // scalars over all animation channels
  int image_side = 8192;
  size_t image_bytes = size_t{512} << 20;  // decoded, all images
};

struct LoadOptions {
  NormaliseOptions normalise;
  bool rigid_meshes = true;       // false: drop unskinned meshes parented to joints
  std::vector<std::string> hide;  // node names whose meshes (theirs and their descendants') are dropped
  GltfLimits limits;
};

// Loads a character. Throws Error naming the file and the JSON path of the fault; whatever the bytes are, it neither
// crashes nor hangs, reads nothing outside the asset's folder and stays within the limits. Oddities that are valid
// become warnings.
Character load_character(const std::filesystem::path& path, const LoadOptions& options = {});

// The same from memory (fuzzing, tests); `folder` resolves relative uris, empty refuses them all.
Character load_character(const std::vector<uint8_t>& bytes, const std::string& where,
                         const std::filesystem::path& folder, const LoadOptions& options = {});

// "mannequin[:triangles=5000,joints=20]" or a path: what every command's --character accepts.
Character open_character(const std::string& name_or_path, const LoadOptions& options = {});

// Writes a self-contained .glb (skin, clips, PNG textures) that other engines load. Throws Error.
void save_character(const Character& character, const std::filesystem::path& path);

}  // namespace crowdbench::scene
