// How small discs are where pixels are larger than what they show: together they cover what the character covers.
#pragma once
#include <span>
#include <vector>

#include "renderers/surfel/surfel_cloud.h"
#include "renderers/surfel/surfel_level.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::renderers {

// The cosine to the viewer below which a disc is shown no narrower, as long as that is under a tenth of a pixel
// (surfel.vert).
inline constexpr float kNarrowest = 0.1F;

struct SurfelArea {
  float thin = 1;    // factor of all discs' radii, (0, 1]
  float uneven = 0;  // how far areas are from the character's: the root mean square over views, of the mean area
};
// For each level the factor with which discs cover as large a part of a picture as the character itself, without its
// masked parts: in the mean over 32 views, from all sides and 0 to 35 degrees above, and poses over all clips. surfels:
// with their reaches. cover: SurfelRule::cover.
std::vector<SurfelArea> fit_areas(const scene::Character& character, const scene::PoseBank& bank,
                                  std::span<const Surfel> surfels, std::span<const SurfelLevel> levels, double cover);

// The longest side of the box around all poses, metres.
float longest_side(const scene::PoseBank& bank);

}  // namespace crowdbench::renderers
