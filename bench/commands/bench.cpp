#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/commands/chosen_representation.h"
#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/level_output.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_commands.h"
#include "bench/experiments/bench_run.h"
#include "bench/experiments/bench_table.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/low_polygon.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/file_lock.h"
#include "core/json.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "reports/exports/exports.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

struct BenchOptions {
  SceneOptions scene;
  std::vector<std::string> representations;
  std::vector<uint32_t> agents;
  std::vector<double> occupancies;
  std::string out = "results.sqlite";
  BenchRequest request;
  bool no_floors = false;
  bool json = false;
  bool full = false;
  std::optional<double> minutes;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
};

// The rows of the file, the levels of detail that were drawn now, and the stages of the points that were solved for
// now.
std::string json_of(const StoreContents& contents, const BenchSummary& summary, metrics::ScoreTable table) {
  Json all = Json::parse(reports::results_json(contents, score_docs(table)));
  Json& levels = all["levels"] = Json::object();
  for (const DrawnLevels& drawn : summary.levels) levels[drawn.representation] = levels_json(drawn.levels);
  Json& stages = all["stages"] = Json::array();
  for (const StagedPoint& point : summary.stages)
    stages.push_back({{"agents", point.agents},
                      {"requested_occupancy", point.requested_occupancy},
                      {"stage", stage_json(point.facts)}});
  return all.dump(2) + "\n";
}

// Without a word about it, a run is over while one waits for it.
constexpr double kDefaultMinutes = 3;
// What solving, looking and writing take beside the timed rounds, seconds a point; rough.
constexpr double kPointOverhead = 4;

// What is about to be done, and about how long it takes at most.
std::string forecast(const BenchRequest& request, const std::string& out) {
  const size_t points = request.agents.size() * request.occupancies.size();
  double seconds = static_cast<double>(points) * (2 * request.time_limit_s + kPointOverhead);
  if (request.total_time_s > 0) seconds = std::min(seconds, request.total_time_s);
  return fmt::format(
      "bench: {} of {} and the mesh, about {} at most; results go to {}", counted(points, "point", "points"),
      counted(request.representations.size(), "representation", "representations"), duration_text(seconds), out);
}

int run_bench_command(const BenchOptions& options) {
  BenchRequest request = options.request;
  request.floors = !options.no_floors;
  request.bake_budget = options.bake_budget_mib << 20;
  request.representations = parse_representations(options.representations);
  if (options.full) request.agents = full_agents();
  const bool own_axes = options.full || !options.agents.empty() || !options.occupancies.empty();
  if (options.minutes || !own_axes) request.total_time_s = 60 * options.minutes.value_or(kDefaultMinutes);
  if (!options.agents.empty()) request.agents = options.agents;
  std::sort(request.agents.begin(), request.agents.end());
  request.agents.erase(std::unique(request.agents.begin(), request.agents.end()), request.agents.end());
  if (!options.occupancies.empty()) request.occupancies = options.occupancies;

  const ChosenScenario chosen = read_scenario(options.scene);
  request.scenario = chosen.scenario;
  request.display = chosen.display;
  const renderers::Spec own = representation_of(chosen);
  const bool is_own = request.representations.empty() && own.text() != renderers::reference_spec().text();
  if (is_own) request.representations.push_back(own);
  if (request.representations.empty()) {
    for (const renderers::RepresentationType& type : renderers::representation_types())
      if (!type.reference && stands_alone(type)) request.representations.push_back(renderers::parse_spec(type.name));
    for (const renderers::Spec& level : level_specs()) request.representations.push_back(level);
  }
  StoreWriter store(options.out);  // refused before anything is drawn
  const FileLock lock(options.out);
  const scene::Cast cast = open_cast(request.scenario, chosen.folder, chosen.places);
  const std::unique_ptr<gl::Context> opened = open_context(options.scene.device);
  gl::Context& context = *opened;
  const TimingMethod method = choose_timing_method(context);
  if (context.is_software())
    fmt::print(stderr,
               "a software rasteriser draws: CPU times compare representations, they say nothing about a GPU\n");

  RunRow run = describe_run(context, method, request.scenario, "bench", command_line(), request.order_seed);
  run.id = store.write(run);
  BenchSummary summary;
  try {
    say_when_interrupted(
        fmt::format("finished points are in {}, the same command goes on from there", printable(options.out)));
    Progress progress("bench", request.agents.size() * request.occupancies.size());
    progress.say(forecast(request, printable(options.out)));
    request.after_point = [&](size_t done, double seconds_left) {
      progress.set_done(done);
      if (request.total_time_s > 0) progress.expect(seconds_left);
    };
    summary =
        run_bench(context, cast, method, run, request, store, [&](const std::string& now) { progress.note(now); });
  } catch (const Error& error) {
    if (!is_own) throw;
    blame_choice(chosen, error);
  }
  if (std::ranges::none_of(request.representations, is_level))
    summary.remarks.push_back(fmt::format("no level of detail of {} was timed beside them: --representation {} is one",
                                          renderers::reference_spec().text(), low_polygon_spec().text()));
  const StoreContents contents = read_store(options.out, false, false);
  const std::string counts = fmt::format("{} measured, {} taken from the file; {}\n",
                                         counted(summary.measured, "point", "points"), summary.held, options.out);
  if (options.json) {
    fmt::print("{}", json_of(contents, summary, request.table));
    for (const std::string& remark : summary.remarks) fmt::print(stderr, "{}\n", remark);
    fmt::print(stderr, "{}", counts);
    return summary.invalid == 0 ? 0 : 1;
  }
  fmt::print("{}", bench_table(contents, run));
  for (const DrawnLevels& drawn : summary.levels)
    for (const renderers::LevelInfo& level : drawn.levels)
      fmt::print("{} of {}\n", drawn.representation, level_text(level));
  for (const std::string& remark : summary.remarks) fmt::print("{}\n", remark);
  fmt::print("{}", counts);
  return summary.invalid == 0 ? 0 : 1;
}

}  // namespace

void add_bench(Command& app, Run& run) { add_bench(app, run, metrics::scores()); }

void add_bench(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command = app.add_subcommand("bench", "Frame times against the number of agents, into a result file");
  command->footer(
      "All representations draw the same crowd from the same camera, in the same rounds. A curve ends with the first "
      "frame "
      "beyond\nthe budget. Ctrl-C keeps every finished point; the same command continues the file. Exit status 1 when "
      "a "
      "picture check\nfailed (the row says so).\nExamples:\n  crowdbench bench\n  crowdbench bench --representation "
      "flat,relief --agents 1,10,100,250 --occupancy 0.15 --out results.sqlite\n  crowdbench bench plaza.toml --full "
      "--budget-ms 500 --out results.sqlite");
  auto options = std::make_shared<BenchOptions>();
  BenchRequest& request = options->request;
  request.table = table;
  add_scenario_argument(*command, options->scene.file);
  add_representation_option(*command, options->representations,
                            "drawn beside the mesh (all that are built in, and levels of the mesh)");
  command->add_option("--agents", options->agents, "numbers of agents (1,10,100,1000)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("N,N,...")
      ->whole_number(1, kMostAgents);
  command
      ->add_option("--occupancy", options->occupancies,
                   "fractions of the picture to cover, 0 = the scenario's camera (0.15,0.9)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("F,F,...")
      ->number(0, 1);
  command->add_flag("--full", options->full,
                    "1 to 10000 agents in nine steps, up to 10 s of timing a point, however long that takes in all");
  command
      ->add_option("--minutes", options->minutes,
                   "for all points together: the timed rounds are shortened to fit, and points that would not fit wait "
                   "for the next run of the same command (3; no limit with --full, --agents or --occupancy)")
      ->type_name("M")
      ->number(0.05, 10'000);
  add_seed_option(*command, options->scene.seed);
  add_size_option(*command, options->scene.size);
  add_antialiasing_options(*command, options->scene.antialiasing);
  add_character_options(*command, options->scene.character);
  add_display_option(*command, options->scene.display);
  add_device_option(*command, options->scene.device);
  command->add_option("--budget-ms", request.budget_ms, "wall time a frame may take before its curve ends")
      ->type_name("MS")
      ->capture_default_str()
      ->number(0.001, 1e6);
  command->add_option("--rounds", request.rounds, "timed rounds a point")
      ->type_name("K")
      ->capture_default_str()
      ->whole_number(static_cast<uint64_t>(request.least_rounds), 100'000);
  command->add_option("--time-limit", request.time_limit_s, "seconds of timing a point, from 10 rounds on")
      ->type_name("S")
      ->capture_default_str()
      ->number(0, 1e6);
  command->add_option("--picture-agents", request.picture_agents, "pictures are kept of the largest crowd up to this")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(1, kMostAgents);
  command->add_flag("--no-floors", options->no_floors, "do not time the floors (half the time)");
  add_bake_options(*command, options->bake_budget_mib);
  command->add_option("--out", options->out, "result file; continued when it exists")
      ->type_name("FILE.sqlite")
      ->capture_default_str()
      ->output_file();
  add_json_option(
      *command, options->json,
      "print every row of the result file as JSON instead of the table, and of the points measured now the\n"
      "stages (camera, crowd, occupancy) and the errors of levels of detail");
  command->callback([options, &run] { run = [options] { return run_bench_command(*options); }; });
}

}  // namespace crowdbench::bench
