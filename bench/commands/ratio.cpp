#include "bench/experiments/ratio.h"

#include <fmt/format.h>

#include <cmath>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/level_output.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/json.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {
namespace {

struct RatioOptions {
  SceneOptions scene;
  std::string of, to;
  int pairs = 24;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool json = false;
};

Json interval_json(const MedianRatio& ratio) { return {ratio.interval.low, ratio.interval.high}; }

Json number(const std::optional<MedianRatio>& ratio) { return ratio ? Json(ratio->median) : Json(nullptr); }

Json control_json(const std::optional<Control>& control) {
  if (!control) return nullptr;
  const bool finite = std::isfinite(control->detectable);
  return {{"ratio", control->ratio.median},
          {"interval", interval_json(control->ratio)},
          {"p", control->p},
          {"level", kControlLevel},
          {"differs", control->differs},
          {"detectable", finite ? Json(control->detectable) : Json(nullptr)},
          {"power", kControlPower}};
}

Json json_of(const RatioReport& report, const scene::Scenario& scenario) {
  Json medians = Json::object();
  for (const RatioReport::Median& median : report.medians)
    medians[median.name] = {{"cpu_ns", median.cpu_ns},
                            {"frame_ns", median.wall_ns},
                            {"gpu_ns", median.gpu_ns ? Json(*median.gpu_ns) : Json(nullptr)}};
  Json levels = Json::object();
  for (const RatioReport::Levels& one : report.levels) levels[one.name] = levels_json(one.levels);
  const StageFacts& stage = report.stage;
  return {{"of", report.of},
          {"to", report.to},
          {"cpu_ratio", number(report.cpu)},
          {"wall_ratio", number(report.wall)},
          {"gpu_ratio", number(report.gpu)},
          {"headline", report.headline},
          {"interval", interval_json(report.headline_ratio)},
          {"pairs", report.headline_ratio.pairs},
          {"covered_px", {{"of", report.of_check.covered_px}, {"to", report.to_check.covered_px}}},
          {"triangles", report.triangles},
          {"triangles_drawn_per_agent", {{"of", report.of_triangles}, {"to", report.to_triangles}}},
          {"mesh_floor", report.mesh_floor.median},
          {"mesh_floor_interval", interval_json(report.mesh_floor)},
          {"void", report.is_void},
          {"void_reason", report.is_void ? Json(report.void_reason) : Json(nullptr)},
          {"control", control_json(report.control)},
          {"to_500_triangles", report.to_low_polygon.median},
          {"to_500_triangles_interval", interval_json(report.to_low_polygon)},
          {"levels", levels},
          {"valid", report.valid},
          {"faults", report.faults},
          {"agents", scenario.crowd.agents},
          {"seed", scenario.seed},
          {"width", scenario.width},
          {"height", scenario.height},
          {"requested_occupancy", scenario.occupancy ? Json(*scenario.occupancy) : Json(nullptr)},
          {"achieved_occupancy", stage.coverage.occupancy},
          {"unreachable", stage.unreachable},
          {"agents_on_screen",
           {{"wholly", stage.on_screen.wholly}, {"partly", stage.on_screen.partly}, {"off", stage.on_screen.off}}},
          {"stage", stage_json(stage)},
          {"order_seed", report.order_seed},
          {"medians", medians},
          {"warmup_frames", report.warmup_frames},
          {"warmup_settled", report.settled},
          {"renderer", report.renderer},
          {"software", report.software}};
}

std::string times_text(const MedianRatio& ratio) {
  return fmt::format("{:.2f}x [{:.2f}, {:.2f}]", ratio.median, ratio.interval.low, ratio.interval.high);
}

void print(const RatioReport& report, const scene::Scenario& scenario) {
  fmt::print("{} against {}: {}, {}x{}, {:.1f} % of the picture covered, {}\n", report.of, report.to,
             counted(scenario.crowd.agents, "agent", "agents"), scenario.width, scenario.height,
             100 * report.stage.coverage.occupancy, report.renderer);
  const char* mark = report.is_void ? "  VOID" : "";
  if (report.cpu)
    fmt::print("  process CPU   {}{}{}\n", times_text(*report.cpu), report.headline == "cpu" ? "  <- headline" : "",
               mark);
  if (report.wall)
    fmt::print("  wall clock    {}{}{}\n", times_text(*report.wall), report.headline == "wall" ? "  <- headline" : "",
               mark);
  if (report.gpu)
    fmt::print("  GPU           {}{}{}\n", times_text(*report.gpu), report.headline == "gpu" ? "  <- headline" : "",
               mark);
  fmt::print("  t({}) / t({}): above 1 {} is the faster; median of {} interleaved pairs, 95 % interval\n", report.to,
             report.of, report.of, report.headline_ratio.pairs);
  fmt::print("  mesh over its floor {}{}\n", times_text(report.mesh_floor),
             report.is_void ? fmt::format(", above {:.1f}: the figure is void", kMeshFloorBound) : "");
  if (report.control)
    fmt::print("  A/A, {} against itself: {}\n", renderers::reference_spec().text(),
               control_text(report.control->ratio, report.control->p, report.control->detectable));
  fmt::print("  against its level of {} triangles {}\n", report.low_polygon_triangles,
             times_text(report.to_low_polygon));
  for (const RatioReport::Levels& one : report.levels)
    for (const renderers::LevelInfo& level : one.levels) fmt::print("  {} of {}\n", one.name, level_text(level));
  for (const RatioReport::Median& median : report.medians)
    fmt::print("  {:<34} CPU {:9.3f} ms  wall {:9.3f} ms{}\n", median.name, median.cpu_ns / 1e6, median.wall_ns / 1e6,
               median.gpu_ns ? fmt::format("  GPU {:9.3f} ms", *median.gpu_ns / 1e6) : "");
  fmt::print("  covered pixels: {} {}, {} {}\n", report.of, report.of_check.covered_px, report.to,
             report.to_check.covered_px);
  if (!report.settled) fmt::print("  the warm-up ended at its limit of {} frames, not settled\n", report.warmup_frames);
  if (report.stage.unreachable) fmt::print("  unreachable: {:.1f} % were asked for\n", 100 * *scenario.occupancy);
}

int run_ratio(const RatioOptions& options) {
  RatioRequest request;
  request.of = parse_representation(options.of, "--of");
  request.to = parse_representation(options.to, "--to");
  request.pairs = options.pairs;
  request.bake_budget = options.bake_budget_mib << 20;
  const ChosenScenario chosen = read_scenario(options.scene);
  request.scenario = chosen.scenario;
  const bool by_default = options.scene.file.empty();
  if (by_default && !options.scene.agents) request.scenario.crowd.agents = 250;
  if (by_default && !options.scene.occupancy) request.scenario.occupancy = 0.15;
  if (request.scenario.crowd.agents == 0) throw Error("--agents", "0 agents cannot be timed", "use at least 1");
  const scene::Cast cast = open_cast(request.scenario, chosen.folder, chosen.places);
  const std::unique_ptr<gl::Context> opened = open_context(options.scene.device);
  gl::Context& context = *opened;
  const RatioReport report = measure_ratio(context, cast, request);
  if (options.json)
    fmt::print("{}\n", json_of(report, request.scenario).dump(2));
  else
    print(report, request.scenario);
  for (const std::string& fault : report.faults) fmt::print(stderr, "crowdbench: invalid: {}\n", fault);
  if (report.is_void) fmt::print(stderr, "crowdbench: void: {}\n", report.void_reason);
  return report.valid ? 0 : 1;
}

}  // namespace

void add_ratio(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("ratio", "How many times as fast as another one representation is, drawn in rounds");
  command->footer(
      "t(TO) / t(OF): above 1 OF is the faster. Both draw the same crowd from the same camera (solved with the mesh), "
      "one\ntick a round. Exit status 1 when a picture check fails: nothing drawn, another coverage than the mesh's, "
      "or "
      "no motion.\nExamples:\n  crowdbench ratio --of flat --to mesh --agents 250\n  crowdbench ratio --of mesh --to "
      "mesh --agents 100 "
      "--json   (the noise of the method)");
  auto options = std::make_shared<RatioOptions>();
  add_scene_options(*command, options->scene);
  command->add_option("--of", options->of, "representation, name[:key=value,...]")->required()->type_name("R");
  command->add_option("--to", options->to, "what it is measured against")->required()->type_name("R");
  command->add_option("--pairs", options->pairs, "timed rounds of each, at least 20")
      ->type_name("K")
      ->capture_default_str()
      ->whole_number(kLeastPairs, 100'000);
  add_bake_options(*command, options->bake_budget_mib);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_ratio(*options); }; });
}

}  // namespace crowdbench::bench
