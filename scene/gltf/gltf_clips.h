// The animations of a glTF asset. Internal to the loader.
#pragma once
#include "scene/gltf/gltf_asset.h"

namespace crowdbench::scene {

// Fills Character::clips; takes the matrices of animated nodes apart. After the nodes. Throws Error: key times that do
// not rise, values that are not finite, a matrix that cannot be taken apart, more clips times nodes than the limit.
void read_clips(GltfAsset& asset);

}  // namespace crowdbench::scene
