// glTF 2.0 (.glb, .gltf) characters: loaded after a validation of the whole document, saved for other engines.
//
// The document is parsed once, by the checks: tinygltf's own parser believes offsets, counts and types as they are
// written, so that what it reads would have to be checked before, and the second parse cost as much as the first.
// tinygltf decodes JPEG, and is what loading is timed beside (bench_load).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/pose/normalise.h"

namespace crowdbench::scene {

// What is refused before memory is spent on it; together they keep a load below 1 GiB whatever the file claims.
// `inspect --help` prints these.
struct GltfLimits {
  size_t file_bytes = size_t{192} << 20;     // all files of the asset together, data uris included
  size_t decoded_bytes = size_t{256} << 20;  // of compressed meshes and animations, all
  size_t json_bytes = size_t{64} << 20;
  size_t json_values = 1'000'000;  // objects, arrays, numbers, strings
  int json_depth = 64;
  size_t nodes = 65536;
  size_t joints = 1024;          // palette entries: the joints of all used skins and the rigid meshes
  size_t primitives = 65536;     // over all nodes: a mesh on two nodes counts twice
  size_t vertices = 2'000'000;   // likewise: those that triangles name, with those added for flat normals
  size_t triangles = 4'000'000;  // likewise
  size_t keys = 10'000'000;      // scalars over all animation channels
  size_t clips = 4096;
  size_t clip_nodes = 1'000'000;  // clips times nodes: what posing every clip costs
  double clip_seconds = 3600;
  int influence_sets = 4;  // JOINTS_0..JOINTS_3: 16 joints a vertex
  double magnitude = 1e9;  // of any coordinate, translation or scale
  double reach = 1e15;     // of any node in any pose, scales and translations of its parents applied
  int image_side = 8192;
  size_t jpeg_pixels = size_t{8192} * 4096;  // decoding a progressive JPEG needs 17 bytes a pixel
  size_t image_bytes = size_t{256} << 20;    // decoded (4 bytes a pixel), all images
};

struct LoadOptions {
  NormaliseOptions normalise;
  bool rigid_meshes = true;       // false: drop the unskinned meshes of a file that has a skin (a held sword)
  std::vector<std::string> hide;  // node names whose meshes (theirs and their descendants') are dropped
  // Keep what nothing shows (vertices that no triangle names, triangles without area or fully transparent), in the
  // file's order: for looking at the file itself.
  bool undrawn = false;
  // A file that draws nothing serves too, for its nodes and clips: it is not normalised then, and has no motion.
  bool may_lack_mesh = false;
  GltfLimits limits;
};

// Loads a character. Throws Error naming the file and the JSON path of the fault; whatever the bytes are, it neither
// crashes nor hangs, reads nothing outside the asset's folder and stays within the limits. Oddities that are valid
// become warnings.
Character load_character(const std::filesystem::path& path, const LoadOptions& options = {});

// The same from memory (fuzzing, tests); `folder` resolves relative uris, empty refuses them all.
Character load_character(const std::vector<uint8_t>& bytes, const std::string& where,
                         const std::filesystem::path& folder, const LoadOptions& options = {});

// Writes a self-contained .glb (skin, clips, PNG textures) that other engines load. Throws Error.
void save_character(const Character& character, const std::filesystem::path& path);

}  // namespace crowdbench::scene
