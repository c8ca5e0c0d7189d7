// Based on: C. Spearman, "The proof and measurement of association between two things", American Journal of Psychology
// 15 (1904); M. G. Kendall, "The treatment of ties in ranking problems", Biometrika 33 (1945), tau-b; W. R. Knight, "A
// computer method for calculating Kendall's tau with ungrouped data", JASA 61 (1966); B. Efron, "Bootstrap methods:
// another look at the jackknife", Annals of Statistics 7 (1979).
// Differs from the source: the bootstrap draws whole groups, by counters, not from a stream.
#include "core/rank_correlation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/random.h"

namespace crowdbench {
namespace {

constexpr uint64_t kRankPurpose = 0x72616e6b;
constexpr double kConfidence = 0.95;

// Pairs within runs of equal neighbours.
template <typename Equal>
double tied_pairs(size_t count, const Equal& equal) {
  double pairs = 0;
  for (size_t i = 0; i < count;) {
    size_t end = i + 1;
    while (end < count && equal(end - 1, end)) ++end;
    const auto run = static_cast<double>(end - i);
    pairs += run * (run - 1) / 2;
    i = end;
  }
  return pairs;
}

// Sorts and counts how many pairs stood in falling order.
double sort_counting_swaps(std::vector<double>& values) {
  std::vector<double> sorted(values.size());
  double swaps = 0;
  for (size_t width = 1; width < values.size(); width *= 2) {
    for (size_t low = 0; low < values.size(); low += 2 * width) {
      const size_t middle = std::min(low + width, values.size());
      const size_t high = std::min(low + 2 * width, values.size());
      size_t left = low;
      size_t right = middle;
      for (size_t k = low; k < high; ++k) {
        const bool from_right = left == middle || (right < high && values[right] < values[left]);
        if (from_right) swaps += static_cast<double>(middle - left);
        sorted[k] = from_right ? values[right++] : values[left++];
      }
    }
    std::swap(values, sorted);
  }
  return swaps;
}

// Percentiles, outwards to values that occur.
std::optional<RankCorrelation> with_interval(const std::optional<double>& value, std::vector<double> resampled) {
  if (!value || resampled.empty()) return std::nullopt;
  std::sort(resampled.begin(), resampled.end());
  const double last = static_cast<double>(resampled.size() - 1);
  const auto low = static_cast<size_t>(std::floor(last * 0.5 * (1 - kConfidence)));
  const auto high = static_cast<size_t>(std::ceil(last * 0.5 * (1 + kConfidence)));
  return RankCorrelation{*value, {resampled[low], resampled[high]}};
}

}  // namespace

std::vector<double> ranks_of(std::span<const double> values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (size_t i = 0; i < order.size();) {
    size_t end = i + 1;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (size_t k = i; k < end; ++k) ranks[order[k]] = 0.5 * static_cast<double>(i + end + 1);
    i = end;
  }
  return ranks;
}

std::optional<double> spearman(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  const std::vector<double> p = ranks_of(a);
  const std::vector<double> q = ranks_of(b);
  const double mean = 0.5 * static_cast<double>(a.size() + 1);
  double pp = 0;
  double qq = 0;
  double pq = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    pp += (p[i] - mean) * (p[i] - mean);
    qq += (q[i] - mean) * (q[i] - mean);
    pq += (p[i] - mean) * (q[i] - mean);
  }
  if (pp == 0 || qq == 0) return std::nullopt;
  return pq / std::sqrt(pp * qq);
}

std::optional<double> kendall_tau_b(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  std::vector<std::pair<double, double>> sorted(a.size());
  for (size_t i = 0; i < a.size(); ++i) sorted[i] = {a[i], b[i]};
  std::sort(sorted.begin(), sorted.end());
  const double tied_in_a =
      tied_pairs(sorted.size(), [&](size_t i, size_t j) { return sorted[i].first == sorted[j].first; });
  const double tied_in_both = tied_pairs(sorted.size(), [&](size_t i, size_t j) { return sorted[i] == sorted[j]; });
  std::vector<double> second(sorted.size());
  std::transform(sorted.begin(), sorted.end(), second.begin(), [](const auto& pair) { return pair.second; });
  const double opposite = sort_counting_swaps(second);
  const double tied_in_b = tied_pairs(second.size(), [&](size_t i, size_t j) { return second[i] == second[j]; });
  const auto count = static_cast<double>(sorted.size());
  const double all = count * (count - 1) / 2;
  if (tied_in_a == all || tied_in_b == all) return std::nullopt;
  const double same = all - tied_in_a - tied_in_b + tied_in_both - opposite;
  return (same - opposite) / std::sqrt((all - tied_in_a) * (all - tied_in_b));
}

RankAgreement rank_agreement(std::span<const double> a, std::span<const double> b, std::span<const uint32_t> groups,
                             uint64_t seed, size_t resamples) {
  assert(a.size() == b.size() && a.size() == groups.size());
  std::vector<uint32_t> names(groups.begin(), groups.end());
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::vector<std::vector<size_t>> members(names.size());
  for (size_t i = 0; i < groups.size(); ++i)
    members[static_cast<size_t>(std::lower_bound(names.begin(), names.end(), groups[i]) - names.begin())].push_back(i);
  std::vector<double> rhos;
  std::vector<double> taus;
  std::vector<double> drawn_a;
  std::vector<double> drawn_b;
  for (size_t r = 0; r < resamples && !members.empty(); ++r) {
    drawn_a.clear();
    drawn_b.clear();
    for (size_t i = 0; i < members.size(); ++i)
      for (const size_t m : members[random_below(seed, r * members.size() + i, kRankPurpose, members.size())]) {
        drawn_a.push_back(a[m]);
        drawn_b.push_back(b[m]);
      }
    if (const auto rho = spearman(drawn_a, drawn_b)) rhos.push_back(*rho);
    if (const auto tau = kendall_tau_b(drawn_a, drawn_b)) taus.push_back(*tau);
  }
  return {with_interval(spearman(a, b), std::move(rhos)), with_interval(kendall_tau_b(a, b), std::move(taus)), a.size(),
          members.size()};
}

}  // namespace crowdbench
