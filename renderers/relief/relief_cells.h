// Cells of skin: patches of a character's surface that one box each can carry without tearing. What belongs to two
// joints follows both, since a box is moved by the sum of its joints' matrices, each with a weight that changes
// linearly over the box; where skin bends by more than that, the patch is cut in two.
#pragma once
#include <cstddef>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "renderers/relief/relief_pieces.h"

namespace crowdbench::renderers {

struct CellOptions {
  double tolerance = 0;  // metres, above 0: how far a corner may be from where the skin puts it, in any pose
  double skirt = 0;      // metres: what a cell also captures of the triangles next to it
  double texel = 0;      // metres: texels that cells cut from a joint's skin make do with
  size_t most = 256;     // cells
};

struct Cells {
  std::vector<Piece> pieces;
  double loose = 0;      // of the skin's area: in cells of which a corner deviates by more than the tolerance
  double deviation = 0;  // metres: the farthest that a corner is from where the skin puts it, in the poses looked at
};

// Every triangle that a joint moves is in one cell; at first those of a joint (its carrier's), then the cells that
// deviate most are cut until none deviates more than the tolerance or there are `most`. Looks at up to 16 poses of the
// bank. Deterministic; throws what progress does, which counts twice the cells that there may be.
Cells skin_cells(const scene::Character& character, const scene::PoseBank& bank, const CapturePose& capture,
                 const Carriers& carriers, const CellOptions& options, const BakeProgress& progress = {});

}  // namespace crowdbench::renderers
