#include "bench/coverage.h"
#include "bench/scene_options.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {

Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context) {
  if (!scenario.occupancy) {
    return {scenario, scene::make_crowd(scenario, cast, scene::stage_view(scenario)), std::nullopt};
  }
  scene::Solved solved = scene::solve_occupancy(scenario, cast, mesh_coverage(context, cast));
  return {solved.scenario, solved.crowd, std::move(solved)};
}

}  // namespace crowdbench::bench
