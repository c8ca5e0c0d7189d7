#include "bench/experiments/ratio.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/progress.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

constexpr uint64_t kBootstrapSeed = 1;
// Half a second of a walk lies between the two pictures of a check.
constexpr uint64_t kSecondTick = 15;

uint64_t triangles_of(renderers::Representation& representation, const scene::Cast& cast) {
  uint64_t sum = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) sum += representation.triangles(c);
  return sum;
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

}  // namespace

RatioReport measure_ratio(gl::Context& context, const scene::Cast& cast, const RatioRequest& request) {
  if (request.pairs < kLeastPairs)
    throw Error("--pairs", fmt::format("{} is too few", request.pairs), fmt::format("use at least {}", kLeastPairs));
  Progress progress("ratio", 0);
  progress.note("solving for the view");
  scene::Solved solved = solve_scene(context, request.scenario, cast);
  const LowPolygonCast low = low_polygon_cast(solved.scenario, solved.crowd);

  progress.note("baking");
  Stage stage(context, cast);
  stage.show(solved.scenario, solved.crowd, solved.camera);
  Stage low_stage(context, low.cast);
  low_stage.show(low.scenario, low.crowd, solved.camera);
  const renderers::Spec mesh_spec = renderers::reference_spec();
  // Both sides are always drawn apart, so that a representation against itself tells the noise of the method.
  std::vector<std::unique_ptr<TimedRepresentation>> all;
  const auto enter = [&](Stage& on, const renderers::Spec& spec) {
    all.push_back(std::make_unique<TimedRepresentation>(on, spec, solved.scenario.width, solved.scenario.height,
                                                        request.bake_budget));
    return all.size() - 1;
  };
  const size_t of = enter(stage, request.of);
  const size_t to = enter(stage, request.to);
  const auto known = [&](const renderers::Spec& spec) -> std::optional<size_t> {
    for (const size_t i : {of, to})
      if (all[i]->name() == spec.text()) return i;
    return std::nullopt;
  };
  const auto known_or_enter = [&](const renderers::Spec& spec) {
    const auto place = known(spec);
    return place ? *place : enter(stage, spec);
  };
  const size_t mesh = known_or_enter(mesh_spec);
  const size_t floor = known_or_enter(with_floor(mesh_spec));
  const size_t low_mesh = enter(low_stage, mesh_spec);

  RatioReport report;
  report.of = all[of]->name();
  report.to = all[to]->name();
  report.renderer = context.renderer();
  report.software = context.is_software();
  report.mesh_check = check_pictures(all[mesh]->capture(0), all[mesh]->capture(kSecondTick), false, std::nullopt);
  const auto check = [&](size_t i) {
    return i == mesh ? report.mesh_check
                     : check_pictures(all[i]->capture(0), all[i]->capture(kSecondTick), all[i]->is_floor(),
                                      report.mesh_check);
  };
  report.of_check = check(of);
  report.to_check = check(to);
  for (const auto& [name, fault] :
       {std::pair{report.of, report.of_check.fault}, std::pair{report.to, report.to_check.fault},
        std::pair{mesh_spec.text(), report.mesh_check.fault}})
    if (!fault.empty() &&
        std::find(report.faults.begin(), report.faults.end(), name + ": " + fault) == report.faults.end())
      report.faults.push_back(name + ": " + fault);
  report.valid = report.faults.empty();
  for (const auto& character : cast.characters) report.triangles += character->triangles();
  report.of_triangles = triangles_of(all[of]->representation(), cast);
  report.to_triangles = triangles_of(all[to]->representation(), cast);
  report.low_polygon_triangles = low.cast.characters.front()->triangles();

  const TimingMethod method = choose_timing_method(context);
  report.headline = metric_name(method.headline);
  TimingPlan plan;
  plan.rounds = plan.least_rounds = request.pairs;
  plan.metric = method.headline;
  std::vector<Variant> variants;
  variants.reserve(all.size());
  for (const auto& timed : all) variants.push_back(timed->variant());
  size_t rounds = 0;
  const auto results = time_interleaved(variants, plan, system_clocks(), gpu_timer_of(context, method), [&] {
    progress.note(fmt::format("round {} (warm-up included)", ++rounds));
    throw_if_interrupted();
  });

  const auto ratio = [&](size_t numerator, size_t denominator, Metric metric) {
    return paired_ratio(results[numerator].samples, results[denominator].samples, metric, kBootstrapSeed);
  };
  const auto headline = [&](size_t numerator, size_t denominator) {
    const auto found = ratio(numerator, denominator, method.headline);
    if (!found) throw Error("ratio", "the clock gave no time for a frame", "measure more agents");
    return *found;
  };
  report.cpu = ratio(to, of, Metric::cpu);
  report.wall = ratio(to, of, Metric::wall);
  report.gpu = ratio(to, of, Metric::gpu);
  report.headline_ratio = headline(to, of);
  report.mesh_floor = headline(mesh, floor);
  report.to_low_polygon = headline(low_mesh, of);
  if (report.mesh_floor.median > kMeshFloorBound) {
    report.is_void = true;
    report.void_reason = fmt::format("the mesh takes {:.2f} times its own floor, more than {:.1f}: no fair yardstick",
                                     report.mesh_floor.median, kMeshFloorBound);
  }
  for (size_t i = 0; i < all.size(); ++i) {
    const std::string name = i == low_mesh ? mesh_spec.text() + " of mannequin:triangles=500" : all[i]->name();
    report.medians.push_back(median_of(name, results[i]));
    report.warmup_frames = std::max(report.warmup_frames, results[i].warmup_frames);
    report.settled = report.settled && results[i].settled;
  }
  solved.crowd = {};
  report.solved = std::move(solved);
  return report;
}

}  // namespace crowdbench::bench
