// A level of detail of a character's mesh: made once, kept on disk, with what it costs in metres.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "renderers/bake/bake_loader.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"
#include "scene/pose/lod_mesh.h"

namespace crowdbench::renderers {

struct MeshLevelOptions {
  scene::LodRequest request;
  size_t lod = 0;  // of those that the character's file holds; 0: its mesh, or what the request makes of it
  bool is_whole() const { return lod == 0 && request.triangles == 0 && request.ratio == 0 && request.error == 0; }
};

// One level a character, with what became of its bake.
struct MeshLevels {
  std::vector<LevelMesh> levels;
  std::vector<BakeRecord> records;
};

// From the cache, else made, its error measured and kept: half a second of CPU for 5,000 triangles, 4 s for 100,000.
// The options are not those of the whole mesh. Throws Error: a character's file has no such level.
MeshLevels load_mesh_levels(const std::vector<std::shared_ptr<const scene::Character>>& characters,
                            const std::vector<std::shared_ptr<const scene::PoseBank>>& banks,
                            const MeshLevelOptions& options, const BakePolicy& policy);

// Everything that a level and its error depend on: the character, the options, the poses of the clips in use.
std::string mesh_level_key(const scene::Character& character, const scene::PoseBank& bank,
                           const MeshLevelOptions& options);

// Triangles and errors, the largest of all characters; in pixels where a figure is 100 of them tall, and beside what
// meshoptimizer's simplifier states for as many triangles, and is measured to reach. Without the seconds.
BakeInfo bake_info_of(const MeshLevels& levels);

}  // namespace crowdbench::renderers
