// What a glTF document says that it needs beyond glTF 2.0. Internal to the loader.
#pragma once
#include "scene/gltf/gltf_check.h"

namespace crowdbench::scene {

struct GltfExtensions {
  bool quantized = false;  // KHR_mesh_quantization
};

// Refuses a file that requires what is not read: one Error names all of it, each with what helps. What is ignored is
// one warning.
GltfExtensions check_extensions(GltfCheck& check);

}  // namespace crowdbench::scene
