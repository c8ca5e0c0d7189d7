#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "bench/experiments/study_simulation.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/analysis/simulated.h"

namespace crowdbench::bench {
namespace {

struct StudySimulateOptions {
  std::string study, out;
  SimulatedStudy simulated;
  studies::SimulatedDesign design;
  std::vector<std::string> worths;
  std::optional<double> guess;
  bool json = false;
};

// "ITEM=LOGWORTH"; an item's name may hold an equals sign itself.
void set_worth(const std::string& text, std::map<std::string, double>& to) {
  const size_t equals = text.rfind('=');
  size_t used = 0;
  double worth = 0;
  try {
    if (equals != std::string::npos) worth = std::stod(text.substr(equals + 1), &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || equals + 1 + used != text.size() || !(std::abs(worth) <= 50))
    throw Error("--worth", fmt::format("'{}' is not ITEM=LOGWORTH", printable(text, 80)),
                "with a number from -50 to 50, as mesh=1.5");
  to[text.substr(0, equals)] = worth;
}

size_t write_table(const StudySimulateOptions& o) {
  studies::SimulatedObservers who = o.simulated.who;
  who.guess = o.guess.value_or(0);
  if (who.guess + who.lapse >= 1)
    throw Error("--guess", "with --lapse leaves nothing to see", "their sum is to be below 1");
  studies::SimulatedDesign design = o.design;
  design.participants = o.simulated.observers;
  const studies::Answers answers = studies::simulate_answers(who, design, o.simulated.seed);
  write_file(o.out, std::string_view(studies::answers_csv(answers)));
  return answers.rows.size();
}

size_t write_study(const StudySimulateOptions& o) {
  if (!o.design.levels.empty())
    throw Error("--levels", "is for a table without a study", "leave it out: OUT says what is shown");
  SimulatedStudy simulated = o.simulated;
  simulated.guess = o.guess;
  for (const std::string& worth : o.worths) set_worth(worth, simulated.log_worth);
  const std::filesystem::path file = o.out;
  if (file.extension() != ".csv" && file.extension() != ".sqlite")
    throw Error("--out", fmt::format("'{}' is neither a .csv nor a .sqlite", printable(o.out, 200)),
                "name a table, or a result file as `study serve` keeps one");
  const studies::StudyAnswers answers = simulate_study(o.study, simulated);
  if (file.extension() == ".csv")
    write_file(file, std::string_view(studies::answers_csv(answers, o.study)));
  else
    write_simulated(answers, file);
  return answers.answers.size();
}

int run_simulate(const StudySimulateOptions& o) {
  if (o.study.empty() && o.design.levels.empty())
    throw Error("study simulate", "there is nothing to answer",
                "give the folder of an exported study, or --levels for a table without one");
  const size_t answers = o.study.empty() ? write_table(o) : write_study(o);
  if (o.json)
    fmt::print(
        "{}\n",
        Json{{"observers", "simulated"}, {"participants", o.simulated.observers}, {"answers", answers}, {"file", o.out}}
            .dump(2));
  else
    fmt::print("{} of {}: {}\n", counted(answers, "answer", "answers"),
               counted(o.simulated.observers, "simulated observer", "simulated observers"), o.out);
  return 0;
}

void add_observer_options(Command& command, StudySimulateOptions& options) {
  studies::SimulatedObservers& o = options.simulated.who;
  const auto add = [&](const char* name, double& value, const char* meaning, double least, double most) {
    command.add_option(name, value, meaning)->capture_default_str()->number(least, most);
  };
  add("--threshold", o.threshold, "level at which the typical observer is half way", -1e6, 1e6);
  add("--slope", o.slope, "logits by unit of level; below 0: seen less the higher the level", -1e3, 1e3);
  add("--threshold-sd", o.threshold_sd, "of thresholds between observers", 0, 1e6);
  add("--slope-sd", o.slope_log_sd, "of the logs of slopes between observers", 0, 5);
  add("--clip-sd", o.clip_sd, "between clips, in logits", 0, 20);
  command.add_option("--guess", options.guess, "rate of guesses (of OUT: 0.5, of same-different 0.1; of a table: 0)")
      ->type_name("RATE")
      ->number(0, 0.95);
  add("--lapse", o.lapse, "rate of slips", 0, 0.5);
  add("--side-bias", o.side_bias, "logits for what stands first", -20, 20);
  add("--learning", o.learning, "logits gained from the first trial to the last", -20, 20);
  add("--cannot-tell", options.simulated.cannot_tell, "of OUT: said of what is not seen, where the task offers it", 0,
      1);
  command
      .add_option("--worth", options.worths,
                  "of OUT without levels, and of pairs: log-worth of a half, as sides.json names it (0)")
      ->type_name("ITEM=LOGWORTH")
      ->expected(1)
      ->take_all();
  add("--tie", options.simulated.log_nu, "of OUT, with --worth: log of how often ties are said", -20, 20);
}

}  // namespace

void add_study_simulate(Command& study, Run& run) {
  Command* command = study.add_subcommand("simulate", "Answers of simulated observers");
  command->footer(
      "With OUT, the folder of `study export`, observers answer its lists, trials and catch trials in their order "
      "(adaptive\n"
      "ones by the study's own rule), and --out is a result file as `study serve` keeps one, or a table. With "
      "--levels,\n"
      "every observer sees every clip at every level, in an order of their own, and --out is a table. `study analyze` "
      "reads\n"
      "both.\n\n"
      "Examples:\n  crowdbench study simulate out --observers 24 --threshold 12 --slope -0.5 --seed 7 --out "
      "answers.sqlite\n"
      "  crowdbench study simulate --observers 24 --levels 5,10,15,20 --threshold 12 --slope 0.5 "
      "--threshold-sd 2 --out answers.csv\n"
      "  crowdbench study simulate --levels 0,1,2,3 --threshold 1 --guess 0.5 --clips 6 --clip-sd 0.4 --out "
      "answers.csv --json");
  auto options = std::make_shared<StudySimulateOptions>();
  StudySimulateOptions& o = *options;
  command->add_option("OUT", o.study, "folder that `study export` made")->type_name("FOLDER");
  command->add_option("--out", o.out, "what is written: a table, or with OUT also a new result file")
      ->required()
      ->type_name("FILE.csv|FILE.sqlite")
      ->output_file();
  command->add_option("--observers", o.simulated.observers, "simulated observers")
      ->capture_default_str()
      ->whole_number(1, 100000);
  command->add_option("--levels", o.design.levels, "levels that are shown, without OUT")
      ->delimiter(',')
      ->number(-1e9, 1e9);
  command->add_option("--clips", o.design.clips, "clips a level, without OUT")
      ->capture_default_str()
      ->whole_number(1, 1000);
  command->add_option("--repeats", o.design.repeats, "of each clip at each level, without OUT")
      ->capture_default_str()
      ->whole_number(1, 1000);
  add_observer_options(*command, o);
  command->add_option("--seed", o.simulated.seed, "seed of the simulated observers")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_simulate(*options); }; });
}

}  // namespace crowdbench::bench
