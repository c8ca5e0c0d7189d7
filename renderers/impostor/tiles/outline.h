// Outlines: convex polygons of few corners around a tile's silhouette, so that a quad's empty texels are not shaded.
#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "renderers/impostor/tiles/tile.h"

namespace crowdbench::renderers {

// Corners in lattice coordinates of the tile's level (texels, y up), in the order of a triangle strip: 0 1 2, 1 2 3,
// ... cover the polygon once (windings alternate; draw without face culling). Exactly `corners` of them; polygons with
// fewer repeat the last. Every point whose filtered alpha is at least one half lies inside; no corner lies more than
// one texel outside the tile's rectangle, so that nothing beyond the tile's gutter and its neighbour's is ever
// filtered. corners: 4..16. An empty tile gives corners that all coincide.
std::vector<glm::vec2> tile_outline(const Tile& tile, int corners);

// The same in one triangle, for small pictures, of which most cost lies in the blocks of pixels that a polygon touches:
// it has no inner edge along which blocks are shaded twice, and one set-up instead of two. Of those triangles whose
// sides all touch the silhouette the one that touches the fewest blocks of 4 x 4 texels at a random place. It reaches
// far beyond the tile's rectangle: clamp what is sampled to the gutter, where alpha is below one half.
std::vector<glm::vec2> tile_triangle(const Tile& tile);

// The tile's rectangle as such a strip (what an untrimmed quad covers is the caller's own).
std::vector<glm::vec2> rectangle_strip(const glm::vec2& low, const glm::vec2& high);

double polygon_area(const std::vector<glm::dvec2>& counter_clockwise);

}  // namespace crowdbench::renderers
