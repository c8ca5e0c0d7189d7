// Where pieces end: how far each reaches into its neighbours', chosen by what the clips in use tear.
#pragma once
#include <array>
#include <vector>

#include "renderers/impostor/views/view_grid.h"
#include "renderers/perjoint/perjoint_pieces.h"

namespace crowdbench::renderers {

// Shares of weight that a piece may end at, widest overlap last.
inline constexpr std::array<float, 6> kBorders = {0.5F, 0.4F, 0.3F, 0.2F, 0.1F, 0.05F};

struct BorderChoice {
  std::vector<float> borders;  // by piece, of kBorders
  // Per mille of the pieces' own pixels, over the poses and views tried: what of a piece's surface nothing shows, and
  // what a piece shows where neither it nor a neighbour is. With the chosen borders, and with all at 0.5 (cuts alone).
  double holes = 0, strays = 0;
  double holes_cut = 0, strays_cut = 0;
};

// Draws the silhouettes of all pieces with every border of kBorders, laid on the planes of their nearest views and
// moved as their joints are, in poses of every clip of the bank, from four sides, and changes one piece's border at a
// time to that with the smallest error until none changes (four rounds at most). Error: pixels that lack, twice, and
// pixels too many; a hole shows what is behind the figure, a stray only more of it. Deterministic. threads: as
// parallel_for.
BorderChoice choose_borders(const scene::Character& character, const scene::PoseBank& bank, const RestPose& rest,
                            const JointPieces& pieces, const ViewGrid& grid, unsigned threads);

}  // namespace crowdbench::renderers
