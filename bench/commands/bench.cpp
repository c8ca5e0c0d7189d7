#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/bench_run.h"
#include "bench/experiments/score_rows.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/progress.h"
#include "reports/exports/exports.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

struct Options {
  SceneOptions scene;
  std::string representations;
  std::vector<uint32_t> agents;
  std::vector<double> occupancies;
  std::string out = "results.sqlite";
  SweepRequest request;
  bool no_floors = false;
  bool json = false;
  int bake_budget_mib = 512;
};

int run_bench(const Options& options) {
  SweepRequest request = options.request;
  request.floors = !options.no_floors;
  request.bake_budget = uint64_t(options.bake_budget_mib) << 20;
  if (!options.representations.empty()) request.representations = parse_specs(options.representations);
  if (!options.agents.empty()) request.agents = options.agents;
  std::sort(request.agents.begin(), request.agents.end());
  request.agents.erase(std::unique(request.agents.begin(), request.agents.end()), request.agents.end());
  if (request.agents.front() < 1 || request.agents.back() > 1'000'000)
    throw Error("--agents", "a number of agents lies outside 1 to 1000000");
  if (!options.occupancies.empty()) request.occupancies = options.occupancies;
  for (const double occupancy : request.occupancies)
    if (!(occupancy >= 0 && occupancy <= 1))
      throw Error("--occupancy", fmt::format("{} is not a fraction of 0 to 1", occupancy),
                  "0.15 is 15 % of the picture; 0 is the scenario's own camera");
  if (request.rounds < request.least_rounds)
    throw Error("--rounds", fmt::format("{} is too few", request.rounds),
                fmt::format("use at least {}", request.least_rounds));
  if (!(request.budget_ms > 0)) throw Error("--budget-ms", "must be above 0");

  const ChosenScenario chosen = read_scenario(options.scene);
  request.scenario = chosen.scenario;
  const renderers::Spec own = renderers::parse_spec(request.scenario.representation);
  if (request.representations.empty() && own.text() != renderers::reference_spec().text())
    request.representations.push_back(own);
  if (request.representations.empty())
    for (const renderers::RepresentationType& type : renderers::representation_types())
      if (!type.reference && stands_alone(type)) request.representations.push_back(renderers::parse_spec(type.name));
  StoreWriter store(options.out);  // refused before anything is drawn
  const scene::Cast cast = scene::load_cast(request.scenario, chosen.folder);
  const std::unique_ptr<gl::Context> opened = open_context(options.scene.device);
  gl::Context& context = *opened;
  const TimingMethod method = choose_timing_method(context);
  if (context.is_software())
    fmt::print(stderr,
               "a software rasteriser draws: CPU times compare representations, they say nothing about a GPU\n");

  RunRow run = describe_run(context, method, request.scenario, "bench", command_line());
  run.id = store.write(run);
  SweepSummary summary;
  {
    Progress progress("bench", 0);
    try {
      summary =
          run_sweep(context, cast, method, run, request, store, [&](const std::string& now) { progress.note(now); });
    } catch (const Interrupted&) {
      progress.note("");
      fmt::print(stderr, "crowdbench: stopped; finished points are in {}, the same command goes on from there\n",
                 options.out);
      throw;
    }
  }
  const StoreContents contents = read_store(options.out, false, false);
  if (options.json) {
    fmt::print("{}", reports::results_json(contents, score_docs(metrics::scores())));
    for (const std::string& remark : summary.remarks) fmt::print(stderr, "{}\n", remark);
    return summary.invalid == 0 ? 0 : 1;
  }
  fmt::print("{}", sweep_table(contents, run));
  for (const std::string& remark : summary.remarks) fmt::print("{}\n", remark);
  fmt::print("{} points measured, {} taken from the file; {}\n", summary.measured, summary.held, options.out);
  return summary.invalid == 0 ? 0 : 1;
}

}  // namespace

void add_bench(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("bench", "Frame times against the number of agents, into a result file");
  command->footer(
      "All representations draw the same crowd from the same camera and take turns. A curve ends with the first frame "
      "beyond\nthe budget. Ctrl-C keeps every finished point; the same command continues the file. Exit status 1 when "
      "a "
      "picture check\nfailed (the row says so).\nExamples:\n  crowdbench bench --representations mesh,flat --agents "
      "1,10,100,250 --occupancy 0.15 --out results.sqlite\n  crowdbench bench plaza.toml --budget-ms 500 --out "
      "results.sqlite");
  auto options = std::make_shared<Options>();
  SweepRequest& request = options->request;
  command->add_option("SCENARIO", options->scene.file, "scenario file; without one, the built-in character on a plaza")
      ->type_name("FILE.toml");
  command
      ->add_option("--representations", options->representations,
                   "drawn beside the mesh, name[:key=value,...] separated by commas [all that are built in]")
      ->type_name("R,R,...");
  command->add_option("--agents", options->agents, "numbers of agents [1,10,100,250,500,1000,2000,5000,10000]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("N,N,...");
  command
      ->add_option("--occupancy", options->occupancies,
                   "fractions of the picture to cover, 0 = the scenario's camera [0.15,0.9]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("F,F,...");
  command->add_option("--seed", options->scene.seed, "seed of the crowd")->type_name("S");
  command->add_option("--size", options->scene.size, "picture size in pixels")->type_name("WxH");
  command->add_option("--character", options->scene.character, "mannequin[:key=value,...] or a glTF file")
      ->type_name("C");
  command->add_option("--device", options->scene.device, "N or software")->type_name("D");
  command->add_option("--budget-ms", request.budget_ms, "wall time a frame may take before its curve ends")
      ->type_name("MS")
      ->capture_default_str();
  command->add_option("--rounds", request.rounds, "timed turns a point")->type_name("K")->capture_default_str();
  command->add_option("--time-limit", request.time_limit_s, "seconds of timing a point, from 10 turns on")
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--picture-agents", request.picture_agents, "pictures are kept of the largest crowd up to this")
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--no-floors", options->no_floors, "do not time the floors (half the time)");
  command->add_option("--bake-budget", options->bake_budget_mib, "MiB a bake may take")
      ->type_name("MIB")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  command->add_option("--out", options->out, "result file; continued when it exists")
      ->type_name("FILE.sqlite")
      ->capture_default_str();
  command->add_flag("--json", options->json, "print every row of the result file as JSON instead of the table");
  command->callback([options, &run] { run = [options] { return run_bench(*options); }; });
}

}  // namespace crowdbench::bench
