#include "bench/experiments/ratio.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "bench/stage/low_polygon.h"
#include "bench/stage/stage.h"
#include "bench/timing/timed_representation.h"
#include "bench/timing/timing_method.h"
#include "core/error.h"
#include "core/progress.h"

namespace crowdbench::bench {
namespace {

// All that takes turns, each at one place of `all`. A representation asked for may be the mesh or its floor itself; but
// `of` and `to` are always drawn apart, so that a representation against itself tells the noise of the method.
struct TimedSet {
  std::vector<std::unique_ptr<TimedRepresentation>> all;
  size_t of = 0, to = 0, mesh = 0, mesh_floor = 0, low_polygon = 0, mesh_again = 0;
};

TimedSet bake_set(Stage& stage, const RatioRequest& request, Progress& progress) {
  TimedSet set;
  const auto enter = [&](const renderers::Spec& spec) {
    progress.note("baking " + spec.text());
    set.all.push_back(std::make_unique<TimedRepresentation>(stage, spec, request.scenario, request.bake_budget));
    return set.all.size() - 1;
  };
  set.of = enter(request.of);
  set.to = enter(request.to);
  const auto known_or_entered = [&](const renderers::Spec& spec) {
    for (const size_t i : {set.of, set.to})
      if (set.all[i]->name() == spec.text()) return i;
    return enter(spec);
  };
  const renderers::Spec mesh = renderers::reference_spec();
  set.mesh = known_or_entered(mesh);
  set.mesh_floor = known_or_entered(renderers::with_floor(mesh));
  set.low_polygon = known_or_entered(low_polygon_spec());
  set.mesh_again = enter(mesh);
  return set;
}

void check_set(RatioReport& report, const TimedSet& set) {
  const auto check = [&](size_t i, const std::optional<ImageCheck>& reference) {
    TimedRepresentation& timed = *set.all[i];
    return check_pictures(timed.capture(0), timed.capture(kSecondTick), timed.is_floor(), reference);
  };
  report.mesh_check = check(set.mesh, std::nullopt);
  report.of_check = set.of == set.mesh ? report.mesh_check : check(set.of, report.mesh_check);
  report.to_check = set.to == set.mesh ? report.mesh_check : check(set.to, report.mesh_check);
  for (const auto& [name, fault] :
       {std::pair{report.of, report.of_check.fault}, std::pair{report.to, report.to_check.fault},
        std::pair{renderers::reference_spec().text(), report.mesh_check.fault}}) {
    const std::string line = name + ": " + fault;
    if (!fault.empty() && std::find(report.faults.begin(), report.faults.end(), line) == report.faults.end())
      report.faults.push_back(line);
  }
  report.valid = report.faults.empty();
}

uint64_t triangles_of(renderers::Representation& representation, const scene::Cast& cast) {
  uint64_t sum = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) sum += representation.triangles(c);
  return sum;
}

void put_triangles(RatioReport& report, const TimedSet& set, const scene::Cast& cast) {
  for (const auto& character : cast.characters) report.triangles += character->triangles();
  report.of_triangles = triangles_of(set.all[set.of]->representation(), cast);
  report.to_triangles = triangles_of(set.all[set.to]->representation(), cast);
  report.low_polygon_triangles = triangles_of(set.all[set.low_polygon]->representation(), cast);
}

void put_levels(RatioReport& report, const TimedSet& set) {
  for (const auto& timed : set.all) {
    std::vector<renderers::LevelInfo> levels = timed->representation().bake_info().levels;
    const auto known = [&](const RatioReport::Levels& one) { return one.name == timed->name(); };
    if (!levels.empty() && std::ranges::none_of(report.levels, known))
      report.levels.push_back({timed->name(), std::move(levels)});
  }
}

std::vector<VariantTimes> time_set(gl::Context& context, const TimedSet& set, const RatioRequest& request,
                                   const TimingMethod& method, Progress& progress) {
  TimingPlan plan;
  plan.rounds = plan.least_rounds = request.pairs;
  plan.metric = method.headline;
  plan.order_seed = request.order_seed;
  std::vector<Variant> variants;
  variants.reserve(set.all.size());
  for (const auto& timed : set.all) variants.push_back(timed->variant());
  progress.note("timing");
  Progress rounds("rounds at most", static_cast<size_t>(plan.rounds + plan.most_warmup));
  return time_interleaved(variants, plan, system_clocks(), gpu_timer_of(context, method), [&] { rounds.advance(); });
}

RatioReport::Median median_of(const std::string& name, const VariantTimes& times) {
  RatioReport::Median out;
  out.name = name;
  out.cpu_ns = median(values_of(times.samples, Metric::cpu));
  out.wall_ns = median(values_of(times.samples, Metric::wall));
  const std::vector<double> gpu = values_of(times.samples, Metric::gpu);
  if (!gpu.empty()) out.gpu_ns = median(gpu);
  return out;
}

void put_medians(RatioReport& report, const TimedSet& set, const std::vector<VariantTimes>& times) {
  for (size_t i = 0; i < set.all.size(); ++i) {
    if (i == set.mesh_again) continue;
    report.medians.push_back(median_of(set.all[i]->name(), times[i]));
    report.warmup_frames = std::max(report.warmup_frames, times[i].warmup_frames);
    report.settled = report.settled && times[i].settled;
  }
}

}  // namespace

void put_ratios(RatioReport& report, const RatioTimes& times, Metric headline) {
  const auto headline_ratio = [&](std::span<const SampleRow> above, std::span<const SampleRow> below) {
    const auto found = paired_ratio(above, below, headline, kBootstrapSeed);
    if (!found) throw Error("ratio", "the clock gave no time for a frame", "measure more agents");
    return *found;
  };
  report.headline = metric_name(headline);
  report.cpu = paired_ratio(times.to, times.of, Metric::cpu, kBootstrapSeed);
  report.wall = paired_ratio(times.to, times.of, Metric::wall, kBootstrapSeed);
  report.gpu = paired_ratio(times.to, times.of, Metric::gpu, kBootstrapSeed);
  report.headline_ratio = headline_ratio(times.to, times.of);
  report.mesh_floor = headline_ratio(times.mesh, times.mesh_floor);
  report.control = judge_control(times.mesh, times.mesh_again, headline, kBootstrapSeed);
  report.to_low_polygon = headline_ratio(times.low_polygon, times.of);
  report.is_void = report.mesh_floor.median > kMeshFloorBound;
  if (report.is_void)
    report.void_reason = fmt::format("the mesh takes {:.2f} times its own floor, more than {:.1f}: no fair yardstick",
                                     report.mesh_floor.median, kMeshFloorBound);
}

RatioReport measure_ratio(gl::Context& context, const scene::Cast& cast, const RatioRequest& request) {
  if (request.pairs < kLeastPairs)
    throw Error("--pairs", fmt::format("{} is too few", request.pairs), fmt::format("use at least {}", kLeastPairs));
  RatioReport report;
  report.renderer = context.renderer();
  report.software = context.is_software();
  report.order_seed = request.order_seed;
  Progress progress("ratio", 0);
  progress.note("solving for the view");
  const Staged staged = stage_scenario(request.scenario, cast, context);
  report.stage = measure_stage(staged, cast, context);
  Stage stage(context, cast);
  stage.show(staged);

  const TimedSet set = bake_set(stage, request, progress);
  report.of = set.all[set.of]->name();
  report.to = set.all[set.to]->name();
  check_set(report, set);
  put_triangles(report, set, cast);
  put_levels(report, set);

  const TimingMethod method = choose_timing_method(context);
  const std::vector<VariantTimes> times = time_set(context, set, request, method, progress);
  put_ratios(report,
             {.of = times[set.of].samples,
              .to = times[set.to].samples,
              .mesh = times[set.mesh].samples,
              .mesh_floor = times[set.mesh_floor].samples,
              .low_polygon = times[set.low_polygon].samples,
              .mesh_again = times[set.mesh_again].samples},
             method.headline);
  put_medians(report, set, times);
  return report;
}

}  // namespace crowdbench::bench
