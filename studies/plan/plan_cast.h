// Whether the characters and clips of a plan are there: what only those find who load them.
#pragma once
#include <filesystem>

#include "studies/plan/plan.h"

namespace crowdbench::studies {

// Loads the characters of every condition, each set of them once, as drawing it would; draws nothing. file: that `plan`
// was read from, which is read again for the lines. Throws Error naming file and line of what is not there: a file, a
// clip, an option of the built-in character.
void require_cast(const std::filesystem::path& file, const StudyPlan& plan);

}  // namespace crowdbench::studies
