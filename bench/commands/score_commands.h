// The commands that score pictures, with the table of scores that they walk: commands.h has them with the whole one.
#pragma once
#include "bench/commands/commands.h"
#include "metrics/registry.h"

namespace crowdbench::bench {

// table: of scores that outlive the command.
void add_compare(Command& app, Run& run, metrics::ScoreTable table);
void add_correlate(Command& app, Run& run, metrics::ScoreTable table);
void add_distance(Command& app, Run& run, metrics::ScoreTable table);
void add_quality(Command& app, Run& run, metrics::ScoreTable table);
void add_popmap(Command& app, Run& run, metrics::ScoreTable table);

}  // namespace crowdbench::bench
