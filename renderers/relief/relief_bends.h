// Boxes between joints: where skin bends, a box that follows one joint alone leaves the skin. A box that follows a
// weighted mean of a joint's and its parent's matrices, as the skin there does, stays with it.
#pragma once
#include <cstddef>
#include <vector>

#include "renderers/relief/relief_pieces.h"

namespace crowdbench::renderers {

struct BendOptions {
  TriangleRule rule = TriangleRule::threshold;
  double threshold = 1.2;
  double deviation = 0;  // metres, above 0: boxes are added where skin deviates farther from its own, root mean square
  size_t most = 96;      // pieces, the joints' own among them
};

// Pieces that follow joints, and blends of a joint and its parent in eighths: those are added that bring the skin
// nearest in the poses of a bank, one by one. A triangle goes to the piece that carries it best, and to further ones so
// that no gap opens between boxes: those that `rule` would give it to if joints were where the pieces are, and those
// next to it that carry it within `deviation`. Deterministic; throws nothing.
std::vector<Piece> bend_pieces(const scene::Character& character, const scene::PoseBank& bank,
                               const CapturePose& capture, const BendOptions& options);

}  // namespace crowdbench::renderers
