#include "bench/timing/timed_representation.h"

#include <algorithm>

#include "bench/stage/coverage.h"

namespace crowdbench::bench {

TimedRepresentation::TimedRepresentation(Stage& stage, const renderers::Spec& spec, const scene::Scenario& scenario,
                                         uint64_t bake_budget)
    : stage_(stage),
      name_(spec.text()),
      floor_(renderers::is_floor(spec)),
      representation_(renderers::make_representation({stage.context(), stage.cast(), bake_budget}, spec)),
      target_(stage.context(), scenario.width * scenario.antialiasing.supersample,
              scenario.height * scenario.antialiasing.supersample,
              renderers::Pass{.samples = scenario.antialiasing.samples}) {}

Variant TimedRepresentation::variant() {
  return {name_, [this](uint64_t tick) { stage_.frame(tick); },
          [this] {
            stage_.renderer().draw(stage_.latest(), *representation_, target_);
            stage_.renderer().finish();
          }};
}

renderers::Capture TimedRepresentation::capture(uint64_t tick) {
  return stage_.renderer().capture(stage_.frame(tick), *representation_);
}

uint64_t TimedRepresentation::touched_px(uint64_t tick) {
  return touched_pixels(stage_.context(), stage_.renderer(), stage_.frame(tick), *representation_);
}

gl::PipelineCounts TimedRepresentation::count(uint64_t tick) {
  gl::PipelineCounter counter(stage_.context());
  const scene::Frame& frame = stage_.frame(tick);
  counter.begin();
  stage_.renderer().draw(frame, *representation_, target_);
  counter.end();
  stage_.renderer().finish();
  return counter.result();
}

}  // namespace crowdbench::bench
