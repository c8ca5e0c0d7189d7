// What the rows of `tune` say, in sentences. Pure functions of the store's rows.
#pragma once
#include <string>
#include <vector>

#include "reports/model/score_doc.h"
#include "store/rows.h"

namespace crowdbench::reports {

// "From the eye to 12.5 m draw mesh; from 12.5 m on (figures of 53.2 pixels and less) flat.", then what is allowed,
// what it saves, what was promised and whether that held, each a sentence for people.
std::vector<std::string> tuning_sentences(const TuningRow& row, const std::vector<ScoreDoc>& docs);

// "22.0 to 26.0 px in 97 % of the resamples", "undecided: in 50 % of the resamples"
std::string certainty_text(const TunedSwitchRow& row);

}  // namespace crowdbench::reports
