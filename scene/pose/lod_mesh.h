// Levels of detail: a character's mesh with fewer triangles, made for the poses of the clips in use and judged by them.
#pragma once
#include <cstddef>
#include <functional>
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
// progress: called now and then; what it throws ends the work.
using LodProgress = std::function<void(size_t done, size_t total)>;
LodMesh make_lod_mesh(const Character& character, const PoseBank& bank, const LodRequest& request,
                      const LodProgress& progress = {});

// The character with another mesh; everything else is its own.
Character with_mesh(const Character& character, Mesh mesh);

// How far a mesh is from the character's own, posed alike, in poses of the clips in use between those that
// make_lod_mesh was shown: symmetric distances of surfaces (surface_distance), metres at scale 1.
struct LodError {
  double max = 0;     // the largest of all poses
  double rms = 0;     // over all poses
  int bank_clip = 0;  // of the pose with the largest
  double phase = 0;   // of it
  size_t poses = 0;   // 8, or one a clip where there are more clips, 24 at most; of large meshes fewer
  size_t places = 0;  // from which a distance was measured, in all poses
};
// However large the mesh: at most kMostLodTriangles, counted once a pose (but one pose at least), and corners of each
// of the two surfaces likewise. Where they are more, each corner is looked at in some of the poses. The same every
// time, whatever the number of threads.
inline constexpr size_t kMostLodTriangles = 4'000'000;
inline constexpr size_t kMostLodCorners = 400'000;
LodError lod_error(const Character& character, const Mesh& mesh, const PoseBank& bank);

// What meshoptimizer makes of the same mesh in the first pose, for comparison: it may stop at more triangles than it
// was asked for, where vertices of one place differ in their attributes.
struct MeshoptimizerMesh {
  Mesh mesh;
  double stated_error = 0;  // metres, as it states it
};
MeshoptimizerMesh meshoptimizer_mesh(const Character& character, const PoseBank& bank, size_t triangles);

}  // namespace crowdbench::scene
