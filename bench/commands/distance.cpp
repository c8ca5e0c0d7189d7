#include "bench/experiments/distance.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "bench/commands/command_line.h"
#include "bench/commands/distance_output.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/experiments/distance_rows.h"
#include "bench/stage/cast_name.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"

namespace crowdbench::bench {
namespace {

struct DistanceOptions {
  SceneOptions scene;
  std::vector<std::string> representations;
  std::string reference = renderers::reference_spec().text();
  std::string scores = "all";
  std::vector<std::string> thresholds;
  std::string out, chart, results;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  uint64_t bins = 8;
  DistanceRequest request;
  double least_visible_percent = 75;
  bool no_cache = false;
  bool json = false;
};

// Whatever the table has that exists for an agent; by name also those of linear light.
std::vector<const metrics::Score*> scores_for(const DistanceOptions& options, metrics::ScoreTable table,
                                              const std::vector<DistanceThreshold>& thresholds) {
  std::vector<const metrics::Score*> wanted =
      options.scores == "all" ? agent_scores(table, false) : chosen_scores(options.scores, "--scores", table);
  for (const DistanceThreshold& threshold : thresholds) wanted.push_back(threshold.score);
  const std::vector<const metrics::Score*> possible = agent_scores(table, true);
  for (const metrics::Score* score : wanted)
    if (std::find(possible.begin(), possible.end(), score) == possible.end())
      throw Error("--scores", fmt::format("{} does not exist for one agent", score->name),
                  "`crowdbench distance` without --scores lists those that do");
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* score : possible)
    if (std::find(wanted.begin(), wanted.end(), score) != wanted.end()) out.push_back(score);
  return out;
}

// All but the scene and the staging: whatever is wrong in it is said before anything is loaded.
DistanceReport read_options(const DistanceOptions& options, metrics::ScoreTable table,
                            std::vector<DistanceThreshold>& thresholds) {
  DistanceReport report;
  for (const std::string& text : options.thresholds) {
    const ScoreValue threshold = parse_score_value(text, "--threshold", table);
    thresholds.push_back({threshold.score, threshold.value});
  }
  report.request = options.request;
  DistanceRequest& request = report.request;
  request.reference = parse_representation(options.reference, "--reference");
  request.representations = parse_representations(options.representations);
  request.scores = scores_for(options, table, thresholds);
  request.least_visible = options.least_visible_percent / 100;
  request.bake_budget = options.bake_budget_mib << 20;
  request.use_cache = !options.no_cache;
  report.list_all = options.scores != "all";
  return report;
}

int run_distance(const DistanceOptions& options, metrics::ScoreTable table) {
  std::vector<DistanceThreshold> thresholds;
  DistanceReport report = read_options(options, table, thresholds);
  std::optional<StoreWriter> store;
  if (!options.results.empty()) store.emplace(options.results);  // refused before anything is drawn
  const ChosenScenario chosen = read_scenario(options.scene);
  report.request.display = chosen.display;
  {
    Progress progress("distance", 0);
    progress.note("loading the characters");
    const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
    const auto context = open_context(options.scene.device);
    progress.note(fmt::format("placing {}", counted(chosen.scenario.crowd.agents, "agent", "agents")));
    const Staged staged = stage_scenario(chosen.scenario, cast, *context);
    report.scenario = staged.scenario;
    report.cast = cast_name(cast);
    report.renderer = context->renderer();
    progress.note("");
    report.result = measure_distance(*context, cast, staged, report.request);
    progress.note("drawing agents anew for the intervals");
    report.curves = distance_curves(report.result, report.request, static_cast<size_t>(options.bins),
                                    report.scenario.seed, thresholds);
    if (store) {
      const RunRow run =
          describe_run(*context, choose_timing_method(*context), chosen.scenario, "distance", command_line());
      write_distance_rows(*store, rows_of(report, store->write(run)));
    }
  }
  if (report.curves.empty())
    fmt::print(stderr, "crowdbench: warning: no agent counts, so there is no curve; see the counts\n");
  if (!options.out.empty()) write_file(options.out, std::string_view(distance_csv(report)));
  if (!options.chart.empty()) write_file(options.chart, std::string_view(distance_page_of(report)));
  if (options.json)
    fmt::print("{}\n", distance_json(report).dump(2));
  else
    print_distance(report);
  return 0;
}

void add_frame_options(Command& command, DistanceOptions& options) {
  DistanceRequest& request = options.request;
  const auto add_count = [&](const char* name, uint64_t& value, uint64_t least, uint64_t most, const char* text) {
    command.add_option(name, value, text)->type_name("N")->capture_default_str()->whole_number(least, most);
  };
  add_count("--tick", request.tick, 0, 1'000'000'000,
            "which tick of the scenario (30 a second by default), the first of --frames");
  add_count("--frames", request.frames, 1, 10'000, "frames that are drawn; the intervals draw whole agents");
  add_count("--step", request.step, 1, 1'000'000, "ticks from one frame to the next");
  command
      .add_option("--least-visible", options.least_visible_percent,
                  "an agent counts only where so many percent of the pixels that it covers alone are visible")
      ->type_name("PERCENT")
      ->capture_default_str()
      ->number(0, 100);
  add_count("--bins", options.bins, 1, 1000,
            "bins of equally many agents, fewer where there are not five agents a bin");
}

}  // namespace

void add_distance(Command& app, Run& run) { add_distance(app, run, metrics::scores()); }

void add_distance(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command = app.add_subcommand("distance", "What each agent of a crowd scores, against how far away it is");
  command->footer(
      "One frame (or several) is drawn by the reference and by each representation; scores are those of the whole\n"
      "pictures, read over the pixels of each agent. Agents count that lie wholly in the picture and are not hidden "
      "by\n"
      "others: what each would cover alone is drawn too. A threshold is reached where the binned median is as good or\n"
      "better from there to the farthest; the interval draws whole agents anew, 1000 times from the scenario's seed.\n"
      "`crowdbench schema --scores` says what each score is.\n\n"
      "Examples:\n"
      "  crowdbench distance --representation flat --agents 200\n"
      "  crowdbench distance street.toml --representation flat,relief --threshold flip=0.1 --display standard_fhd\n"
      "  crowdbench distance --representation flat --frames 10 --scores flip,cvvdp --out agents.csv --chart page.html");
  auto options = std::make_shared<DistanceOptions>();
  add_scene_options(*command, options->scene);
  add_representation_option(*command, options->representations, "what is judged")->required();
  command->add_option("--reference", options->reference, "what all are held against")
      ->type_name("R")
      ->capture_default_str();
  command->add_option("--scores", options->scores, "only these, name,name,...; all: every one that exists for an agent")
      ->type_name("LIST")
      ->capture_default_str();
  command
      ->add_option("--threshold", options->thresholds,
                   "say from where on a score is this good or better, flip=0.1; may be given several times")
      ->type_name("SCORE=VALUE")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  add_frame_options(*command, *options);
  add_display_option(*command, options->scene.display);
  command->add_option("--out", options->out, "every agent's values, one record an agent and representation")
      ->type_name("FILE.csv")
      ->output_file();
  command->add_option("--chart", options->chart, "a page with every score against distance, height and texel ratio")
      ->type_name("FILE.html")
      ->output_file();
  add_results_option(*command, options->results);
  command->add_flag("--causes", options->request.causes,
                    "also the squared error by cause, of all agents and of each, and what dominates by height\n"
                    "(`schema --results` says how); of pictures of one sample a pixel");
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_json_option(*command, options->json);
  command->callback([options, table, &run] { run = [options, table] { return run_distance(*options, table); }; });
}

}  // namespace crowdbench::bench
