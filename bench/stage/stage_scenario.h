// From a scenario to a crowd in front of a camera, for all commands.
//
// Every command that shows or measures a scenario comes through here, so that a picture and a timing of one scenario
// show the same agents from the same place. What stands there in figures: stage_facts.h.
#pragma once
#include <optional>

#include "bench/stage/low_polygon.h"
#include "scene/cast/cast.h"
#include "scene/crowd/crowd.h"
#include "scene/crowd/occupancy.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::bench {

// A crowd in front of a camera.
struct Staged {
  // As given, or as solved: then with one view, and the stage and spacing that were found.
  scene::Scenario scenario;
  scene::Crowd crowd;
  scene::Camera camera;  // the scenario's at tick 0; solved for an occupancy it stands still
  // Absent where the scenario asks for no occupancy, or has no agents to cover anything with.
  std::optional<scene::OccupancySearch> solved;
};

// cast: of this scenario (scene::load_cast). An occupancy asked for is solved by drawing the mesh at the scenario's
// size, at tick 0 and without a ground, whatever the scenario says of its ground and its representation: neither may
// move the camera. The search draws the characters simplified to kDraftTriangles where there are at least kDraftAgents
// of them and one has more triangles than that; the mesh itself measures what was found and corrects it, so that
// OccupancySearch::achieved is the mesh's own in every case.
// Deterministic on one machine and driver. Without an occupancy nothing is drawn. Throws Error.
Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context);
// The same of a scenario that asks for no occupancy: no driver is needed.
Staged stage_as_given(const scene::Scenario& scenario, const scene::Cast& cast);
// Whether an occupancy has to be solved, by drawing.
bool must_solve(const scene::Scenario& scenario);
inline constexpr uint32_t kDraftAgents = 300;  // fewer are quick enough as they are
inline constexpr size_t kDraftTriangles = kLowPolygonTriangles;

}  // namespace crowdbench::bench
