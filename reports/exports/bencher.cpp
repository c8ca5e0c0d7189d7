#include "reports/exports/bencher.h"

#include <cmath>
#include <map>

#include "core/json.h"
#include "reports/exports/point_path.h"

namespace crowdbench::reports {
namespace {

Json interval_json(double value, double low, double high) {
  return {{"value", value}, {"lower_value", low}, {"upper_value", high}};
}

void put_time(Json& measures, const char* name, const std::optional<TimeSummary>& time) {
  if (time) measures[name] = interval_json(time->median, time->low, time->high);
}

}  // namespace

std::string bencher_json(const StoreContents& contents) {
  std::map<PointKey, const MeasurementRow*> latest;
  for (const MeasurementRow& row : contents.measurements)
    if (row.status == Status::valid && row.frame_ns) latest[row.key] = &row;
  Json all = Json::object();
  for (const auto& [key, row] : latest) {
    Json measures = Json::object();
    put_time(measures, "wall-time", row->frame_ns);
    put_time(measures, "cpu-time", row->cpu_ns);
    put_time(measures, "gpu-time", row->gpu_ns);
    for (const RatioRow& ratio : contents.ratios)
      if (ratio.kind == "speed" && ratio.of == key && ratio.run == row->run && ratio.low > 0)
        measures["times-as-slow-as-reference-" + ratio.metric] =
            interval_json(1 / ratio.ratio, 1 / ratio.high, 1 / ratio.low);
    for (const ComparisonRow& comparison : contents.comparisons) {
      if (comparison.kind != "crowd" || comparison.representation != key.representation ||
          comparison.agents != key.agents || comparison.requested_occupancy != key.requested_occupancy ||
          comparison.character != key.character || comparison.run != row->run)
        continue;
      for (const ScoreRow& score : comparison.scores)
        if (score.value && std::isfinite(*score.value)) measures["score-" + score.name] = Json{{"value", *score.value}};
    }
    all[point_path(key)] = measures;
  }
  return all.dump(2) + "\n";
}

}  // namespace crowdbench::reports
