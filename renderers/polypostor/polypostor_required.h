// What a scenario needs of a bake of polypostors. A part's key image and polygon are chosen by how they look in all
// frames of the clip, and images of all views share pages: so a bake is made whole, and the views of clips that nobody
// sees are left out of what is loaded.
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

// The bake with the needed views alone; the others draw nothing. Every image keeps its place on a page of the same
// size, so that it is filtered as before and pictures do not change by a bit; pages are fewer.
PolypostorBake only_views(const PolypostorBake& whole, const std::vector<uint8_t>& needed);

// Views of clips that draw something.
uint64_t view_count(const PolypostorBake& bake);

}  // namespace crowdbench::renderers
