#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/study.h"
#include "bench/stage/scenario_display.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/json.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "studies/plan/design.h"
#include "studies/plan/export.h"
#include "studies/plan/plan_cast.h"

namespace crowdbench::bench {
namespace {

using namespace studies;

struct StudyExportOptions {
  std::string plan, out, device, display;
  std::string browsers = "chromium";
  double score_every = 1;
  bool dry_run = false;
  bool json = false;
};

// Of two that are ranked, each may be of another one.
std::string condition_of(const StudyPlan& plan, const Stimulus& stimulus) {
  return stimulus.kind == StimulusKind::pair ? "" : plan.conditions[stimulus.condition].id;
}

Json estimate_json(const StudyPlan& plan, const StudyDesign& design, const ExportEstimate& estimate) {
  Json conditions = Json::array();
  for (const StudyCondition& condition : plan.conditions)
    conditions.push_back({{"id", condition.id}, {"name", condition.name}, {"test", condition.test.text()}});
  Json halves = Json::array();
  for (const PlannedHalf& half : design.halves)
    halves.push_back({{"condition", plan.conditions[half.condition].id},
                      {"representation", half.spec.text()},
                      {"seed", half.scenario.seed}});
  Json stimuli = Json::array();
  for (const Stimulus& stimulus : design.stimuli)
    stimuli.push_back({{"id", stimulus.id},
                       {"kind", stimulus_word(stimulus.kind)},
                       {"condition", condition_of(plan, stimulus)},
                       {"upper", stimulus.item_upper},
                       {"lower", stimulus.item_lower}});
  return {{"hash", plan.hash()},
          {"conditions", std::move(conditions)},
          {"halves", std::move(halves)},
          {"stimuli", std::move(stimuli)},
          {"lists", estimate.lists},
          {"trials", estimate.trials},
          {"minutes_a_participant", estimate.minutes_a_participant},
          {"seconds", estimate.seconds},
          {"bakes", estimate.bakes},
          {"bake_seconds", estimate.bake_seconds},
          {"page_bytes", estimate.page_bytes},
          {"work_bytes", estimate.work_bytes}};
}

int print_dry_run(const StudyExportOptions& options, const StudyPlan& plan) {
  const StudyDesign design = make_design(plan);
  const ExportEstimate estimate = estimate_export(plan, design, options.browsers == "all");
  if (options.json) {
    fmt::print("{}\n", estimate_json(plan, design, estimate).dump(2));
    return 0;
  }
  fmt::print("{}: \"{}\", {}\n", plan.name, plan.question_text, task_words()[static_cast<size_t>(plan.task)]);
  fmt::print("conditions:\n");
  for (const StudyCondition& condition : plan.conditions)
    fmt::print("  {}  {:<40} {}\n", condition.id, condition.name, condition.test.text());
  fmt::print("clips to draw: {} of {}\n", estimate.halves, counted(plan.frames(), "frame", "frames"));
  for (const PlannedHalf& half : design.halves)
    fmt::print("  {}  {:<40} seed {}\n", plan.conditions[half.condition].id, half.spec.text(), half.scenario.seed);
  fmt::print("stimuli: {}\n", estimate.stimuli);
  for (const Stimulus& stimulus : design.stimuli)
    fmt::print("  {}  {:<9} {:<3}  {} / {}\n", stimulus.id, stimulus_word(stimulus.kind), condition_of(plan, stimulus),
               stimulus.item_upper, stimulus.item_lower);
  fmt::print("{}, {}, {} each: about {:.0f} min\n", counted(estimate.lists, "list", "lists"),
             counted(plan.participants.planned, "participant", "participants"),
             counted(estimate.trials, "trial", "trials"), estimate.minutes_a_participant);
  if (estimate.bakes > 0)
    fmt::print("{} at first, about {}, unless kept from before\n", counted(estimate.bakes, "bake", "bakes"),
               duration_text(estimate.bake_seconds));
  fmt::print("about {} in all on two cores without a GPU, {:.0f} MB for participants, {:.0f} MB of working files\n",
             duration_text(estimate.seconds), estimate.page_bytes / 1e6, estimate.work_bytes / 1e6);
  return 0;
}

int run_export(const StudyExportOptions& options) {
  if (options.browsers != "chromium" && options.browsers != "all")
    throw Error("--browsers", fmt::format("there is no '{}'", printable(options.browsers, 60)),
                "choose chromium or all");
  const StudyPlan plan = read_study_plan(options.plan);
  require_cast(options.plan, plan);
  if (options.dry_run) return print_dry_run(options, plan);
  if (options.out.empty()) throw Error("OUT", "is missing", "name a folder, or look with --dry-run");
  const FrozenPlan frozen = require_frozen(options.plan, plan);
  ExportSettings settings;
  settings.webm = options.browsers == "all";
  settings.score_every_seconds = options.score_every;
  settings.display = options.display.empty() ? display_of_scenario(plan.conditions[0].scenario, plan.folder,
                                                                   {{"display.model", options.plan}})
                                             : display_of_option(options.display);
  const auto context = open_context(options.device);
  const Exported exported = export_study(*context, plan, frozen, options.out, settings);
  for (const std::string& warning : exported.warnings) fmt::print(stderr, "warning: {}\n", warning);
  if (options.json) {
    fmt::print("{}\n", Json{{"out", options.out},
                            {"hash", frozen.current_hash()},
                            {"drawn", exported.drawn},
                            {"kept_halves", exported.kept_halves},
                            {"stacked", exported.stacked},
                            {"kept_stimuli", exported.kept_stimuli},
                            {"worst_share", exported.worst_share},
                            {"warnings", exported.warnings}}
                           .dump(2));
    return 0;
  }
  fmt::print(
      "{}: {} drawn, {} kept; {} made, {} kept; decoding changes what is under test by at most "
      "{:.1f} % of it\n",
      options.out, counted(exported.drawn, "crowd", "crowds"), exported.kept_halves,
      counted(exported.stacked, "stimulus", "stimuli"), exported.kept_stimuli, 100 * exported.worst_share);
  fmt::print("show participants {} and nothing beside it\n", (std::filesystem::path(options.out) / "page").string());
  return 0;
}

}  // namespace

void add_study_export(Command& study, Run& run) {
  Command* command = study.add_subcommand("export", "The clips, trials and lists of a frozen plan, as a folder");
  command->footer(
      "Every crowd is drawn once; its clips are checked by agent id (no figure taller than planned, nobody in anybody "
      "else,\n"
      "nobody jumping), stacked, encoded, decoded again and held to their raw frames at the very pixels under test: "
      "what "
      "fails\n"
      "is refused. After Ctrl-C the same command goes on.\n"
      "Clips are H.264 with all colour samples (4:4:4), which Chromium plays; Safari, and Firefox on some systems, "
      "refuse "
      "it.\n"
      "--browsers all adds VP9 4:4:4 (WebM) with the same proof; the page takes what the browser plays. Never 4:2:0.\n"
      "OUT/page is for participants; everything else in OUT gives the answers away.\n\n"
      "Examples:\n  crowdbench study export studies/plans/switch_distance.toml --dry-run\n"
      "  crowdbench study export switch.toml out --browsers all");
  auto options = std::make_shared<StudyExportOptions>();
  command->add_option("PLAN", options->plan, "the plan, frozen by `study freeze`")->required()->type_name("FILE.toml");
  command->add_option("OUT", options->out, "the folder to write; made where it is missing")
      ->type_name("FOLDER")
      ->output_folder();
  command->add_option("--browsers", options->browsers, "chromium: H.264 4:4:4; all: also VP9 4:4:4, which takes long")
      ->type_name("WHICH")
      ->capture_default_str();
  command
      ->add_option("--score-every", options->score_every,
                   "seconds between the frames that are scored against the reference; 0: none")
      ->type_name("S")
      ->capture_default_str()
      ->number(0, 600);
  command->add_flag("--dry-run", options->dry_run, "list clips, stimuli, lists, time and disk, and draw nothing");
  add_device_option(*command, options->device);
  add_display_option(*command, options->display);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_export(*options); }; });
}

}  // namespace crowdbench::bench
