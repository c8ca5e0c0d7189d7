#include "core/error.h"

#include <algorithm>
#include <numeric>

namespace crowdbench {
namespace {

std::string one_line(const std::string& where, const std::string& wrong, const std::string& advice) {
  std::string line = where.empty() ? wrong : where + ": " + wrong;
  if (!advice.empty()) line += "; " + advice;
  return printable(line, line.size());
}

size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substitute = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitute});
    }
  }
  return row[b.size()];
}

}  // namespace

Error::Error(std::string where_, std::string wrong_, std::string advice_)
    : std::runtime_error(one_line(where_, wrong_, advice_)),
      where(std::move(where_)),
      wrong(std::move(wrong_)),
      advice(std::move(advice_)) {}

std::string printable(std::string_view text, size_t limit) {
  size_t end = std::min(limit, text.size());
  // Not within a character of several bytes.
  if (end < text.size())
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80U) --end;
  std::string out;
  for (const char c : text.substr(0, end)) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  if (end < text.size()) out += "...";
  return out;
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  std::string best;
  size_t best_distance = std::max<size_t>(2, name.size() / 3) + 1;
  if (name.size() > 64) return best;
  for (const std::string& candidate : candidates) {
    const size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string nearest_first(std::string_view name, const std::vector<std::string>& candidates, size_t most) {
  std::vector<size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (candidates.size() > most && name.size() <= 64) {
    std::vector<size_t> distances;
    distances.reserve(candidates.size());
    for (const std::string& candidate : candidates)
      distances.push_back(edit_distance(name, std::string_view(candidate).substr(0, 64)));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return distances[a] < distances[b]; });
  }
  std::string out;
  for (size_t i = 0; i < std::min(most, order.size()); ++i)
    out += (i > 0 ? ", " : "") + printable(candidates[order[i]], 60);
  if (order.size() > most) out += fmt::format(" and {} more", order.size() - most);
  return out;
}

}  // namespace crowdbench
