#include "bench/experiments/bench_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "bench/experiments/point_name.h"
#include "bench/timing/control.h"

namespace crowdbench::bench {
namespace {

std::string interval_text(const std::optional<TimeSummary>& time) {
  return time ? fmt::format("{:.3f} [{:.3f}, {:.3f}]", time->median / 1e6, time->low / 1e6, time->high / 1e6) : "-";
}

// The controls of the points that were measured now, in the headline's time.
std::string controls_text(const StoreContents& contents, const RunRow& run, size_t wide) {
  std::string out;
  for (const ControlRow& row : contents.controls)
    if (row.run == run.id && row.metric == run.headline)
      out += fmt::format(
          "{:<{}} A/A, {} against itself, {}: {}\n", view_name(row.of.requested_occupancy), wide, row.of.representation,
          agents_text(row.of.agents),
          control_text({row.ratio, {row.low, row.high}, static_cast<size_t>(row.pairs)}, row.p, row.detectable));
  return out;
}

}  // namespace

std::string bench_table(const StoreContents& contents, const RunRow& run) {
  std::map<int64_t, const RunRow*> runs;
  for (const RunRow& row : contents.runs) runs[row.id] = &row;
  std::map<std::tuple<double, std::string, uint32_t>, const MeasurementRow*> rows;
  for (const MeasurementRow& row : contents.measurements) {
    const auto of = runs.find(row.run);
    if (of == runs.end() || of->second->scenario_hash != run.scenario_hash || of->second->revision != run.revision ||
        of->second->gl_renderer != run.gl_renderer)
      continue;
    rows[{row.key.requested_occupancy, row.key.representation, row.key.agents}] = &row;
  }
  size_t wide = 10;
  for (const auto& [place, row] : rows) wide = std::max(wide, view_name(row->key.requested_occupancy).size());
  std::string out =
      fmt::format("{:<{}} {:<28} {:>7}  {:>28}  {:>28}  {:>22}  {:>8}\n", "occupancy", wide, "representation", "agents",
                  "CPU ms [95 %]", "wall ms [95 %]", "times as fast (" + run.headline + ")", "covered");
  for (const auto& [place, row] : rows) {
    std::string speed = "-";
    for (const RatioRow& ratio : contents.ratios)
      if (ratio.kind == "speed" && ratio.of == row->key && ratio.metric == run.headline)
        speed = fmt::format("{:.2f} [{:.2f}, {:.2f}]", ratio.ratio, ratio.low, ratio.high);
    const std::string name = row->key.representation;
    out += fmt::format("{:<{}} {:<28} {:>7}  ", view_name(row->key.requested_occupancy), wide, name, row->key.agents);
    if (!row->frame_ns) {
      out += fmt::format("{}: {}\n", status_name(row->status), row->reason);
      continue;
    }
    const double pixels = static_cast<double>(row->key.width) * row->key.height;
    out +=
        fmt::format("{:>28}  {:>28}  {:>22}  {:>8}{}\n", interval_text(row->cpu_ns), interval_text(row->frame_ns),
                    speed, row->covered_px ? percent_text(static_cast<double>(*row->covered_px) / pixels) : "-",
                    row->status == Status::valid ? "" : fmt::format("  {}: {}", status_name(row->status), row->reason));
  }
  return out + controls_text(contents, run, wide);
}

}  // namespace crowdbench::bench
