// A character by the name that a user gives it.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scene/gltf/gltf.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::scene {

// Clips that it plays beside its own.
struct BorrowedClips {
  std::vector<std::string> animations;  // characters as open_character takes them; clips alone are enough
  std::vector<std::string> bones;       // RetargetOptions::bones
};

// Whether the name is that of a character without a file.
bool is_built_in(std::string_view name);

// Where a character that a scenario names is: `folder` resolves relative paths.
std::string path_of_character(const std::string& name, const std::filesystem::path& folder);

// "mannequin[:triangles=5000,joints=20]" or a path: what every command's --character accepts.
Character open_character(const std::string& name_or_path, const LoadOptions& options = {},
                         const BorrowedClips& borrowed = {});

// The character of a scenario's entry; `folder` resolves relative paths.
Character open_character(const CharacterEntry& entry, const std::filesystem::path& folder = {});

}  // namespace crowdbench::scene
