// Based on: H. B. Mann and D. R. Whitney, "On a test of whether one of two random variables is stochastically larger
// than the other", Annals of Mathematical Statistics 18 (1947); F. Wilcoxon, "Individual comparisons by ranking
// methods", Biometrics Bulletin 1 (1945); J. W. Pratt, "Remarks on zeros and ties in the Wilcoxon signed rank
// procedures", Journal of the American Statistical Association 54 (1959); E. Brunner and U. Munzel, "The nonparametric
// Behrens-Fisher problem", Biometrical Journal 42 (2000).
// Differs from the sources: exact p values are of the midranks at hand, ties included, counted by adding one rank after
// the other to all sums so far.
#include "core/rank_tests.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/probability.h"
#include "core/rank_correlation.h"

namespace crowdbench {
namespace {

// Additions that an exact law may take under RankLaw::automatic.
constexpr double kExactWork = 2e7;

// Midranks are halves at most: twice the ranks are whole numbers.
std::vector<uint32_t> doubled(std::span<const double> ranks) {
  std::vector<uint32_t> whole(ranks.size());
  for (size_t i = 0; i < ranks.size(); ++i) whole[i] = static_cast<uint32_t>(std::lround(2 * ranks[i]));
  return whole;
}

struct Tails {
  double less = 0;
  double greater = 0;
};
// law[s]: how often the sum is s, in any unit.
Tails tails_of(std::span<const double> law, size_t observed) {
  Tails tails;
  double all = 0;
  for (size_t s = 0; s < law.size(); ++s) {
    all += law[s];
    if (s <= observed) tails.less += law[s];
    if (s >= observed) tails.greater += law[s];
  }
  return {std::min(1.0, tails.less / all), std::min(1.0, tails.greater / all)};
}

// How many of the subsets of `size` ranks have each sum.
std::vector<double> law_of_subsets(std::span<const uint32_t> ranks, size_t size) {
  std::vector<uint32_t> sorted(ranks.begin(), ranks.end());
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  size_t most = 0;
  for (size_t i = 0; i < size; ++i) most += sorted[i];
  std::vector<std::vector<double>> counts(size + 1, std::vector<double>(most + 1, 0));
  counts[0][0] = 1;
  size_t reached = 0;
  for (size_t i = 0; i < ranks.size(); ++i) {
    reached = std::min(most, reached + ranks[i]);
    for (size_t k = std::min(size, i + 1); k > 0; --k)
      for (size_t s = ranks[i]; s <= reached; ++s) counts[k][s] += counts[k - 1][s - ranks[i]];
  }
  return std::move(counts[size]);
}

// How likely each sum of the ranks with a positive sign is, where every sign is as likely as the other.
std::vector<double> law_of_signs(std::span<const uint32_t> ranks) {
  size_t most = 0;
  for (const uint32_t rank : ranks) most += rank;
  std::vector<double> law(most + 1, 0);
  law[0] = 1;
  size_t reached = 0;
  for (const uint32_t rank : ranks) {
    reached += rank;
    for (size_t s = reached; s > 0; --s) law[s] = 0.5 * (law[s] + (s >= rank ? law[s - rank] : 0));
    law[0] *= 0.5;
  }
  return law;
}

void put_two_sided(RankTest& test) { test.p_two_sided = std::min(1.0, 2 * std::min(test.p_less, test.p_greater)); }

// The normal approximation; step: of the continuity correction, 0 or 1/2. The two-sided correction moves towards the
// mean and not beyond it; the one-sided ones away from what they ask for.
void put_normal(RankTest& test, double mean, double deviation, double step) {
  const double off = test.statistic - mean;
  test.p_less = normal_cdf((off + step) / deviation);
  test.p_greater = normal_cdf(-(off - step) / deviation);
  put_two_sided(test);
}

bool exact_chosen(RankLaw law, double work) {
  return law == RankLaw::exact || (law == RankLaw::automatic && work <= kExactWork);
}

// Sum over groups of equal ranks of t^3 - t.
double tie_term(std::vector<double> ranks) {
  std::sort(ranks.begin(), ranks.end());
  double sum = 0;
  for (size_t i = 0; i < ranks.size();) {
    size_t end = i;
    while (end < ranks.size() && ranks[end] == ranks[i]) ++end;
    const auto t = static_cast<double>(end - i);
    sum += t * t * t - t;
    i = end;
  }
  return sum;
}

struct Placements {
  double mean_rank = 0;  // among all
  double variance = 0;   // of the ranks among all less those within, divided by n - 1
};
Placements placements(std::span<const double> among_all, std::span<const double> within) {
  const auto n = static_cast<double>(within.size());
  Placements out;
  double mean_within = 0;
  for (size_t i = 0; i < within.size(); ++i) {
    out.mean_rank += among_all[i] / n;
    mean_within += within[i] / n;
  }
  for (size_t i = 0; i < within.size(); ++i) {
    const double off = among_all[i] - within[i] - out.mean_rank + mean_within;
    out.variance += off * off / (n - 1);
  }
  return out;
}

std::vector<double> pooled(std::span<const double> x, std::span<const double> y) {
  std::vector<double> all(x.begin(), x.end());
  all.insert(all.end(), y.begin(), y.end());
  return all;
}

}  // namespace

RankTest mann_whitney(std::span<const double> x, std::span<const double> y, RankLaw law) {
  assert(!x.empty() && !y.empty());
  const std::vector<double> ranks = ranks_of(pooled(x, y));
  const auto m = static_cast<double>(x.size());
  const auto n = static_cast<double>(y.size());
  const double all = m + n;
  double rank_sum = 0;
  for (size_t i = 0; i < x.size(); ++i) rank_sum += ranks[i];
  RankTest test;
  test.statistic = rank_sum - m * (m + 1) / 2;
  test.informative = ranks.size();
  const double ties = tie_term(ranks);
  const double variance = m * n / 12 * (all + 1 - ties / (all * (all - 1)));
  if (!(variance > 1e-9)) {
    test.degenerate = true;
    return test;
  }
  // The smaller sample's sums are counted; those of the larger are what is left.
  const bool of_x = x.size() <= y.size();
  const double work = all * std::min(m, n) * all * (all + 1);
  if (!exact_chosen(law, work)) {
    put_normal(test, m * n / 2, std::sqrt(variance), law == RankLaw::normal ? 0 : 0.5);
    return test;
  }
  const std::vector<uint32_t> whole = doubled(ranks);
  size_t observed = 0;
  for (size_t i = 0; i < whole.size(); ++i)
    if ((i < x.size()) == of_x) observed += whole[i];
  const Tails tails = tails_of(law_of_subsets(whole, std::min(x.size(), y.size())), observed);
  test.exact = true;
  test.p_less = of_x ? tails.less : tails.greater;
  test.p_greater = of_x ? tails.greater : tails.less;
  put_two_sided(test);
  return test;
}

RankTest wilcoxon_signed_rank(std::span<const double> differences, ZeroRule zeros, RankLaw law) {
  assert(!differences.empty());
  std::vector<double> kept;
  std::vector<double> sizes;
  for (const double d : differences)
    if (d != 0 || zeros == ZeroRule::pratt) {
      kept.push_back(d);
      sizes.push_back(std::abs(d));
    }
  const std::vector<double> all_ranks = ranks_of(sizes);
  RankTest test;
  std::vector<double> ranks;  // of the differences that are not 0
  double sum = 0;
  double squares = 0;
  size_t observed = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    if (kept[i] == 0) continue;
    ranks.push_back(all_ranks[i]);
    sum += all_ranks[i];
    squares += all_ranks[i] * all_ranks[i];
    if (kept[i] > 0) {
      test.statistic += all_ranks[i];
      observed += static_cast<size_t>(std::lround(2 * all_ranks[i]));
    }
  }
  test.informative = ranks.size();
  if (ranks.empty()) {
    test.degenerate = true;
    return test;
  }
  if (!exact_chosen(law, static_cast<double>(ranks.size()) * 2 * sum)) {
    put_normal(test, sum / 2, std::sqrt(squares) / 2, law == RankLaw::normal ? 0 : 0.5);
    return test;
  }
  const Tails tails = tails_of(law_of_signs(doubled(ranks)), observed);
  test.exact = true;
  test.p_less = tails.less;
  test.p_greater = tails.greater;
  put_two_sided(test);
  return test;
}

std::optional<BrunnerMunzel> brunner_munzel(std::span<const double> x, std::span<const double> y) {
  if (x.size() < 2 || y.size() < 2) return std::nullopt;
  const std::vector<double> all = ranks_of(pooled(x, y));
  const auto split = static_cast<ptrdiff_t>(x.size());
  const std::span<const double> ranks(all);
  const Placements of_x = placements(ranks.first(x.size()), ranks_of(x));
  const Placements of_y = placements(ranks.subspan(static_cast<size_t>(split)), ranks_of(y));
  const auto m = static_cast<double>(x.size());
  const auto n = static_cast<double>(y.size());
  const double a = m * of_x.variance;
  const double b = n * of_y.variance;
  if (!(a + b > 1e-12)) return std::nullopt;
  BrunnerMunzel out;
  out.statistic = m * n * (of_y.mean_rank - of_x.mean_rank) / ((m + n) * std::sqrt(a + b));
  out.df = (a + b) * (a + b) / (a * a / (m - 1) + b * b / (n - 1));
  out.p_two_sided = student_t_two_sided(out.statistic, out.df);
  out.probability = (of_y.mean_rank - (n + 1) / 2) / m;
  return out;
}

}  // namespace crowdbench
