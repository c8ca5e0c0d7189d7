// A character's mesh with fewer triangles: what its drafts and its levels of detail are made of.
#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

struct SimplifiedMesh {
  Mesh mesh;             // the vertices and primitives of the original, in its order, and fewer indices
  std::string why_more;  // why there are more triangles than were asked for; empty: there are not
};

// The mesh with at most `triangles` triangles, by edges collapsed onto one of their ends, the cheapest first: what is
// drawn are vertices of the original with their own weights, normals and texture coordinates. poses: the positions of
// all vertices in the poses that count, metres, at least one; each counts alike. Every material keeps a triangle,
// borders between materials and texture seams stay closed, faces do not turn over in any of the poses. Deterministic.
// progress: called now and then with the triangles that are gone, of those that are to go; what it throws ends the
// work.
SimplifiedMesh simplify(const Character& character, std::span<const std::vector<glm::vec3>> poses, size_t triangles,
                        const std::function<void(size_t gone, size_t total)>& progress = {});

}  // namespace crowdbench::scene
