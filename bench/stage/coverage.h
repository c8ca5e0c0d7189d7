// Coverage measured as the occupancy solver wants it: the mesh drawn with ids, pixels counted.
#pragma once
#include <memory>

#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/crowd/occupancy.h"

namespace crowdbench::bench {

// What the ids of a capture cover.
scene::Coverage coverage_of(const ImageU32& ids);

// Draws with `mesh` at the frame's size, one sample a pixel. `context` and `cast` must outlive the result.
scene::MeasureCoverage mesh_coverage(gl::Context& context, const scene::Cast& cast);

// Solves scenario.occupancy with the mesh. From 300 agents on the search is done with characters of 500 triangles, and
// the mesh measures what it finds: the achieved value is the mesh's own in every case.
scene::Solved solve_with_mesh(gl::Context& context, const scene::Scenario& scenario, const scene::Cast& cast);

}  // namespace crowdbench::bench
