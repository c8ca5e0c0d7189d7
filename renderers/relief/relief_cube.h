// projection=cube: what a box's six faces see from the box's middle, as the six sides of a cube map see from its.
#pragma once
#include <cstddef>
#include <vector>

#include "renderers/relief/relief_capture.h"

namespace crowdbench::renderers {

// The box's part of the model's maps of the face on one side (0: the low one) of an axis: in each texel, of the ray
// from the middle through the texel, how far out it meets the skin first and last. Depths in [0, 1]: of the way from
// the middle to the face. 0 in place of the first where the skin is met from inside there: the ray comes out of the
// body. Skin with two sides counts as a sheet, which has no inside. What lies within a thousandth of the way is not
// seen.
void capture_cube_face(const CaptureSource& source, const BoxSpace& space, const std::vector<Skirt>& all, size_t box,
                       int axis, int side, ReliefModel& model);

}  // namespace crowdbench::renderers
