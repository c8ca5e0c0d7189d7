// The commands that score pictures or tell of scores, with the table of scores that they walk: commands.h has them with
// the whole one.
#pragma once
#include "bench/commands/commands.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

// table: of scores that outlive the command.
void add_bench(Command& app, Run& run, metrics::ScoreTable table);
void add_compare(Command& app, Run& run, metrics::ScoreTable table);
void add_correlate(Command& app, Run& run, metrics::ScoreTable table);
void add_demo(Command& app, Run& run, metrics::ScoreTable table);
void add_distance(Command& app, Run& run, metrics::ScoreTable table);
void add_export(Command& app, Run& run, metrics::ScoreTable table);
void add_quality(Command& app, Run& run, metrics::ScoreTable table);
void add_popmap(Command& app, Run& run, metrics::ScoreTable table);
void add_report(Command& app, Run& run, metrics::ScoreTable table);

}  // namespace crowdbench::bench
