// What may be written in a paper of one task's results: a sentence a finding, with its numbers, and with what was not
// found said as such.
#pragma once
#include <string>
#include <vector>

#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

std::vector<std::string> verdict_sentences(const TaskResult& task, const AnalysisSettings& settings);

}  // namespace crowdbench::studies
