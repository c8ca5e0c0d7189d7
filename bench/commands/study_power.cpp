#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/json.h"
#include "studies/analysis/power.h"

namespace crowdbench::bench {
namespace {

struct Options {
  std::vector<uint32_t> participants = {8, 16, 24, 32};
  studies::PowerSettings settings;
  uint64_t simulations = 1000;
  bool json = false;
};

int run_power(const Options& options) {
  Json rows = Json::array();
  if (!options.json)
    fmt::print(
        "simulated: {:g} logits between two conditions, {} clips x {} repeats in either, {} studies a row\n"
        "{:>12} {:>8} {:>7} {:>10} {:>10} {:>9} {:>7}\n",
        options.settings.effect, options.settings.clips, options.settings.repeats, options.simulations, "participants",
        "trials", "power", "+-", "CI width", "singular", "failed");
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
  if (options.json) fmt::print("{}\n", Json{{"observers", "simulated"}, {"rows", rows}}.dump(2));
  return 0;
}

}  // namespace

void add_study_power(Command& study, Run& run) {
  Command* command = study.add_subcommand("power", "How many participants it takes, by simulated studies");
  command->footer(
      "Two conditions within every participant; answers by a logistic model with participants (and clips, with "
      "--clip-sd)\n"
      "that differ; each simulated study is analysed by the mixed model that `study analyze` fits, Wald test of the "
      "effect.\n\n"
      "Examples:\n  crowdbench study power --effect 0.5 --participants 8,16,24\n"
      "  crowdbench study power --effect 0.4 --participant-sd 0.6 --clip-sd 0.5 --clips 12 --simulations 200 --json");
  auto options = std::make_shared<Options>();
  Options& o = *options;
  command->add_option("--participants", o.participants, "numbers of participants to try")
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
  command->add_option("--clips", o.settings.clips, "clips a condition")->capture_default_str()->whole_number(1, 1000);
  command->add_option("--repeats", o.settings.repeats, "of each clip in each condition, by every participant")
      ->capture_default_str()
      ->whole_number(1, 1000);
  command->add_option("--alpha", o.settings.alpha, "level of the test")->capture_default_str()->number(1e-6, 0.5);
  command->add_option("--simulations", o.simulations, "studies that are simulated")
      ->capture_default_str()
      ->whole_number(1, 100000);
  command->add_option("--simulation-seed", o.settings.seed, "seed of the simulated observers")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_power(*options); }; });
}

}  // namespace crowdbench::bench
