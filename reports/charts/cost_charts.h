// Charts of cost models, fronts and raw frame times, as Vega-Lite specifications.
#pragma once
#include <string>
#include <vector>

#include "reports/model/break_even.h"
#include "reports/model/pareto.h"
#include "reports/model/scene.h"

namespace crowdbench::reports {

// Every timed point's time against agents, log-log, with its interval: of scenes whose occupancies have one crowd each,
// so that no curve is to be drawn.
std::string scatter_chart(const Scene& scene);
// Predicted against measured time of the points that a model was not fitted to, log-log, with the 15 % on either side.
// Empty text where no model is.
std::string prediction_chart(const Scene& scene, const std::vector<CostModel>& models);
// Which representation is the cheapest over agents and occupancy, pale where it cannot be told from another; where only
// one occupancy was measured a single row. Empty text without a map.
std::string cheapest_chart(const Scene& scene, const BreakEvenMap& map);
// Error against time over the reference's, sized by bytes; what is beaten is pale. Empty text without errors.
std::string front_chart(const Scene& scene, const ParetoFront& front);

// The rows whose raw samples are plotted: of the largest crowd of an occupancy that at least two were timed with.
std::vector<const MeasurementRow*> sampled_rows(const Scene& scene, double occupancy);
// Every timed frame in the order drawn; a budget of 60 frames a second as a line where it is near.
std::string samples_chart(const Scene& scene, const std::vector<const MeasurementRow*>& rows);
// How often which time.
std::string histogram_chart(const Scene& scene, const std::vector<const MeasurementRow*>& rows);

}  // namespace crowdbench::reports
