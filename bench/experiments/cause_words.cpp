#include "bench/experiments/cause_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "core/random.h"

namespace crowdbench::bench {
namespace {

using metrics::Cause;
using metrics::kCauses;

constexpr double kEdges[] = {0, 15, 30, 60, 120, 240, 480, std::numeric_limits<double>::infinity()};
constexpr uint64_t kPurpose = 0x63617573;
constexpr size_t kResamples = 1000;
constexpr double kConfidence = 0.95;

struct Sums {
  std::array<int64_t, kCauses> amounts{};
  int64_t residue = 0, total = 0;
  void add(const metrics::CauseRow& row) {
    for (size_t c = 0; c < kCauses; ++c) amounts[c] += row.amounts[c];
    residue += row.residue;
    total += row.total;
  }
  void add(const Sums& other) {
    for (size_t c = 0; c < kCauses; ++c) amounts[c] += other.amounts[c];
    residue += other.residue;
    total += other.total;
  }
};

// The place of the largest amount but for `except`; nothing where none is above 0.
std::optional<Cause> largest(const Sums& sums, std::optional<Cause> except = {}) {
  std::optional<Cause> out;
  for (size_t c = 0; c < kCauses; ++c)
    if (sums.amounts[c] > 0 && static_cast<Cause>(c) != except &&
        (!out || sums.amounts[c] > sums.amounts[static_cast<size_t>(*out)]))
      out = static_cast<Cause>(c);
  return out;
}

double share_of(const Sums& sums, Cause cause) {
  return static_cast<double>(sums.amounts[static_cast<size_t>(cause)]) / static_cast<double>(sums.total);
}

// Whether the first cause stays the first over sets of units drawn anew, and the interval of its share.
void draw_anew(const std::vector<Sums>& units, uint64_t seed, CauseRange& range) {
  std::vector<double> shares;
  size_t kept = 0;
  for (size_t r = 0; r < kResamples; ++r) {
    Sums sums;
    for (size_t i = 0; i < units.size(); ++i)
      sums.add(units[random_below(seed, r * units.size() + i, kPurpose, units.size())]);
    kept += largest(sums) == range.first ? 1 : 0;
    if (sums.total > 0) shares.push_back(share_of(sums, *range.first));
  }
  if (static_cast<double>(kept) < kConfidence * kResamples) return;
  range.dominant = range.first;
  range.share = {quantile(shares, (1 - kConfidence) / 2), quantile(shares, (1 + kConfidence) / 2)};
}

// Nothing where no figure is of such a height.
std::optional<CauseRange> range_of(std::span<const CauseUnit> units, double from, double below, uint64_t seed) {
  std::map<uint64_t, Sums> by_unit;
  CauseRange range{.from = from, .below = below, .least = below, .most = from};
  Sums whole;
  for (const CauseUnit& one : units) {
    if (one.height_px < from || !(one.height_px < below)) continue;
    by_unit[one.unit].add(one.row);
    whole.add(one.row);
    range.least = std::min(range.least, one.height_px);
    range.most = std::max(range.most, one.height_px);
  }
  if (by_unit.empty()) return std::nullopt;
  range.units = by_unit.size();
  range.total = whole.total;
  if (whole.total == 0) return range;
  for (size_t c = 0; c < kCauses; ++c) range.shares[c] = share_of(whole, static_cast<Cause>(c));
  range.residue = static_cast<double>(whole.residue) / static_cast<double>(whole.total);
  range.first = largest(whole);
  range.second = largest(whole, range.first);
  if (!range.first || range.units < kLeastCauseUnits) return range;
  std::vector<Sums> sums;
  for (const auto& [unit, of] : by_unit) sums.push_back(of);
  draw_anew(sums, seed, range);
  return range;
}

std::string height_text(std::span<const CauseRange> ranges, size_t i) {
  const CauseRange& range = ranges[i];
  if (ranges.size() == 1)
    return range.least == range.most ? fmt::format("at {:.3g} pixels", range.least)
                                     : fmt::format("at {:.3g} to {:.3g} pixels", range.least, range.most);
  if (i == 0) return fmt::format("below {:g} pixels", range.below);
  if (i + 1 == ranges.size()) return fmt::format("from {:g} pixels on", range.from);
  return fmt::format("{:g} to {:g} pixels", range.from, range.below);
}

std::string verdict_text(const CauseRange& range, const std::string& unit) {
  if (range.total == 0) return "no error";
  if (range.dominant)
    return fmt::format("{} ({:.0f} % of the squared error, 95 % interval {:.0f} to {:.0f} %, {} {}s)",
                       metrics::doc_of(*range.dominant).title, 100 * range.shares[static_cast<size_t>(*range.dominant)],
                       100 * range.share.low, 100 * range.share.high, range.units, unit);
  std::string text = "not distinguishable";
  if (range.units < kLeastCauseUnits)
    text += fmt::format(" with {} {}{}", range.units, unit, range.units == 1 ? "" : "s");
  if (range.first) text += fmt::format(" (most: {}", metrics::doc_of(*range.first).title);
  if (range.first && range.second) text += fmt::format(", then {}", metrics::doc_of(*range.second).title);
  return range.first ? text + ")" : text;
}

}  // namespace

std::vector<CauseRange> causes_by_height(std::span<const CauseUnit> units, uint64_t seed) {
  std::vector<CauseRange> out;
  for (size_t i = 0; i + 1 < std::size(kEdges); ++i) {
    std::optional<CauseRange> range = range_of(units, kEdges[i], kEdges[i + 1], seed);
    if (!range) continue;
    if (!out.empty() && out.back().dominant && out.back().dominant == range->dominant) {
      // Both are dominated by it, but whether what they are together is, is asked anew.
      std::optional<CauseRange> together = range_of(units, out.back().from, range->below, seed);
      if (together && together->dominant == range->dominant) {
        out.back() = *together;
        continue;
      }
    }
    out.push_back(*range);
  }
  return out;
}

std::string cause_range_words(std::span<const CauseRange> ranges, size_t i, const std::string& unit) {
  return fmt::format("{}: {}", height_text(ranges, i), verdict_text(ranges[i], unit));
}

std::string cause_words(std::span<const CauseRange> ranges, const std::string& unit) {
  std::string text;
  for (size_t i = 0; i < ranges.size(); ++i) text += (i == 0 ? "" : "; ") + cause_range_words(ranges, i, unit);
  return text;
}

}  // namespace crowdbench::bench
