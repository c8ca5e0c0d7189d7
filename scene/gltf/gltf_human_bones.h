// What a VRM file says about which node is which bone. Internal to the loader.
#pragma once
#include "scene/gltf/gltf_asset.h"

namespace crowdbench::scene {

// Fills Skeleton::human_bones from the extensions VRM (0.x) and VRMC_vrm (1.0). After the nodes. What is not as those
// specifications have it is passed over: nothing but names is lost.
void read_human_bones(GltfAsset& asset);

}  // namespace crowdbench::scene
