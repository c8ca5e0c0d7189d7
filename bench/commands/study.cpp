#include "bench/commands/study.h"

#include "bench/commands/command_line.h"

namespace crowdbench::bench {

void add_study(Command& app, Run& run) {
  Command* study = app.add_subcommand("study", "A user study: whether anybody can see it");
  study->footer(
      "Examples:\n  crowdbench study export studies/plans/switch_distance.toml --dry-run   what a plan comes to\n"
      "  crowdbench study analyze answers.csv   thresholds, rankings and verdicts of answers");
  add_study_freeze(*study, run);
  add_study_export(*study, run);
  add_study_serve(*study, run);
  add_study_answers(*study, run);
  add_study_analyze(*study, run);
  add_study_simulate(*study, run);
  add_study_power(*study, run);
}

}  // namespace crowdbench::bench
