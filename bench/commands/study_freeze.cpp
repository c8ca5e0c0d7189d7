#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/json.h"
#include "studies/plan/default_texts.h"
#include "studies/plan/frozen.h"
#include "studies/plan/plan_cast.h"

namespace crowdbench::bench {
namespace {

struct StudyFreezeOptions {
  std::string plan, deviation;
  bool anew = false;
  bool json = false;
};

int run_freeze(const StudyFreezeOptions& options) {
  const studies::StudyPlan plan = studies::read_study_plan(options.plan);
  studies::require_cast(options.plan, plan);
  const studies::FrozenPlan frozen = studies::freeze(options.plan, plan, options.deviation, options.anew);
  const bool adaptive = plan.method.method != studies::Method::constant;
  const bool default_consent = plan.consent == studies::default_consent();
  if (options.json) {
    fmt::print("{}\n", Json{{"file", frozen.file.string()},
                            {"hash", frozen.current_hash()},
                            {"adaptive", adaptive},
                            {"default_consent", default_consent},
                            {"frozen", frozen.hash},
                            {"deviations", frozen.deviations.size()}}
                           .dump(2));
    return 0;
  }
  fmt::print("{}: {}, {}, frozen as {}\n", frozen.file.string(), plan.name,
             counted(plan.conditions.size(), "condition", "conditions"), frozen.current_hash().substr(0, 16));
  if (adaptive)
    fmt::print("order: adaptive ({}): each main trial is chosen by the participant's own answers so far\n",
               studies::method_words()[static_cast<size_t>(plan.method.method)]);
  if (default_consent)
    fmt::print("consent: the default text, with a place left for who runs the study (`consent` in [question])\n");
  for (const studies::Deviation& deviation : frozen.deviations)
    fmt::print("deviation: {} (from then on {})\n", deviation.reason, deviation.hash.substr(0, 16));
  return 0;
}

}  // namespace

void add_study_freeze(Command& study, Run& run) {
  Command* command = study.add_subcommand("freeze", "Fixes a plan before the first answer: its hash and its analysis");
  command->footer(
      "Writes PLAN.frozen.json beside the plan. Export and analysis refuse a plan that was changed since, unless the "
      "change\n"
      "is recorded with --deviation. What a plan may say: studies/plan/README.md.\n\n"
      "Examples:\n  crowdbench study freeze switch.toml\n"
      "  crowdbench study freeze switch.toml --deviation 'fewer repeats: sessions took too long'");
  auto options = std::make_shared<StudyFreezeOptions>();
  command->add_option("PLAN", options->plan, "the plan")->required()->type_name("FILE.toml");
  Option* deviation =
      command->add_option("--deviation", options->deviation, "record that the frozen plan was changed, and why");
  deviation->type_name("WHY");
  command->add_flag("--anew", options->anew, "forget what was frozen: no answer was collected yet")
      ->excludes(deviation);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_freeze(*options); }; });
}

}  // namespace crowdbench::bench
