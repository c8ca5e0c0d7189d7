// What is said of levels of detail: triangles, and how far the surface is from the whole mesh's.
#pragma once
#include <span>
#include <string>

#include "core/json.h"
#include "renderers/representation.h"

namespace crowdbench::bench {

// Figures are told errors of in pixels, where nothing else is asked for.
inline constexpr double kLevelFigurePx = 100;

// "mannequin: 500 of 5190 triangles; error 40.6 mm at most (2.32 px of 100), 6.9 mm rms, both ways, over 8 poses, most
// in 'walk'; meshoptimizer: 500 triangles, states 23.6 mm, has 65.5 mm at most, 10.1 mm rms"
std::string level_text(const renderers::LevelInfo& level, double figure_px = kLevelFigurePx);

// A list of:
//   {"character", "triangles", "of_triangles", "max_m", "rms_m": symmetric distance of the surfaces over poses of the
//    clips in use, "figure_px": a figure's height, "max_px": the largest in its pixels, "poses", "worst_clip",
//    "worst_phase": of the pose with the largest,
//    "meshoptimizer": what its simplifier makes, null for a level of the file's own:
//       {"triangles", "stated_m", "max_m", "rms_m"},
//    "note": what could not be had, or null}
Json levels_json(std::span<const renderers::LevelInfo> levels, double figure_px = kLevelFigurePx);

}  // namespace crowdbench::bench
