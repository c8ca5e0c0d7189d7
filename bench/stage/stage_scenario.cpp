#include "bench/stage/stage_scenario.h"

#include "bench/stage/coverage.h"

namespace crowdbench::bench {

Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context) {
  if (!scenario.occupancy || scenario.crowd.agents == 0) {
    return {scenario, scene::make_crowd(scenario, cast, scene::stage_view(scenario)), std::nullopt};
  }
  scene::Solved solved = solve_with_mesh(context, scenario, cast);
  return {solved.scenario, solved.crowd, std::move(solved)};
}

}  // namespace crowdbench::bench
