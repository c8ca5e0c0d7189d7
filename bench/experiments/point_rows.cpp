#include "bench/experiments/point_rows.h"

namespace crowdbench::bench {

void put_stage(MeasurementRow& row, const StageFacts& facts) {
  row.achieved_occupancy = facts.coverage.occupancy;
  row.agents_wholly = facts.on_screen.wholly;
  row.agents_partly = facts.on_screen.partly;
  row.agents_off = facts.on_screen.off;
}

std::vector<RatioRow> ratio_rows(int64_t run, const PointKey& of, const VariantTimes& times,
                                 const std::string& reference, const VariantTimes* reference_times,
                                 const VariantTimes* floor_times) {
  std::vector<RatioRow> rows;
  for (const Metric metric : {Metric::cpu, Metric::wall, Metric::gpu}) {
    const auto add = [&](const char* kind, const std::string& to, const VariantTimes& above,
                         const VariantTimes& below) {
      if (const auto ratio = paired_ratio(above.samples, below.samples, metric, kBootstrapSeed))
        rows.push_back(RatioRow{0, run, kind, of, to, metric_name(metric), ratio->median, ratio->interval.low,
                                ratio->interval.high, static_cast<int>(ratio->pairs)});
    };
    if (reference_times != nullptr) add("speed", reference, *reference_times, times);
    if (floor_times != nullptr) add("floor", "floor=1", times, *floor_times);
  }
  return rows;
}

}  // namespace crowdbench::bench
