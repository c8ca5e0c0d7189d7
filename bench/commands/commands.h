// The driver's commands: one file a command in bench/commands/, one line here and in commands.cpp.
#pragma once
#include <functional>
#include <string>

namespace crowdbench::bench {

class Command;

// Adds a subcommand; its callback stores what to run in `run`, which returns the exit status (0 fine, 1 a check failed;
// an Error thrown becomes 2). Every command has a one-line description, an example in its footer and --json where it
// prints facts.
using Run = std::function<int()>;
using AddCommand = void (*)(Command& app, Run& run);

void add_bake(Command& app, Run& run);
void add_cache(Command& app, Run& run);
void add_bench(Command& app, Run& run);
void add_compare(Command& app, Run& run);
void add_correlate(Command& app, Run& run);
void add_demo(Command& app, Run& run);
void add_distance(Command& app, Run& run);
void add_export(Command& app, Run& run);
void add_history(Command& app, Run& run);
void add_info(Command& app, Run& run);
void add_inspect(Command& app, Run& run);
void add_merge(Command& app, Run& run);
void add_model(Command& app, Run& run);
void add_pair(Command& app, Run& run);
void add_quality(Command& app, Run& run);
void add_popmap(Command& app, Run& run);
void add_popping(Command& app, Run& run);
void add_pose(Command& app, Run& run);
void add_ratio(Command& app, Run& run);
void add_regress(Command& app, Run& run);
void add_render(Command& app, Run& run);
void add_report(Command& app, Run& run);
void add_schema(Command& app, Run& run);
void add_stability(Command& app, Run& run);
void add_study(Command& app, Run& run);
void add_sweep(Command& app, Run& run);
void add_switch_distance(Command& app, Run& run);
void add_tune(Command& app, Run& run);
void add_view(Command& app, Run& run);

void add_all_commands(Command& app, Run& run);

}  // namespace crowdbench::bench
