// Coverage measured as the occupancy solver wants it: the mesh drawn with ids, pixels counted.
#pragma once
#include <memory>

#include "renderers/gl/context.h"
#include "scene/occupancy.h"

namespace crowdbench::bench {

// What the ids of a capture cover.
scene::Coverage coverage_of(const ImageU32& ids);

// Draws with `mesh` at the frame's size, one sample a pixel. `context` and `cast` must outlive the result.
scene::MeasureCoverage mesh_coverage(gl::Context& context, const scene::Cast& cast);

}  // namespace crowdbench::bench
