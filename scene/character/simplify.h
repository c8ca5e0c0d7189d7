// A character's mesh with fewer triangles: what its drafts and its levels of detail are made of.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
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

// The same for every number of triangles, from one run: each is a moment on the way to the fewest.
class Simplification {
 public:
  // As far as that goes, to `least` triangles. character and poses must outlive this; progress as above.
  Simplification(const Character& character, std::span<const std::vector<glm::vec3>> poses, size_t least,
                 const std::function<void(size_t gone, size_t total)>& progress = {});
  ~Simplification();
  Simplification(const Simplification&) = delete;
  Simplification& operator=(const Simplification&) = delete;

  // What `simplify` makes of so many triangles, `least` at the fewest: the same indices.
  SimplifiedMesh at(size_t triangles) const;

 private:
  struct Steps;
  std::unique_ptr<Steps> steps_;
};

}  // namespace crowdbench::scene
