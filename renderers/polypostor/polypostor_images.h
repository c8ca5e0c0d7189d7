// The key images of a bake of polypostors: captured, at every level of their tier, and packed into pages.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderers/impostor/tiles/packing.h"
#include "renderers/impostor/tiles/tile.h"
#include "renderers/polypostor/polypostor_view.h"

namespace crowdbench::renderers {

// About the bytes that one image of a tier takes on the pages, at all levels. width, height: texels of level 0.
uint64_t image_bytes(const PolypostorPlan& plan, const PolypostorTier& tier, int width, int height);
// The same of the images of these views together.
uint64_t image_bytes(const PolypostorPlan& plan, std::span<const ViewParts> views);

// The tiles of every sheet, whose first_tile it sets. Each part is drawn alone, from both sides: where it is cut off
// its inside shows, and closes what would be a gap when its neighbour moves away. threads: as parallel_for; the bytes
// do not depend on it. progress: the share that is done.
std::vector<Tile> capture_images(gl::Context& context, const PolypostorPlan& plan, const ViewGrid& grid,
                                 std::span<ViewParts> views, unsigned threads,
                                 const std::function<void(double done)>& progress);

// Packs the tiles into the pages of the bake, in layers of the size that wastes least. Returns where each lies without
// its gutter.
std::vector<PackPlace> pack_images(std::span<const Tile> tiles, PolypostorBake& bake);

}  // namespace crowdbench::renderers
