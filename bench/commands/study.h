// The commands of a study, one file each: study_NAME.cpp, and one line in study.cpp.
#pragma once
#include "bench/commands/commands.h"

namespace crowdbench::bench {

void add_study_analyze(Command& study, Run& run);
void add_study_answers(Command& study, Run& run);
void add_study_export(Command& study, Run& run);
void add_study_freeze(Command& study, Run& run);
void add_study_power(Command& study, Run& run);
void add_study_serve(Command& study, Run& run);
void add_study_simulate(Command& study, Run& run);

}  // namespace crowdbench::bench
