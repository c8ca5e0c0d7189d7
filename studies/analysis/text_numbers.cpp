#include "studies/analysis/text_numbers.h"

#include <fmt/format.h>

#include <charconv>

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

std::string angle_text(const AngleThreshold& a, double confidence) {
  return fmt::format(
      "{:.4g} degrees of visual angle ({:.0f} % interval {}, with the error of calibration, {:.1f} %, of {})",
      a.degrees, 100 * confidence, ends_text(a.low, a.high), 100 * a.calibration_share,
      counted(a.calibrated, "participant", "participants"));
}

std::string spreadsheet_safe(const std::string& field) {
  if (field.empty() || std::string_view("=+-@\t\r\n").find(field.front()) == std::string_view::npos) return field;
  double value = 0;
  const char* begin = field.data() + (field.front() == '+' ? 1 : 0);
  const char* end = field.data() + field.size();
  const auto [last, fault] = std::from_chars(begin, end, value);
  return fault == std::errc{} && last == end ? field : "'" + field;
}

}  // namespace crowdbench::studies::text
