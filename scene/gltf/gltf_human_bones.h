// What a VRM file says about which node is which bone. Internal to the loader.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crowdbench::scene {

struct GltfHumanBone {
  std::string name;  // as VRM has it: "leftUpperArm"
  int node = 0;      // the file's index; there is such a node
};
// From the extensions VRM (0.x) and VRMC_vrm (1.0) of a document with so many nodes. What is not as those
// specifications have it is passed over: nothing but names is lost.
std::vector<GltfHumanBone> gltf_human_bones(const nlohmann::json& document, size_t nodes);

}  // namespace crowdbench::scene
