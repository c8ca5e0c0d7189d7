#include "bench/commands/commands.h"

#include "bench/commands/command_line.h"

namespace crowdbench::bench {

// In the order that --help lists them.

void add_all_commands(Command& app, Run& run) {
  // One a line, so that two additions do not meet.
  // clang-format off
  const std::initializer_list<AddCommand> commands = {
      add_info,
      add_inspect,
      add_render,
      add_bake,
      add_cache,
      add_pose,
      add_compare,
      add_quality,
      add_switch_distance,
      add_popmap,
      add_popping,
      add_distance,
      add_tune,
      add_stability,
      add_ratio,
      add_bench,
      add_sweep,
      add_merge,
      add_pair,
      add_study,
      add_view,
      add_correlate,
      add_regress,
      add_history,
      add_model,
      add_export,
      add_report,
      add_demo,
      add_schema,
  };
  // clang-format on
  for (const AddCommand add : commands) add(app, run);
}

}  // namespace crowdbench::bench
