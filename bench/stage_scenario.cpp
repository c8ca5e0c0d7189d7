#include <optional>
#include <vector>

#include "bench/scene_options.h"
#include "renderers/capture.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {

Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context) {
  if (!scenario.occupancy) {
    return {scenario, scene::make_crowd(scenario, cast, scene::stage_view(scenario)), std::nullopt};
  }
  renderers::Renderer renderer(context, cast);
  const auto mesh = renderers::make_representation({context, cast}, renderers::parse_spec("mesh"));
  const auto measure = [&](const scene::Frame& frame) {
    const renderers::Capture capture = renderer.capture(frame, *mesh);
    scene::Coverage coverage;
    std::vector<bool> seen(scenario.crowd.agents + 1, false);
    for (const uint32_t id : capture.ids.data) {
      if (id == 0) continue;
      ++coverage.covered_px;
      if (id < seen.size() && !seen[id]) {
        seen[id] = true;
        ++coverage.agents_visible;
      }
    }
    coverage.occupancy = static_cast<double>(coverage.covered_px) / static_cast<double>(capture.ids.pixels());
    return coverage;
  };
  scene::Solved solved = scene::solve_occupancy(scenario, cast, measure);
  return {solved.scenario, solved.crowd, std::move(solved)};
}

}  // namespace crowdbench::bench
