// Charts of a tuning: errors and costs of one character by distance.
#pragma once
#include <string>

#include "reports/model/tune_model.h"

namespace crowdbench::reports {

// The score at the bad end's 5 % against the distance, near on the left, with its interval as a band, the threshold as
// a dashed line across, the rule's switches as solid lines down and those of rules of thumb as dashed ones in the
// colour of what they switch to; what the rule draws has large points. Without a legend: representation_colours() in
// the curves' order. Empty text where nothing has a score.
std::string tune_error_chart(const TuneGraph& graph);
// What one more agent takes, microseconds, in the same way. Empty text where nothing was timed.
std::string tune_cost_chart(const TuneGraph& graph);

}  // namespace crowdbench::reports
