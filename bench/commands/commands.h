// The driver's commands: one file a command in bench/commands/, one line here and in commands.cpp.
#pragma once
#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace crowdbench::bench {

// Adds a subcommand; its callback stores what to run in `run`, which returns the exit status (0 fine, 1 a check failed;
// an Error thrown becomes 2). Every command has a one-line description, an example in its footer and --json where it
// prints facts.
using Run = std::function<int()>;
using AddCommand = void (*)(CLI::App& app, Run& run);

void add_bake(CLI::App& app, Run& run);
void add_bench(CLI::App& app, Run& run);
void add_compare(CLI::App& app, Run& run);
void add_demo(CLI::App& app, Run& run);
void add_info(CLI::App& app, Run& run);
void add_inspect(CLI::App& app, Run& run);
void add_pair(CLI::App& app, Run& run);
void add_quality(CLI::App& app, Run& run);
void add_popmap(CLI::App& app, Run& run);
void add_pose(CLI::App& app, Run& run);
void add_ratio(CLI::App& app, Run& run);
void add_render(CLI::App& app, Run& run);
void add_report(CLI::App& app, Run& run);
void add_schema(CLI::App& app, Run& run);
void add_switch_distance(CLI::App& app, Run& run);
void add_view(CLI::App& app, Run& run);

void add_all_commands(CLI::App& app, Run& run);

}  // namespace crowdbench::bench
