#include "core/short_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace crowdbench {
namespace {

std::optional<double> number_of(const std::string& text) {
  double number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

std::map<std::string, std::string> short_numbers(const std::set<std::string>& texts) {
  constexpr size_t kShort = 6;
  constexpr int kMostDigits = 17;  // tell any two doubles apart
  std::map<std::string, std::string> out;
  std::map<std::string, double> numbers;
  bool any_long = false;
  for (const std::string& text : texts) {
    out[text] = text;
    if (const auto number = number_of(text)) {
      numbers[text] = *number;
      any_long = any_long || text.size() > kShort;
    }
  }
  for (int digits = 3; any_long && digits <= kMostDigits; ++digits) {
    std::set<std::string> distinct;
    // A text that is short already stays as it was written.
    for (const auto& [text, number] : numbers)
      distinct.insert(out[text] = text.size() <= kShort ? text : fmt::format("{:.{}g}", number, digits));
    if (distinct.size() == numbers.size()) return out;
  }
  for (const auto& [text, number] : numbers) out[text] = text;  // one number, written as two texts
  return out;
}

}  // namespace crowdbench
