// A level of detail of a character's mesh, and what it costs in metres.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "renderers/representation.h"
#include "scene/pose/lod_mesh.h"

namespace crowdbench::renderers {

struct MeshLevelOptions {
  scene::LodRequest request;
  size_t lod = 0;  // of those that the character's file holds; 0: its mesh, or what the request makes of it
  bool is_whole() const { return lod == 0 && request.triangles == 0 && request.ratio == 0 && request.error == 0; }
};

struct MeshLevel {
  std::shared_ptr<const scene::Character> character;
  std::shared_ptr<const scene::PoseBank> bank;
  scene::Mesh mesh;
  bool simplified = false;  // from the character's mesh: not the file's own
  std::string note;         // what was asked for and could not be had; empty: nothing
};
// Throws Error: the character's file has no such level.
MeshLevel make_mesh_level(const std::shared_ptr<const scene::Character>& character,
                          const std::shared_ptr<const scene::PoseBank>& bank, const MeshLevelOptions& options);

// Triangles and errors, the largest of all characters; in pixels where a figure is 100 of them tall, and beside what
// meshoptimizer's simplifier states for as many triangles, and is measured to reach. Takes a second a character.
BakeInfo bake_info_of(const std::vector<MeshLevel>& levels);

}  // namespace crowdbench::renderers
