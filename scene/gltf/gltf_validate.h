// Our own validation of a glTF document, before any other code uses a value of it. Internal to the loader.
//
// Parsers take a file's word for counts, ranges, cycles and places on disk. So the rest of the loader sees only what
// this returns: the members that it uses, each of a checked type and range.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_human_bones.h"
#include "scene/gltf/gltf_model.h"
#include "scene/gltf/gltf_source.h"

namespace crowdbench::scene {

struct GltfImage {
  std::string uri;                 // empty: in a buffer view
  std::span<const uint8_t> bytes;  // of an image in a buffer view
  std::string path;                // "/images/0"
};

struct GltfPlan {
  GltfModel model;
  std::vector<std::vector<uint8_t>> buffers;  // those that are not the GLB's own chunk
  std::vector<AccessorView> accessors;        // all ranges checked; the data itself is only known to be there
  std::vector<GltfImage> images;
  std::vector<int> node_order;   // every node of the file, parents before children
  std::vector<int> node_parent;  // by file index, -1 for a root
  std::vector<bool> in_scene;    // by file index: below a root of the default scene
  std::vector<bool> hidden;      // by file index: KHR_node_visibility says that it and what is below are not shown
  // By file index: of nodes that stand for one another at different levels of detail, which group (-1: none) and which
  // level, from 0, the finest. What is below such a node is of its level.
  std::vector<int> lod_group;
  std::vector<int> lod;
  std::vector<GltfHumanBone> human_bones;
  size_t vertices = 0;  // of the triangle primitives in the scene, a mesh on two nodes twice
  size_t triangles = 0;
  std::vector<std::string> warnings;
};

// Throws Error naming the file, the JSON path and the fault. source must outlive the plan.
GltfPlan validate_gltf(GltfSource& source, const GltfLimits& limits);

// The sparse indices of an accessor are strictly increasing and below its count. Costs one pass, so it is done for the
// accessors that are used, each time one is.
void check_sparse(const AccessorView& view, const GltfSource& source);

}  // namespace crowdbench::scene
