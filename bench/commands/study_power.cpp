#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/json.h"
#include "studies/analysis/power.h"
#include "studies/plan/plan.h"

namespace crowdbench::bench {
namespace {

struct Options {
  std::string plan;
  std::vector<uint32_t> participants;
  studies::PowerSettings settings;
  std::optional<uint32_t> clips, repeats;  // the plan's, or the default, where they are not given
  std::optional<double> alpha;
  uint64_t simulations = 1000;
  bool json = false;
};

// What is not given is the plan's: how many take part, the crowds and repeats of a condition, the level of its tests.
void take_plan(Options& o) {
  const studies::StudyPlan plan = studies::read_study_plan(o.plan);
  if (plan.method.method != studies::Method::constant)
    throw Error(o.plan, "chooses its trials by the answers", "plan the study that its pilot is for: constant stimuli");
  if (o.participants.empty() && plan.participants.planned >= 2) o.participants = {plan.participants.planned};
  if (!o.clips) o.clips = plan.stimulus.crowds;
  if (!o.repeats) o.repeats = plan.method.repeats;
  if (!o.alpha) o.alpha = plan.analysis.settings.alpha;
}

int run_power(Options options) {
  if (!options.plan.empty()) take_plan(options);
  if (options.participants.empty()) options.participants = {8, 16, 24, 32};
  options.settings.clips = options.clips.value_or(options.settings.clips);
  options.settings.repeats = options.repeats.value_or(options.settings.repeats);
  options.settings.alpha = options.alpha.value_or(options.settings.alpha);
  Json rows = Json::array();
  if (!options.json)
    fmt::print(
        "simulated: {:g} logits between two conditions, {} x {} in either, {} a row\n"
        "{:>12} {:>8} {:>7} {:>10} {:>10} {:>9} {:>7}\n",
        options.settings.effect, counted(options.settings.clips, "clip", "clips"),
        counted(options.settings.repeats, "repeat", "repeats"), counted(options.simulations, "study", "studies"),
        "participants", "trials", "power", "+-", "CI width", "singular", "failed");
  for (const uint32_t participants : options.participants) {
    studies::PowerSettings s = options.settings;
    s.participants = participants;
    s.simulations = options.simulations;
    const studies::Power got = studies::simulate_power(s);
    const uint64_t trials = uint64_t{2} * s.clips * s.repeats;
    rows.push_back({{"participants", participants},
                    {"trials_per_participant", trials},
                    {"simulations", s.simulations},
                    {"power", got.power},
                    {"power_se", got.power_se},
                    {"mean_estimate", got.mean_estimate},
                    {"sd_estimate", got.sd_estimate},
                    {"mean_se", got.mean_se},
                    {"interval_width", got.interval_width},
                    {"singular", got.singular},
                    {"failed", got.failed}});
    if (!options.json)
      fmt::print("{:>12} {:>8} {:>7.3f} {:>10.3f} {:>10.3f} {:>9} {:>7}\n", participants, trials, got.power,
                 got.power_se, got.interval_width, got.singular, got.failed);
  }
  if (options.json)
    fmt::print("{}\n", Json{{"observers", "simulated"},
                            {"plan", options.plan.empty() ? Json() : Json(options.plan)},
                            {"effect", options.settings.effect},
                            {"clips", options.settings.clips},
                            {"repeats", options.settings.repeats},
                            {"alpha", options.settings.alpha},
                            {"rows", rows}}
                           .dump(2));
  return 0;
}

}  // namespace

void add_study_power(Command& study, Run& run) {
  Command* command = study.add_subcommand("power", "How many participants it takes, by simulated studies");
  command->footer(
      "Two conditions within every participant; answers by a logistic model with participants (and clips, with "
      "--clip-sd)\n"
      "that differ; each simulated study is analysed by the mixed model that `study analyze` fits, Wald test of the "
      "effect.\nWith PLAN, participants, clips, repeats and level are the plan's where they are not given.\n\n"
      "Examples:\n  crowdbench study power --effect 0.5 --participants 8,16,24\n"
      "  crowdbench study power studies/plans/equivalence.toml --effect 0.4 --json\n"
      "  crowdbench study power --effect 0.4 --participant-sd 0.6 --clip-sd 0.5 --clips 12 --simulations 200 --json");
  auto options = std::make_shared<Options>();
  Options& o = *options;
  command->add_option("PLAN", o.plan, "a study's plan")->type_name("FILE.toml");
  command->add_option("--participants", o.participants, "numbers of participants to try (8, 16, 24, 32)")
      ->delimiter(',')
      ->whole_number(2, 10000);
  command->add_option("--effect", o.settings.effect, "between the two conditions, in logits")
      ->capture_default_str()
      ->number(-20, 20);
  command->add_option("--intercept", o.settings.intercept, "half way between them, in logits")
      ->capture_default_str()
      ->number(-20, 20);
  command->add_option("--participant-sd", o.settings.participant_sd, "between participants, in logits")
      ->capture_default_str()
      ->number(0, 20);
  command
      ->add_option("--clip-sd", o.settings.clip_sd,
                   "between clips, in logits; 0: clips are alike, and not random in the model")
      ->capture_default_str()
      ->number(0, 20);
  command->add_option("--clips", o.clips, "clips a condition (10)")->whole_number(1, 1000);
  command->add_option("--repeats", o.repeats, "of each clip in each condition, by every participant (2)")
      ->whole_number(1, 1000);
  command->add_option("--alpha", o.alpha, "level of the test (0.05)")->number(1e-6, 0.5);
  command->add_option("--simulations", o.simulations, "studies that are simulated")
      ->capture_default_str()
      ->whole_number(1, 100000);
  command->add_option("--seed", o.settings.seed, "seed of the simulated observers")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_power(*options); }; });
}

}  // namespace crowdbench::bench
