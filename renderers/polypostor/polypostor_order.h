// Which part lies before which. Each part is drawn on one plane, and planes cut through each other where surfaces do
// not: they are moved towards the eye or away from it until what is drawn in front is what lies in front.
#pragma once
#include <glm/glm.hpp>
#include <span>

#include "renderers/polypostor/polypostor_plan.h"

namespace crowdbench::renderers {

// Where the plan's eye has to see a corner of a part's plane, so that it lies at p (texels of level 0) on the plane
// through the centre: texels, and metres towards the eye.
glm::dvec3 on_plane(const PolypostorPlan& plan, const TilePlane& plane, const glm::dvec2& p);

// Metres: the unit in which depths of corners are stored.
double depth_unit(const PolypostorPlan& plan);

// Moves the planes of a tier's parts in one pose of one view by whole depth units, kMostOrderUnits at most. positions:
// by vertex, the tier's texels where the eye sees them, z towards it. planes: by part. A texel is wrong where another
// part's plane is in front than the part whose surface, seen from its outside, is; each unit has to mend some.
inline constexpr int kMostOrderUnits = 8;
void order_planes(const PolypostorPlan& plan, const PolypostorTier& tier, std::span<const glm::dvec3> positions,
                  std::span<TilePlane> planes);

}  // namespace crowdbench::renderers
