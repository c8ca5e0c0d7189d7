// FBX and COLLADA characters, read by Assimp (crowdbench_assimp.so, loaded at first use).
//
// What Assimp reads is written as a glTF 2.0 document in memory and handed to load_character() of scene/gltf: so
// validation, limits, the reduction of weights, travel, facing, height, default clip and hashes are the same code for
// every file, and a fault reads the same, with the file's own names in place of JSON paths. Assimp itself takes a
// file's word for much: it runs in a child process (scene/assimp/isolated.h), so that a file that crashes it, hangs it
// or makes it take all memory is refused like any other.
//
// Lost, with a warning that names what the file has of it: blend shapes, cameras, lights, constraints, pictures other
// than of base colour and emission, opacity in pictures of its own, moved or scaled textures, points and lines,
// influences beyond 16 a vertex. Curves are sampled at their keys and go straight between them. Colours are linear.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/gltf.h"

namespace crowdbench::scene {

enum class AssimpFormat : uint8_t { fbx, collada };

// By the first bytes of a file, else by its extension; std::nullopt: neither FBX nor COLLADA.
std::optional<AssimpFormat> assimp_format(std::span<const uint8_t> start, const std::filesystem::path& path);

// As load_character(): in metres, +Y up, whatever the file's unit and axes are. Pictures come from the file itself or
// from `folder` and what lies below it: under the path that the file gives, else under that path's last name beside the
// file, in `textures` or in NAME.fbm; empty: none. Throws Error naming the file and what is wrong.
Character load_assimp_character(const std::vector<uint8_t>& bytes, AssimpFormat format, const std::string& where,
                                const std::filesystem::path& folder, const LoadOptions& options = {});

}  // namespace crowdbench::scene
