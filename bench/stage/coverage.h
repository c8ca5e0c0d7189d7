// Pixels counted: those that agents cover, as the occupancy solver wants it, and those that a draw touches.
#pragma once
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/crowd/occupancy.h"

namespace crowdbench::bench {

// What the ids of a capture cover.
scene::Coverage coverage_of(const ImageU32& ids);

// Draws with `mesh` at the frame's size, one sample a pixel and no ground (which would hide what stands below it).
// `context` and `cast` must outlive the result.
scene::MeasureCoverage mesh_coverage(gl::Context& context, const scene::Cast& cast);

// Pixels that any fragment of the frame reaches, discarded or not (an impostor's boxes and polygons, not its figures):
// measured by a draw of its own (Pass::touched), at the frame's size. frame: without a ground, which touches too.
uint64_t touched_pixels(gl::Context& context, renderers::Renderer& renderer, const scene::Frame& frame,
                        renderers::Representation& representation);

}  // namespace crowdbench::bench
