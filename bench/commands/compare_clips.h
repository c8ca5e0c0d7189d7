// `compare` of clips and folders of frames: every score of every frame, the whole, the worst frame.
#pragma once
#include "bench/commands/compare_input.h"

namespace crowdbench::bench {

// Reads frame by frame; shows progress. Returns the exit status: 1 where a bound is broken. Throws Error, and
// Interrupted after Ctrl-C.
int compare_clips(const CompareOptions& options, metrics::ScoreTable table);

}  // namespace crowdbench::bench
