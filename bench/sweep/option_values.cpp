#include "bench/sweep/option_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace crowdbench::bench::sweep {
namespace {

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

struct Alternative {
  std::string_view word;  // or, where it is empty, a range
  double low = 0, high = 0;
};
// Nothing where it is neither a word in small letters nor a range of numbers.
std::optional<Alternative> alternative_of(std::string_view text) {
  if (const size_t dots = text.find(".."); dots != std::string_view::npos) {
    const auto low = number_of(text.substr(0, dots));
    const auto high = number_of(text.substr(dots + 2));
    return low && high ? std::optional(Alternative{{}, *low, *high}) : std::nullopt;
  }
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  };
  if (text.empty() || !std::all_of(text.begin(), text.end(), plain)) return std::nullopt;
  return Alternative{text};
}

bool takes(const renderers::OptionDoc& doc, const std::string& value) {
  std::string_view rest = doc.values;
  const std::optional<double> number = number_of(value);
  while (true) {
    const size_t bar = rest.find('|');
    const auto one = alternative_of(rest.substr(0, bar));
    if (!one) return true;
    if (one->word.empty() ? number && *number >= one->low && *number <= one->high : value == one->word) return true;
    if (bar == std::string_view::npos) return false;
    rest.remove_prefix(bar + 1);
  }
}

}  // namespace

std::string wrong_option_value(const renderers::Spec& spec) {
  for (const auto& [key, value] : spec.options)
    for (const renderers::OptionDoc& doc : renderers::option_docs(renderers::representation_type(spec.name)))
      if (doc.key == key && value != doc.default_value && !takes(doc, value))
        return fmt::format("option {}={} of {} is not one of {}", key, printable(value, 60), spec.name, doc.values);
  for (const renderers::Spec& component : spec.components)
    if (std::string wrong = wrong_option_value(component); !wrong.empty()) return wrong;
  return {};
}

}  // namespace crowdbench::bench::sweep
