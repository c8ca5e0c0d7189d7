// Cost models, contours and fronts in words, for tables of any form.
#pragma once
#include <string>
#include <vector>

#include "reports/model/break_even.h"
#include "reports/model/cost_model.h"
#include "reports/model/pareto.h"

namespace crowdbench::reports {

// "0.41 ms a frame + 8.2 µs an agent + 3.1 ns a covered pixel".
std::string formula_text(const CostFit& fit);
// "11 of 12 within 15 % (95 % interval of the share 62 % to 100 %); error 6.1 %; of those between the others 8 of 8,
// error 4.0 %": of points that were not fitted.
std::string accuracy_text(const CostModel& model);
// Every pair with the reference, a sentence an occupancy that was measured or lies between.
std::vector<std::string> break_even_sentences(const Scene& scene, const BreakEvenMap& map);
// "0.42 (0.40 to 0.44)": time over the reference's.
std::string time_ratio_text(const ParetoEntry& entry);
// "on the front", "beaten by flat"; where others have a score and it has none, that it cannot be told.
std::string front_text(const ParetoFront& front, const ParetoEntry& entry);

}  // namespace crowdbench::reports
