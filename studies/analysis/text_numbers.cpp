#include "studies/analysis/text_numbers.h"

#include <fmt/format.h>

#include "core/error.h"

namespace crowdbench::studies::text {

std::string named(const std::string& name) { return name.empty() ? "all" : printable(name, 80); }

std::string percent(uint64_t part, uint64_t whole) {
  return whole == 0 ? "-" : fmt::format("{:.0f} %", 100 * static_cast<double>(part) / static_cast<double>(whole));
}

std::string p_text(double p) { return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p); }

std::string number(std::optional<double> value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

std::string ends_text(const std::optional<double>& low, const std::optional<double>& high) {
  return fmt::format("{} to {}", low ? number(low) : "below all", high ? number(high) : "above all");
}

}  // namespace crowdbench::studies::text
