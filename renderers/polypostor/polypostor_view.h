// The polygons of every part in one view of one clip, and which frames' images they carry.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/views/view_grid.h"
#include "renderers/polypostor/polypostor_plan.h"

namespace crowdbench::renderers {

// One key image of one part in one view of one clip.
struct Sheet {
  Fit fit;
  TileRect rect;                  // of the image, texels of level 0
  std::vector<double> costs;      // one a pose: how wrong it looks; where one of several sheets is chosen
  std::vector<double> torn;       // one a pose: torn_area, square texels of the tier's finest level
  std::vector<TilePlane> planes;  // one a pose
  size_t first_tile = 0;          // of the bake's tiles: the tier's finest level; coarser ones follow
};

// What a tier draws of one clip in one view.
struct ViewParts {
  size_t tier = 0, clip = 0, view = 0;
  std::vector<std::vector<Sheet>> sheets;  // by part: none, one, or one a key; empty: nobody sees this view
  std::vector<double> areas;               // by pose: what the figure covers, square texels of the tier's finest level
};

// Gives a view its areas, and of each part the sheets whose keys are chosen as `choice` says: none where the part shows
// less than a texel.
void fit_view(const PolypostorPlan& plan, const ViewBasis& basis, KeyChoice choice, ViewParts& view);

// Which of a part's sheets (at least one) shows the way from pose f to the next.
size_t sheet_for(std::span<const Sheet> sheets, size_t f, size_t frames);

}  // namespace crowdbench::renderers
