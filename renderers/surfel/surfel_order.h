// An order of places on a surface in which every beginning covers the whole of it evenly.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderers/bake/bake_progress.h"

namespace crowdbench::renderers {

struct SurfacePlace {
  glm::vec3 position{0.0F};
  glm::vec3 normal{0.0F, 1.0F, 0.0F};  // unit
};

// How far a disc at `from`, in its plane, must reach to cover `to`: the distance over the cosine between the normals,
// and ten times the distance where that is below a tenth: a disc covers what faces as it does.
float disc_distance(const SurfacePlace& from, const SurfacePlace& to);

struct SurfelOrder {
  std::vector<uint32_t> order;  // of the places: `count` of them, or fewer where there are fewer different ones
  std::vector<float> radius;  // [n]: every place lies within this disc_distance of one of the first n + 1. Never rises
  std::vector<uint32_t> nearest;  // by place: which of `order` (its rank) is nearest to it: the first of several
};
// The first place, then always the one that is farthest from all chosen ones. places: not empty; count: above 0. Takes
// time by places x log(count); the same whatever the machine. progress is told
// about that, at every 256th.
SurfelOrder order_places(std::span<const SurfacePlace> places, size_t count, const BakeProgress& progress = {});

}  // namespace crowdbench::renderers
