// Motion between two stored frames: where, in the pictures of both, lies what a view shows half-way between them.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/views/view_grid.h"

namespace crowdbench::renderers {

// A view's lattice of one level (renderers/impostor/tiles/tile.h).
struct MotionLattice {
  glm::dvec3 centre{0.0};  // that the capture plane goes through: metres, model space
  ViewBasis basis;
  double texel = 0;  // metres, of the level
};

// The surface that a view shows of a posed mesh, at the centres of texels.
struct ShownSurface {
  TileRect rect;
  std::vector<int> triangle;                 // by texel, bottom row first; -1: nothing
  std::vector<float> depth;                  // metres over the capture plane towards the eye
  std::vector<std::array<float, 2>> weight;  // of the triangle's second and third corner
  bool covers(int x, int y) const;           // false outside of the rectangle
};
// positions: of one pose, model space. The nearest triangle counts, whichever side it shows; cut-outs count as solid.
ShownSurface shown_surface(const std::vector<glm::vec3>& positions, const std::vector<uint32_t>& indices,
                           const MotionLattice& lattice);

// A character in two stored frames and half-way between them; as many positions in each.
struct MotionPoses {
  const std::vector<glm::vec3>& earlier;
  const std::vector<glm::vec3>& half_way;
  const std::vector<glm::vec3>& later;
  const std::vector<uint32_t>& indices;
};

// One RGBA8 texel for each of `rect`, bottom row first: of the point that is shown there half-way, its displacement to
// where it is in the earlier frame (R, G: x, y) and in the later one (B, A), in 63rds (x) and 127ths (y) of `range`.
// R and B are twice 64 plus x, plus 1 where the point is hidden in that frame but not in the other; G and A are
// encode_signed's. Where nothing is shown half-way, what the nearest texel that shows something has, and beyond its
// neighbours as hidden in both frames, which says that there is nothing. range: metres, above 0.
std::vector<uint8_t> motion_texels(const MotionPoses& poses, const MotionLattice& lattice, const TileRect& rect,
                                   double range);

// What a texel of the above says.
struct Motion {
  glm::dvec2 metres{0.0};
  bool hidden = false;
};
Motion decode_motion(uint8_t x, uint8_t y, double range);

// Where no vertex goes farther than this between a pose and the next: metres.
double largest_step(const std::vector<glm::vec3>& from, const std::vector<glm::vec3>& to);

}  // namespace crowdbench::renderers
