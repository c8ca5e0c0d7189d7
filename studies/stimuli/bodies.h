// Bodies on the ground: how far apart agents must stand so that nobody stands in anybody else, and whether they do.
//
// A body is the rectangle around all that its character covers in any pose of its clips, seen from above, turned as the
// agent is: a bound, so that rectangles apart are bodies apart.
#pragma once
#include <cstdint>
#include <optional>
#include <utility>

#include "scene/cast/cast.h"
#include "scene/frame/frame.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::studies {

// Metres for crowd.spacing, up to a millimetre: in lanes (and on a grid) bodies of this cast are then apart whatever
// their phase; elsewhere those of neighbours at rest are. At least what a scenario allows.
double spacing_of_bodies(const scene::Scenario& scenario, const scene::Cast& cast);

// The ids of two agents whose bodies touch; nothing where all are apart.
std::optional<std::pair<uint32_t, uint32_t>> touching_bodies(const scene::Frame& frame, const scene::Cast& cast);

}  // namespace crowdbench::studies
