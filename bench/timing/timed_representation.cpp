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

void TimedRepresentation::put_footprint(MeasurementRow& row) const {
  const renderers::Footprint footprint = representation_->footprint();
  row.texture_bytes = footprint.texture_bytes;
  row.buffer_bytes = footprint.buffer_bytes;
  row.upload_bytes_per_frame = footprint.upload_bytes_per_frame;
  const renderers::BakeInfo bake = representation_->bake_info();
  if (const double cold = renderers::cold_seconds(bake); cold > 0) row.bake_seconds = cold;
  if (!bake.cache_key.empty()) {
    row.disk_bytes = footprint.disk_bytes;
    if (bake.cached) row.bake_load_seconds = bake.seconds;
    row.bake_cached = bake.cached;
  }
  row.shared_bytes = stage_.renderer().shared_bytes();
  uint64_t triangles = 0;
  for (size_t c = 0; c < stage_.cast().characters.size(); ++c)
    triangles = std::max(triangles, representation_->triangles(c));
  row.triangles_per_agent = triangles;
}

}  // namespace crowdbench::bench
