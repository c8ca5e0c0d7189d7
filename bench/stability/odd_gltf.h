// Small glTF files with one thing wrong or odd in each.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/gltf/gltf.h"

namespace crowdbench::bench {

struct OddGltf {
  std::string name;
  bool refused = false;  // else it is valid, and loads
  std::vector<uint8_t> bytes;
};
// A triangle of two joints that turn, as .glb.
std::vector<OddGltf> odd_gltfs();

}  // namespace crowdbench::bench
