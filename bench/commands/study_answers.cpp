#include <fmt/format.h>

#include <map>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/server/answers_export.h"
#include "studies/server/study_folder.h"

namespace crowdbench::bench {
namespace {

struct StudyAnswersOptions {
  std::vector<std::string> files;
  std::string study, csv, lines, jspsych;
  bool levels = false;
  bool json = false;
};

int run_answers(const StudyAnswersOptions& o) {
  const studies::StudyFolder folder = studies::read_study_folder(o.study);
  const studies::StudyAnswers answers = studies::read_study_answers({o.files.begin(), o.files.end()}, folder.study);
  if (!o.csv.empty()) write_file(o.csv, std::string_view(studies::answers_csv(answers, o.study, o.levels)));
  if (!o.lines.empty()) write_file(o.lines, std::string_view(studies::json_lines(answers)));
  if (!o.jspsych.empty()) write_file(o.jspsych, std::string_view(studies::jspsych_json(answers)));
  std::map<std::string, int> states = {{"started", 0}, {"finished", 0}, {"withdrawn", 0}};
  for (const StudyParticipantRow& row : answers.participants) ++states[row.state];
  size_t trials = 0;
  for (const StudyAnswerRow& row : answers.answers) trials += row.kind == "page" ? 0 : 1;
  if (o.json) {
    fmt::print("{}\n", Json{{"study", folder.study},
                            {"participants", answers.participants.size()},
                            {"finished", states["finished"]},
                            {"unfinished", states["started"]},
                            {"withdrawn", states["withdrawn"]},
                            {"trials", trials},
                            {"records", answers.answers.size()}}
                           .dump(2));
  } else {
    fmt::print("{} finished, {} did not, {} withdrew; {} answered\n",
               counted(states["finished"], "participant", "participants"), states["started"], states["withdrawn"],
               counted(trials, "trial", "trials"));
  }
  return 0;
}

}  // namespace

void add_study_answers(Command& study, Run& run) {
  Command* command =
      study.add_subcommand("answers", "Collected answers as tables: for `study analyze` and other tools");
  command->footer(
      "Examples:\n  crowdbench study answers study-out/answers.sqlite --study study-out --csv answers.csv\n"
      "  crowdbench study answers answers-1.json answers-2.json --study study-out --csv answers.csv --json\n"
      "The second is for files that the page saved on a static server.");
  auto options = std::make_shared<StudyAnswersOptions>();
  StudyAnswersOptions& o = *options;
  command->add_option("FILE", o.files, "what `study serve` keeps answers in, or what the page saved")
      ->required()
      ->type_name("FILE.sqlite|FILE.json");
  command->add_option("--study", o.study, "folder that `study export` made")->required()->type_name("OUT");
  command->add_option("--csv", o.csv, "one row a trial, what was shown by name, as `study analyze` reads it")
      ->type_name("FILE.csv")
      ->output_file();
  command->add_flag("--levels", o.levels,
                    "of --csv: only trials whose level is a number; without, `level` is left out where any has none");
  command->add_option("--json-lines", o.lines, "every record, one a line")->type_name("FILE.jsonl")->output_file();
  command->add_option("--jspsych", o.jspsych, "every record, as jsPsych saves them")
      ->type_name("FILE.json")
      ->output_file();
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_answers(*options); }; });
}

}  // namespace crowdbench::bench
