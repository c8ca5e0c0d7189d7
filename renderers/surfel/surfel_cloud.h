// SurfelCloud: a character's surface as points in an order of which every beginning covers it.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "renderers/surfel/surfel_level.h"
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
  // Metres in the bank's first pose to where the surface ends (find_reaches); infinite: nowhere near.
  float reach = std::numeric_limits<float>::infinity();
  uint8_t slot = 0;
  bool unlit = false, double_sided = false;
};

struct SurfelCloud {
  std::vector<Surfel> surfels;
  // With the factors of reaches and areas. Radii are metres at scale 1, in the bank's first pose. Empty where nothing
  // of the character is there.
  std::vector<SurfelLevel> levels;
};

// count: at most so many surfels, above 0. Candidates, eight for each, lie evenly by area in the bank's first pose;
// where a mask cuts the surface out there are none. A surfel has the mean colour of the candidates nearest to it.
// cover: SurfelRule::cover, for the levels' factors. progress: of the ordering, which takes most of the time.
SurfelCloud make_surfel_cloud(const scene::Character& character, const scene::PoseBank& bank, size_t count,
                              double cover, const BakeProgress& progress = {});

// In a pose: place and unit normal by the matrices of its joints, all else as it is.
Surfel in_pose(Surfel surfel, std::span<const scene::Mat3x4> palette);

// Whether a mask leaves a place of a triangle. corners: of the mesh; at: barycentric.
bool is_there(const scene::Character& character, const scene::Primitive& primitive,
              const std::array<uint32_t, 3>& corners, const glm::vec3& at);

}  // namespace crowdbench::renderers
