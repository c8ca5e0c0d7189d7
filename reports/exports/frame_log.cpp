#include "reports/exports/frame_log.h"

#include <fmt/format.h>

#include "reports/exports/point_path.h"

namespace crowdbench::reports {
namespace {

std::string milliseconds(int64_t nanoseconds) { return fmt::format("{:.6f}", static_cast<double>(nanoseconds) / 1e6); }

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    out += c;
    if (c == '"') out += c;
  }
  return out + '"';
}

}  // namespace

std::string frame_log_csv(const StoreContents& contents) {
  std::string out =
      "Application,MsBetweenPresents,MsCPUBusy,MsGPUTime,Run,Round,Tick,MsProcessCPU,Agents,OccupiedPx\r\n";
  for (const MeasurementRow& row : contents.measurements) {
    const std::string name = quoted(point_path(row.key));
    const std::string covered = row.covered_px ? fmt::format("{}", *row.covered_px) : "";
    for (const SampleRow& sample : row.samples)
      out += fmt::format("{},{},{},{},{},{},{},{},{},{}\r\n", name, milliseconds(sample.frame_ns),
                         milliseconds(sample.main_cpu_ns), sample.gpu_ns ? milliseconds(*sample.gpu_ns) : "", row.run,
                         sample.round, sample.tick, milliseconds(sample.cpu_ns), row.key.agents, covered);
  }
  return out;
}

}  // namespace crowdbench::reports
