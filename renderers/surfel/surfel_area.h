// How small discs may be: together they cover what the character covers, or as little more as closes the surface.
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

// Of the samples inside of a character's outline that whole discs reach, the share that `closed` may leave open in any
// view.
inline constexpr double kHoles = 0.001;

struct SurfelArea {
  float thin = 1;    // factor of all discs' radii, (0, 1], with which they cover as much as the character
  float uneven = 0;  // how far areas are from the character's then: the root mean square over views, of the mean area
  float closed = 1;  // the least factor, [thin, 1], that leaves no more open than kHoles
  float over = 0;    // by how much of the character's area discs cover more then
};
// For each level, from the parts of pictures that discs and the character itself, without its masked parts, cover: in
// the mean over 32 views, from all sides and 0 to 35 degrees above, and poses over all clips. surfels: with their
// reaches. cover: SurfelRule::cover.
std::vector<SurfelArea> fit_areas(const scene::Character& character, const scene::PoseBank& bank,
                                  std::span<const Surfel> surfels, std::span<const SurfelLevel> levels, double cover);

// The longest side of the box around all poses, metres.
float longest_side(const scene::PoseBank& bank);

}  // namespace crowdbench::renderers
