// Levels of detail: a character's mesh with fewer triangles, made for the poses of the clips in use and judged by them.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/character/surface_distance.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::scene {

// One of the three says how coarse; the others are 0.
struct LodRequest {
  size_t triangles = 0;  // at most so many
  double ratio = 0;      // (0, 1]: at most this share of the character's
  double error = 0;      // metres: as few as keep the largest error of lod_error within this
};

struct LodMesh {
  Mesh mesh;             // draws with the character's skeleton, materials and palettes
  std::string why_more;  // why it has more triangles than were asked for, or a larger error; empty: it has not
};
LodMesh make_lod_mesh(const Character& character, const PoseBank& bank, const LodRequest& request);

// The character with another mesh; everything else is its own.
Character with_mesh(const Character& character, Mesh mesh);

// How far a mesh is from the character's own, posed alike, in poses of the clips in use between those that
// make_lod_mesh was shown. Metres at scale 1.
struct LodError {
  SurfaceDistance distance;  // over all poses
  int bank_clip = 0;         // of the pose with the largest
  double phase = 0;
  size_t poses = 0;
};
LodError lod_error(const Character& character, const Mesh& mesh, const PoseBank& bank);

// What meshoptimizer makes of the same mesh in the first pose, for comparison: it may stop at more triangles than it
// was asked for, where vertices of one place differ in their attributes.
struct MeshoptimizerMesh {
  Mesh mesh;
  double stated_error = 0;  // metres, as it states it
};
MeshoptimizerMesh meshoptimizer_mesh(const Character& character, const PoseBank& bank, size_t triangles);

}  // namespace crowdbench::scene
