#include "reports/model/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "reports/model/number_text.h"

namespace crowdbench::reports {

std::vector<HistorySeries> history_of(std::span<const StoreContents> files, const ChangePointOptions& options) {
  using SeriesKey = std::tuple<std::string, std::string, std::string, std::string, PointKey>;
  std::map<SeriesKey, HistorySeries> all;
  for (const StoreContents& contents : files) {
    std::map<int64_t, const RunRow*> runs;
    for (const RunRow& run : contents.runs) runs[run.id] = &run;
    for (const RatioRow& row : contents.ratios) {
      const auto found = runs.find(row.run);
      if (found == runs.end() || row.kind != "speed" || row.metric != found->second->headline || !(row.low > 0))
        continue;
      const RunRow& run = *found->second;
      HistorySeries& series = all[{run.scenario_hash, run.gl_renderer, row.metric, row.to, row.of}];
      series.scenario = run.scenario_name;
      series.key = row.of;
      series.metric = row.metric;
      series.values.push_back({1 / row.ratio, 1 / row.high, 1 / row.low, run.revision, run.started});
    }
  }
  std::vector<HistorySeries> out;
  for (auto& [key, series] : all) {
    if (series.values.size() < 2) continue;
    std::stable_sort(series.values.begin(), series.values.end(),
                     [](const HistoryValue& a, const HistoryValue& b) { return a.started < b.started; });
    std::vector<double> values;
    for (const HistoryValue& value : series.values) values.push_back(value.value);
    for (const ChangePoint& point : change_points(values, options)) {
      const HistoryValue& first = series.values[point.index];
      series.changes.push_back({point, first.revision, first.started, series.values[point.index - 1].revision});
    }
    out.push_back(std::move(series));
  }
  return out;
}

std::string series_name(const HistorySeries& series) {
  const PointKey& key = series.key;
  return fmt::format("{}, {}, {}, {}, {} \u00d7 {}", key.representation, key.character, agents_text(key.agents),
                     occupancy_text(key.requested_occupancy), key.width, key.height);
}

}  // namespace crowdbench::reports
