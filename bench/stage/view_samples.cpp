#include "bench/stage/view_samples.h"

#include <algorithm>
#include <cmath>

#include "core/progress.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {

uint64_t required_ticks(const scene::Scenario& scenario) {
  constexpr double kLeastSeconds = 10;
  constexpr double kMost = 3000;
  const double path = scenario.camera.keys.empty() ? 0.0 : scenario.camera.keys.back().time;
  return static_cast<uint64_t>(std::min(std::ceil(std::max(path, kLeastSeconds) * scenario.tick_rate) + 1, kMost));
}

renderers::VisitViewSamples view_samples_of(const scene::Scenario& scenario, const scene::Cast& cast,
                                            const scene::Crowd& crowd, uint64_t ticks) {
  return [&scenario, &cast, &crowd, ticks](size_t character,
                                           const std::function<void(const renderers::ViewSample&)>& see) {
    for (uint64_t tick = 0; tick < ticks; ++tick) {
      throw_if_interrupted();
      const scene::Camera camera = scenario.camera.at(static_cast<double>(tick) / scenario.tick_rate);
      const scene::Frame frame = scene::make_frame(scenario, cast, crowd, camera, tick);
      for (const scene::FrameAgent& a : frame.agents[character]) {
        // Positions are relative to the eye; the agent's heading is turned back.
        const glm::vec3 d = -a.position / a.scale;
        see({{a.heading.y * d.x - a.heading.x * d.z, d.y, a.heading.x * d.x + a.heading.y * d.z},
             a.bank_clip,
             a.phase});
      }
    }
  };
}

}  // namespace crowdbench::bench
