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

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Letters that are put in, left out, exchanged, or swapped with their neighbour (once), whatever their case: the
// "optimal string alignment" distance, F. Damerau, "A technique for computer detection and correction of spelling
// errors" (1964).
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<size_t>> rows(3, std::vector<size_t>(b.size() + 1));  // two before, the one before, this one
  std::iota(rows[2].begin(), rows[2].end(), size_t{0});
  const auto same = [&](size_t i, size_t j) { return lower(a[i]) == lower(b[j]); };
  for (size_t i = 1; i <= a.size(); ++i) {
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
    std::vector<size_t>& row = rows[2];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({rows[1][j] + 1, row[j - 1] + 1, rows[1][j - 1] + (same(i - 1, j - 1) ? 0 : 1)});
      if (i > 1 && j > 1 && same(i - 1, j - 2) && same(i - 2, j - 1)) row[j] = std::min(row[j], rows[0][j - 2] + 1);
    }
  }
  return rows[2][b.size()];
}

// How many of the text's first bytes are a character that shows nothing and changes how others are shown: control
// characters, and what turns the direction of writing or ends a line (Unicode's bidirectional controls, U+2028 and
// U+2029). 0: none.
size_t control_bytes(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  if (byte(0) < 0x20 || byte(0) == 0x7f) return 1;
  if (byte(0) == 0xc2 && byte(1) >= 0x80 && byte(1) < 0xa0) return 2;
  if (byte(0) == 0xd8 && byte(1) == 0x9c) return 2;  // U+061C
  if (byte(0) != 0xe2) return 0;
  const unsigned last = byte(2);
  const bool turns = (byte(1) == 0x80 && (last == 0x8e || last == 0x8f || (last >= 0xa8 && last <= 0xae))) ||
                     (byte(1) == 0x81 && last >= 0xa6 && last <= 0xa9);
  return turns ? 3 : 0;
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
  for (size_t i = 0; i < end;) {
    const size_t control = control_bytes(text.substr(i, end - i));
    out += control > 0 ? '?' : text[i];
    i += std::max<size_t>(control, 1);
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
