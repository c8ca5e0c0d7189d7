// Based on: S. Holm, "A simple sequentially rejective multiple test procedure", Scandinavian Journal of Statistics 6
// (1979); Y. Benjamini and Y. Hochberg, "Controlling the false discovery rate: a practical and powerful approach to
// multiple testing", Journal of the Royal Statistical Society B 57 (1995).
// Differs from the sources: both are stated there as steps at a given level; here as adjusted p values, which say the
// same for every level.
#include "core/multiple_tests.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <numeric>

namespace crowdbench {
namespace {

// The places of p by ascending value; equal ones in the order given.
std::vector<size_t> ascending(std::span<const double> p) {
  std::vector<size_t> order(p.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return p[a] < p[b]; });
  return order;
}

}  // namespace

// Step down: the k-th smallest of n, times n - k + 1, never below the one before.
std::vector<double> holm(std::span<const double> p) {
  const std::vector<size_t> order = ascending(p);
  std::vector<double> adjusted(p.size());
  double least = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    assert(p[order[k]] >= 0 && p[order[k]] <= 1);
    least = std::max(least, std::min(1.0, p[order[k]] * static_cast<double>(p.size() - k)));
    adjusted[order[k]] = least;
  }
  return adjusted;
}

// Step up: the k-th smallest of n, times n / k, never above the one after.
std::vector<double> benjamini_hochberg(std::span<const double> p) {
  const std::vector<size_t> order = ascending(p);
  std::vector<double> adjusted(p.size());
  double most = 1;
  for (size_t k = order.size(); k-- > 0;) {
    assert(p[order[k]] >= 0 && p[order[k]] <= 1);
    most = std::min(most, p[order[k]] * (static_cast<double>(p.size()) / static_cast<double>(k + 1)));
    adjusted[order[k]] = most;
  }
  return adjusted;
}

std::vector<double> adjusted_p_values(std::span<const double> p, Correction correction) {
  switch (correction) {
    case Correction::holm: return holm(p);
    case Correction::benjamini_hochberg: return benjamini_hochberg(p);
    case Correction::none: break;
  }
  return {p.begin(), p.end()};
}

}  // namespace crowdbench
