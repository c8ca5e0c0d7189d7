#include "bench/stage/stage_facts.h"

#include <algorithm>
#include <cmath>

#include "bench/stage/coverage.h"
#include "bench/stage/stage.h"
#include "core/json.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {

StageFacts measure_stage(const Staged& staged, const scene::Cast& cast, gl::Context& context) {
  Stage stage(context, cast);
  stage.show(staged);
  const auto mesh = renderers::make_representation({context, cast}, renderers::reference_spec());
  scene::Frame frame = stage.frame(0);
  frame.antialiasing = {};  // what is counted is seen at the pixels' centres
  StageFacts facts;
  facts.scenario = staged.scenario;
  facts.coverage = coverage_of(stage.renderer().capture(frame, *mesh).ids);
  facts.touched_px = touched_pixels(context, stage.renderer(), frame, *mesh);
  const std::optional<double>& requested = staged.scenario.occupancy;
  facts.unreachable = requested && scene::misses_occupancy(*requested, facts.coverage.occupancy);
  facts.on_screen = scene::count_on_screen(staged.scenario, cast, staged.crowd, staged.camera, 0);
  return facts;
}

Json stage_json(const StageFacts& facts) {
  const scene::Scenario& scenario = facts.scenario;
  return {{"width", scenario.width},
          {"height", scenario.height},
          {"samples", scenario.antialiasing.samples},
          {"supersample", scenario.antialiasing.supersample},
          {"seed", scenario.seed},
          {"camera", scene::table_json(scenario, "camera")},
          {"crowd", scene::table_json(scenario, "crowd")},
          {"requested_occupancy", scenario.occupancy ? Json(*scenario.occupancy) : Json(nullptr)},
          {"achieved_occupancy", facts.coverage.occupancy},
          {"unreachable", facts.unreachable},
          {"covered_px", facts.coverage.covered_px},
          {"touched_px", facts.touched_px},
          {"agents_visible", facts.coverage.agents_visible},
          {"agents_on_screen",
           {{"wholly", facts.on_screen.wholly}, {"partly", facts.on_screen.partly}, {"off", facts.on_screen.off}}}};
}

}  // namespace crowdbench::bench
