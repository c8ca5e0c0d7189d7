// A character by the name that a user gives it.
#pragma once
#include <string>

#include "scene/gltf/gltf.h"

namespace crowdbench::scene {

// "mannequin[:triangles=5000,joints=20]" or a path: what every command's --character accepts.
Character open_character(const std::string& name_or_path, const LoadOptions& options = {});

}  // namespace crowdbench::scene
