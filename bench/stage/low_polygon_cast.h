// The crowd of a stage played by few triangles.
#pragma once
#include "bench/stage/stage_scenario.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {

// Every character replaced by the built-in one with 500 triangles, of the same height: what a user would reach for
// instead of an impostor. Each figure of speed against the mesh is also told against it.
struct LowPolygonCast {
  scene::Cast cast;
  Staged staged;  // of this cast: agents, places, clips (where the built-in character has as many) and camera as before
};
LowPolygonCast low_polygon_cast(const Staged& staged);

}  // namespace crowdbench::bench
