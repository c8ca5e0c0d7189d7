// Charts as Vega-Lite specifications (JSON text) with their data inside.
#pragma once
#include <string>
#include <vector>

#include "reports/model/pop_model.h"
#include "reports/model/scene.h"
#include "reports/model/score_doc.h"

namespace crowdbench::reports {

// A colour for each representation of a scene, in its order: the reference dark, the others from Okabe and Ito's set
// that colour-blind readers can tell apart.
std::vector<std::string> representation_colours(size_t count);

// Time a frame against agents, log-log, one line a representation with the band of each median's interval, crossings
// marked.
std::string time_chart(const Scene& scene, double occupancy);
// How many times as fast as the reference with its interval, log-log, one line a representation and shown occupancy.
std::string speed_chart(const Scene& scene);
// A score of single agents against their height in pixels; empty text when no agent has it.
std::string score_chart(const Scene& scene, const ScoreDoc& score);

// Azimuth by elevation, a panel a clip phase and kind of switch, coloured by one score from 0 to `high`, the same in
// every chart. scores: those of the points, `ranking` the place of the one that colours.
std::string pop_chart(const PopSize& size, const std::vector<ScoreDoc>& scores, size_t ranking, double high);

}  // namespace crowdbench::reports
