#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/analysis/simulated.h"

namespace crowdbench::bench {
namespace {

struct Options {
  std::string out;
  studies::SimulatedObservers observers;
  studies::SimulatedDesign design;
  uint64_t seed = 1;
  bool json = false;
};

int run_simulate(const Options& o) {
  if (o.observers.guess + o.observers.lapse >= 1)
    throw Error("--guess", "with --lapse leaves nothing to see", "their sum is to be below 1");
  const studies::Answers answers = studies::simulate_answers(o.observers, o.design, o.seed);
  write_file(o.out, std::string_view(studies::answers_csv(answers)));
  if (o.json)
    fmt::print("{}\n", Json{{"observers", "simulated"},
                            {"participants", o.design.participants},
                            {"answers", answers.rows.size()},
                            {"file", o.out}}
                           .dump(2));
  else
    fmt::print("{} answers of {} simulated observers: {}\n", answers.rows.size(), o.design.participants, o.out);
  return 0;
}

void add_observer_options(Command& command, studies::SimulatedObservers& o) {
  const auto add = [&](const char* name, double& value, const char* meaning, double least, double most) {
    command.add_option(name, value, meaning)->capture_default_str()->number(least, most);
  };
  add("--threshold", o.threshold, "level at which the typical observer is half way", -1e6, 1e6);
  add("--slope", o.slope, "logits by unit of level; below 0: seen less the higher the level", -1e3, 1e3);
  add("--threshold-sd", o.threshold_sd, "of thresholds between observers", 0, 1e6);
  add("--slope-sd", o.slope_log_sd, "of the logs of slopes between observers", 0, 5);
  add("--clip-sd", o.clip_sd, "between clips, in logits", 0, 20);
  add("--guess", o.guess, "rate of guesses", 0, 0.95);
  add("--lapse", o.lapse, "rate of slips", 0, 0.5);
  add("--side-bias", o.side_bias, "logits for what stands first", -20, 20);
  add("--learning", o.learning, "logits gained from the first trial to the last", -20, 20);
}

}  // namespace

void add_study_simulate(Command& study, Run& run) {
  Command* command = study.add_subcommand("simulate", "Answers of simulated observers, as a table");
  command->footer(
      "Every observer sees every clip at every level, in an order of their own. The table is one that `study analyze` "
      "reads.\n\n"
      "Examples:\n  crowdbench study simulate --participants 24 --levels 5,10,15,20 --threshold 12 --slope 0.5 "
      "--threshold-sd 2 --out answers.csv\n"
      "  crowdbench study simulate --levels 0,1,2,3 --threshold 1 --guess 0.5 --clips 6 --clip-sd 0.4 --out "
      "answers.csv --json");
  auto options = std::make_shared<Options>();
  Options& o = *options;
  command->add_option("--out", o.out, "the table")->required()->type_name("FILE.csv")->output_file();
  command->add_option("--participants", o.design.participants, "simulated observers")
      ->capture_default_str()
      ->whole_number(1, 100000);
  command->add_option("--levels", o.design.levels, "levels that are shown")
      ->required()
      ->delimiter(',')
      ->number(-1e9, 1e9);
  command->add_option("--clips", o.design.clips, "clips a level")->capture_default_str()->whole_number(1, 1000);
  command->add_option("--repeats", o.design.repeats, "of each clip at each level")
      ->capture_default_str()
      ->whole_number(1, 1000);
  add_observer_options(*command, o.observers);
  command->add_option("--simulation-seed", o.seed, "seed of the simulated observers")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_simulate(*options); }; });
}

}  // namespace crowdbench::bench
