// What a scenario needs of a bake of polypostors. A part's key image and polygon are chosen by how they look in all
// frames of the clip, and where an image lies on the pages that all views share decides how it is filtered: so a bake
// is made whole, and what is left out is left out of what is loaded.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "renderers/polypostor/polypostor_bake.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

// Clips x views, clip-major: 1 where one of the view samples that `visit` shows may pick the view.
std::vector<uint8_t> needed_views(const PolypostorBake& bake, const ViewGrid& grid,
                                  const std::function<void(const std::function<void(const ViewSample&)>&)>& visit);

// The bake with the polygons of the needed views alone; the others draw nothing. Pages that hold none of their images
// are left out, the others stay as they are, so that pictures do not change by a bit.
PolypostorBake only_views(const PolypostorBake& whole, const std::vector<uint8_t>& needed);

// Of images and polygons.
uint64_t gpu_bytes(const PolypostorBake& bake);
// Views of clips that draw something.
uint64_t view_count(const PolypostorBake& bake);

}  // namespace crowdbench::renderers
