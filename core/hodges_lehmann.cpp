// Based on: J. L. Hodges and E. L. Lehmann, "Estimates of location based on rank tests", Annals of Mathematical
// Statistics 34 (1963). Differs from R's wilcox.test in its normal mode: the estimate is the median itself, not the
// root of a step function.
#include "core/hodges_lehmann.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "core/probability.h"

namespace crowdbench {
namespace {

// Additions that the exact law may take; beyond, the normal approximation differs by less than one place in order.
constexpr double kExactWork = 2e7;

// P(U = u) of Mann and Whitney's U without ties. The count for (i, j) is that for (i - 1, j), moved by j, plus that for
// (i, j - 1): whether the largest value is of the first sample or of the second.
std::vector<double> law_of_u(size_t m, size_t n) {
  std::vector<std::vector<double>> before(n + 1, std::vector<double>(m * n + 1, 0));
  for (auto& row : before) row[0] = 1;  // none of the first sample
  for (size_t i = 1; i <= m; ++i) {
    std::vector<std::vector<double>> now(n + 1, std::vector<double>(m * n + 1, 0));
    now[0][0] = 1;
    const double of_first = static_cast<double>(i);
    for (size_t j = 1; j <= n; ++j) {
      const double share = of_first / (of_first + static_cast<double>(j));
      for (size_t u = 0; u <= i * j; ++u)
        now[j][u] = share * (u >= j ? before[j][u - j] : 0) + (1 - share) * now[j - 1][u];
    }
    before = std::move(now);
  }
  return before[n];
}

// P(V = v) of Wilcoxon's V without ties.
std::vector<double> law_of_v(size_t n) {
  std::vector<double> law(n * (n + 1) / 2 + 1, 0);
  law[0] = 1;
  size_t reached = 0;
  for (size_t rank = 1; rank <= n; ++rank) {
    reached += rank;
    for (size_t v = reached + 1; v-- > 0;) law[v] = 0.5 * (law[v] + (v >= rank ? law[v - rank] : 0));
  }
  return law;
}

struct Place {
  size_t k = 1;  // the interval is from the k-th smallest to the k-th largest
  double achieved = 0;
};
// k: the smallest with P(<= k) of at least `tail`.
Place place_of(const std::vector<double>& law, double tail) {
  double below = law[0];
  double before = 0;
  size_t k = 0;
  while (below < tail) {
    before = below;
    below += law[++k];
  }
  if (k == 0) return {1, 1 - 2 * law[0]};
  return {k, 1 - 2 * before};
}

Place place_by_normal(double mean, double deviation, double tail) {
  const double k = std::max(1.0, std::floor(mean + deviation * normal_quantile(tail)));
  return {static_cast<size_t>(k), 1 - 2 * normal_cdf((k - 0.5 - mean) / deviation)};
}

Shift shift_of(std::vector<double> sorted, const Place& place) {
  std::sort(sorted.begin(), sorted.end());
  const size_t last = sorted.size() - 1;
  const size_t k = std::min(place.k - 1, last / 2);
  const double middle = 0.5 * (sorted[last / 2] + sorted[(last + 1) / 2]);
  return {middle, {sorted[k], sorted[last - k]}, place.achieved};
}

}  // namespace

Shift hodges_lehmann(std::span<const double> x, std::span<const double> y, double confidence) {
  assert(!x.empty() && !y.empty() && confidence > 0 && confidence < 1);
  std::vector<double> differences;
  differences.reserve(x.size() * y.size());
  for (const double a : x)
    for (const double b : y) differences.push_back(a - b);
  const auto m = static_cast<double>(x.size());
  const auto n = static_cast<double>(y.size());
  const double tail = 0.5 * (1 - confidence);
  const Place place = m * m * n * n <= kExactWork
                          ? place_of(law_of_u(std::min(x.size(), y.size()), std::max(x.size(), y.size())), tail)
                          : place_by_normal(m * n / 2, std::sqrt(m * n * (m + n + 1) / 12), tail);
  return shift_of(std::move(differences), place);
}

Shift hodges_lehmann(std::span<const double> differences, double confidence) {
  assert(!differences.empty() && confidence > 0 && confidence < 1);
  std::vector<double> averages;
  averages.reserve(differences.size() * (differences.size() + 1) / 2);
  for (size_t i = 0; i < differences.size(); ++i)
    for (size_t j = i; j < differences.size(); ++j) averages.push_back(0.5 * (differences[i] + differences[j]));
  const auto n = static_cast<double>(differences.size());
  const double tail = 0.5 * (1 - confidence);
  const Place place = n * n * n <= kExactWork
                          ? place_of(law_of_v(differences.size()), tail)
                          : place_by_normal(n * (n + 1) / 4, std::sqrt(n * (n + 1) * (2 * n + 1) / 24), tail);
  return shift_of(std::move(averages), place);
}

}  // namespace crowdbench
