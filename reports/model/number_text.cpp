#include "reports/model/number_text.h"

#include <fmt/format.h>

#include <cmath>

namespace crowdbench::reports {

std::string count_text(uint64_t count) {
  std::string digits = std::to_string(count);
  for (int place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3)
    digits.insert(static_cast<size_t>(place), 1, ',');
  return digits;
}

std::string agents_text(uint64_t count) {
  return fmt::format("{} {}", count_text(count), count == 1 ? "agent" : "agents");
}

std::string time_text(double nanoseconds) {
  const double ms = nanoseconds / 1e6;
  if (ms < 0.1) return fmt::format("{:.1f} \u00b5s", nanoseconds / 1e3);
  if (ms < 10) return fmt::format("{:.2f} ms", ms);
  if (ms < 100) return fmt::format("{:.1f} ms", ms);
  if (ms < 10000) return fmt::format("{:.0f} ms", ms);
  return fmt::format("{:.1f} s", ms / 1e3);
}

std::string bytes_text(uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 1024) return fmt::format("{} B", bytes);
  if (bytes < (uint64_t{1} << 20)) return fmt::format("{:.1f} KiB", value / 1024);
  if (bytes < (uint64_t{1} << 30)) return fmt::format("{:.1f} MiB", value / (1 << 20));
  return fmt::format("{:.2f} GiB", value / (1 << 30));
}

std::string percent_text(double fraction) {
  const double percent = fraction * 100;
  return std::abs(percent - std::round(percent)) < 0.05 ? fmt::format("{:.0f} %", percent)
                                                        : fmt::format("{:.1f} %", percent);
}

std::string factor_text(double factor) {
  if (factor < 10) return fmt::format("{:.2f}", factor);
  return factor < 100 ? fmt::format("{:.1f}", factor) : fmt::format("{:.0f}", factor);
}

std::string occupancy_text(double occupancy) { return occupancy > 0 ? percent_text(occupancy) : "\u2013"; }

}  // namespace crowdbench::reports
