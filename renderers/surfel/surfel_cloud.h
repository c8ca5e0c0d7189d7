// SurfelCloud: a character's surface as points in an order of which every beginning covers it.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// A point of the surface, in bind space as the mesh's vertices are.
struct Surfel {
  glm::vec3 position{0.0F};
  glm::vec3 normal{0.0F, 1.0F, 0.0F};  // unit
  glm::u16vec4 joints{0};
  glm::vec4 weights{1.0F, 0.0F, 0.0F, 0.0F};  // of the corners', the four largest; sum 1
  glm::vec3 colour{1.0F};                     // linear, before the outfit
  glm::vec3 emissive{0.0F};                   // linear
  uint8_t slot = 0;
  bool unlit = false, double_sided = false;
};

struct SurfelCloud {
  std::vector<Surfel> surfels;
  // [n]: metres at scale 1, in the bank's first pose: discs of this radius about the first n + 1 surfels reach every
  // candidate (SurfelOrder::radius). Empty where nothing of the character is there.
  std::vector<float> radius;
};

// count: at most so many surfels, above 0. Candidates, eight for each, lie evenly by area in the bank's first pose;
// where a mask cuts the surface out there are none. A surfel has the mean colour of the candidates nearest to it.
// progress: of the ordering, which takes nearly all the time.
SurfelCloud make_surfel_cloud(const scene::Character& character, const scene::PoseBank& bank, size_t count,
                              const BakeProgress& progress = {});

}  // namespace crowdbench::renderers
