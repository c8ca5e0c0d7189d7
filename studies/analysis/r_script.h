// The mixed models of an analysis as an R script for lme4, and the estimates that it holds its own against. For
// exports.cpp.
#pragma once
#include <string>

#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

std::string r_script(const Analysis& analysis);
// task,condition,effect,estimate,se of every mixed model that has estimates.
std::string estimates_csv(const Analysis& analysis);

}  // namespace crowdbench::studies
