#include "bench/timing/timed_representation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "bench/stage/coverage.h"
#include "scene/cast/cast.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::bench {

Stage::Stage(gl::Context& context, const scene::Cast& cast)
    : context_(context), cast_(cast), renderer_(context, cast) {}

void Stage::show(const scene::Scenario& scenario, const scene::Crowd& crowd, const scene::Camera& camera) {
  scenario_ = &scenario;
  crowd_ = &crowd;
  camera_ = camera;
  tick_.reset();
}

const scene::Frame& Stage::frame(uint64_t tick) {
  assert(scenario_ != nullptr);
  if (tick_ != tick) {
    frame_ = scene::make_frame(*scenario_, cast_, *crowd_, camera_, tick);
    frame_.ground = false;
    tick_ = tick;
  }
  return frame_;
}

TimedRepresentation::TimedRepresentation(Stage& stage, const renderers::Spec& spec, int width, int height,
                                         uint64_t bake_budget)
    : stage_(stage),
      name_(spec.text()),
      floor_(renderers::is_floor(spec)),
      representation_(renderers::make_representation({stage.context(), stage.cast(), bake_budget}, spec)),
      target_(stage.context(), width, height, renderers::Pass{}) {}

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
  const renderers::Target target(stage_.context(), target_.width(), target_.height(), renderers::Pass{.touched = true});
  stage_.renderer().draw(stage_.frame(tick), *representation_, target);
  const renderers::Capture capture = target.read();
  return static_cast<uint64_t>(
      std::count_if(capture.depth.data.begin(), capture.depth.data.end(), [](float d) { return std::isfinite(d); }));
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

ImageCheck check_pictures(const renderers::Capture& first, const renderers::Capture& second, bool floor,
                          const std::optional<ImageCheck>& reference) {
  ImageCheck check;
  check.covered_px = coverage_of(first.ids).covered_px;
  for (size_t i = 0; i < first.colour.pixels(); ++i)
    if (std::memcmp(first.colour.data.data() + 4 * i, second.colour.data.data() + 4 * i, 3) != 0) ++check.moved_px;
  if (check.covered_px == 0) {
    check.fault = "nothing was drawn";
    return check;
  }
  if (floor) return check;
  if (reference) {
    const auto wanted = static_cast<double>(reference->covered_px);
    const double off = (static_cast<double>(check.covered_px) - wanted) / wanted;
    if (std::abs(off) > kCoverageBound)
      check.fault = fmt::format("covers {} pixels where the reference covers {} ({:+.1f} %, allowed are {:.0f} %)",
                                check.covered_px, reference->covered_px, 100 * off, 100 * kCoverageBound);
  }
  if (check.fault.empty() && check.moved_px == 0) check.fault = "two ticks look the same: the crowd does not move";
  return check;
}

TimingMethod choose_timing_method(gl::Context& context) {
  TimingMethod method;
  const gl::TimerTrust trust = gl::test_gpu_timer(context);
  method.gpu_trusted = trust.trusted && !context.is_software();
  method.gpu_reason = trust.reason;
  method.headline = context.is_software() ? Metric::cpu : method.gpu_trusted ? Metric::gpu : Metric::wall;
  return method;
}

std::optional<GpuTimer> gpu_timer_of(gl::Context& context, const TimingMethod& method) {
  if (!method.gpu_trusted) return std::nullopt;
  auto timer = std::make_shared<gl::GpuTimer>(context);
  return GpuTimer{[timer] { timer->begin(); },
                  [timer] {
                    timer->end();
                    return static_cast<int64_t>(timer->elapsed_ns());
                  }};
}

scene::Solved solve_scene(gl::Context& context, const scene::Scenario& scenario, const scene::Cast& cast) {
  if (scenario.occupancy) return scene::solve_occupancy(scenario, cast, mesh_coverage(context, cast));
  scene::Solved solved;
  solved.scenario = scenario;
  solved.camera = scenario.camera.at(0);
  solved.crowd = scene::make_crowd(scenario, cast, scene::stage_view(scenario));
  const scene::Frame frame = scene::make_frame(scenario, cast, solved.crowd, solved.camera, 0);
  solved.achieved = mesh_coverage(context, cast)(frame).occupancy;
  const scene::OnScreen seen = scene::count_on_screen(scenario, cast, solved.crowd, solved.camera, 0);
  solved.agents_wholly = seen.wholly;
  solved.agents_partly = seen.partly;
  solved.agents_off = seen.off;
  solved.measurements = 1;
  return solved;
}

LowPolygonCast low_polygon_cast(const scene::Scenario& scenario, const scene::Crowd& crowd) {
  LowPolygonCast low{scenario, {}, crowd};
  for (scene::CharacterEntry& entry : low.scenario.characters) {
    entry = {.source = "mannequin:triangles=500", .height = entry.height.value_or(1.75), .share = entry.share};
  }
  low.cast = scene::load_cast(low.scenario);
  for (size_t i = 0; i < low.crowd.size(); ++i) {
    const auto& bank = *low.cast.banks[low.crowd.character[i]];
    low.crowd.bank_clip[i] = std::min<uint16_t>(low.crowd.bank_clip[i], static_cast<uint16_t>(bank.clips().size() - 1));
  }
  return low;
}

std::string cast_name(const scene::Cast& cast) {
  std::string name;
  for (const auto& character : cast.characters) name += (name.empty() ? "" : " + ") + character->name;
  return name;
}

}  // namespace crowdbench::bench
