// Rank tests, the estimates that belong to them, and the distributions that they are read from: by hand, and against R,
// SciPy, coin and exactRankTests (shared ground truth).
#include "core/rank_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/hodges_lehmann.h"
#include "core/probability.h"
#include "tests/core/statistics_cases.h"

namespace crowdbench {
namespace {

using Numbers = std::vector<double>;
using Case = nlohmann::json;

TEST(Probability, KnownPlaces) {
  EXPECT_NEAR(normal_cdf(1.959963984540054), 0.975, 1e-15);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);
  EXPECT_NEAR(normal_quantile(1e-9), -normal_quantile(1 - 1e-9), 1e-6);
  // Cauchy: t with one degree of freedom is beyond 1 half of the time. Two: P(|T| >= t) = 1 - t / sqrt(2 + t^2).
  EXPECT_NEAR(student_t_two_sided(1, 1), 0.5, 1e-14);
  EXPECT_NEAR(student_t_two_sided(-3, 2), 1 - 3 / std::sqrt(11.0), 1e-14);
  EXPECT_EQ(student_t_two_sided(INFINITY, 3), 0);
  EXPECT_NEAR(student_t_quantile(0.975, 10), 2.2281388519649385, 1e-10);
  EXPECT_NEAR(beta_cdf(0.25, 2, 3), 6 * 0.0625 - 8 * 0.015625 + 3 * 0.00390625, 1e-14);
}

// Binomial(4, 1/2): 1, 4, 6, 4, 1 sixteenths. One sixteenth is more than 2.5 % and less than 10 %.
TEST(Probability, BinomialLimits) {
  EXPECT_EQ(binomial_limits(4, 0.5, 0.95).low, 0U);
  EXPECT_EQ(binomial_limits(4, 0.5, 0.95).high, 4U);
  EXPECT_EQ(binomial_limits(4, 0.5, 0.80).low, 1U);
  EXPECT_EQ(binomial_limits(4, 0.5, 0.80).high, 3U);
  // R: qbinom(c(.025, .975), 1000, .05).
  EXPECT_EQ(binomial_limits(1000, 0.05).low, 37U);
  EXPECT_EQ(binomial_limits(1000, 0.05).high, 64U);
}

// x = {1, 2} among {1, 2, 3}: U of x is 0, one of the three equally likely places.
TEST(RankTests, MannWhitneyByHand) {
  const RankTest test = mann_whitney(Numbers{1, 2}, Numbers{3});
  EXPECT_EQ(test.statistic, 0);
  EXPECT_NEAR(test.p_less, 1.0 / 3, 1e-15);
  EXPECT_NEAR(test.p_greater, 1, 1e-15);
  EXPECT_NEAR(test.p_two_sided, 2.0 / 3, 1e-15);
  EXPECT_TRUE(test.exact);
  // x = {1, 2}, y = {2}: ranks 1, 2.5, 2.5. y has 2.5 in two of three assignments.
  const RankTest tied = mann_whitney(Numbers{1, 2}, Numbers{2});
  EXPECT_EQ(tied.statistic, 0.5);
  EXPECT_NEAR(tied.p_less, 2.0 / 3, 1e-15);
}

// Differences 1, -2, 3: V = 1 + 3 = 4 of {0, 1, 2, 3, 3, 4, 5, 6}.
TEST(RankTests, SignedRankByHand) {
  const RankTest test = wilcoxon_signed_rank(Numbers{1, -2, 3});
  EXPECT_EQ(test.statistic, 4);
  EXPECT_NEAR(test.p_greater, 3.0 / 8, 1e-15);
  EXPECT_NEAR(test.p_less, 6.0 / 8, 1e-15);
  // With a 0 the ranks are 2, 3 and 4 under Pratt's rule: V = 2 + 4.
  EXPECT_EQ(wilcoxon_signed_rank(Numbers{1, -2, 3, 0}, ZeroRule::pratt).statistic, 6);
  EXPECT_EQ(wilcoxon_signed_rank(Numbers{1, -2, 3, 0}, ZeroRule::drop).statistic, 4);
}

TEST(RankTests, DegenerateSamplesSaySo) {
  const RankTest equal = mann_whitney(Numbers{2, 2, 2}, Numbers{2, 2});
  EXPECT_TRUE(equal.degenerate);
  EXPECT_EQ(equal.p_two_sided, 1);
  EXPECT_TRUE(wilcoxon_signed_rank(Numbers{0, 0}).degenerate);
  EXPECT_TRUE(wilcoxon_signed_rank(Numbers{0, 0}, ZeroRule::pratt).degenerate);
  EXPECT_FALSE(brunner_munzel(Numbers{1, 2, 3}, Numbers{4, 5, 6})) << "no overlap, no variance";
  EXPECT_FALSE(brunner_munzel(Numbers{1}, Numbers{4, 5, 6}));
}

// A key of one or of several objects; nothing where it is absent or not a number.
void expect_as_said(const Case& in, const std::string& key, double got, double tolerance, const std::string& what,
                    int& compared) {
  if (!in.contains(key) || !in.at(key).is_number()) return;
  EXPECT_NEAR(got, in.at(key).get<double>(), tolerance) << what << ' ' << key;
  ++compared;
}

void expect_two_sample(const std::string& name, const Case& one, int& compared) {
  const auto x = one.at("x").get<Numbers>();
  const auto y = one.at("y").get<Numbers>();
  expect_as_said(one, "U_x", mann_whitney(x, y).statistic, 1e-9, name, compared);
  const Case& normal = one.at("mannwhitney");
  expect_as_said(normal, "normal_cc", mann_whitney(x, y, RankLaw::normal_continuity).p_two_sided, 1e-9, name, compared);
  expect_as_said(normal, "normal_no_cc", mann_whitney(x, y, RankLaw::normal).p_two_sided, 1e-9, name, compared);
  const RankTest exact = mann_whitney(x, y, RankLaw::exact);
  expect_as_said(normal, "exact", exact.p_two_sided, 1e-9, name, compared);
  if (one.contains("exact_permutation")) {
    const Case& law = one.at("exact_permutation");
    expect_as_said(law, "p_less", exact.p_less, 1e-9, name, compared);
    expect_as_said(law, "p_greater", exact.p_greater, 1e-9, name, compared);
    expect_as_said(law, "p_two_sided_doubled", exact.p_two_sided, 1e-9, name, compared);
  }
  const Shift shift = hodges_lehmann(x, y);
  expect_as_said(one, "hodges_lehmann_x_minus_y", shift.estimate, 1e-9, name, compared);
  if (one.contains("hodges_lehmann_ci95_exact_own")) {
    const Case& interval = one.at("hodges_lehmann_ci95_exact_own");
    EXPECT_NEAR(shift.interval.low, interval.at("ci").at(0).get<double>(), 1e-9) << name;
    EXPECT_NEAR(shift.interval.high, interval.at("ci").at(1).get<double>(), 1e-9) << name;
    expect_as_said(interval, "achieved", shift.achieved, 1e-9, name, compared);
  }
  if (!one.contains("brunner_munzel")) return;
  const Case& own = one.at("brunner_munzel").at("own");
  const auto test = brunner_munzel(x, y);
  EXPECT_EQ(test.has_value(), !own.contains("error")) << name;
  if (!test) return;
  expect_as_said(own, "statistic", test->statistic, 1e-9, name, compared);
  expect_as_said(own, "df", test->df, 1e-8, name, compared);
  expect_as_said(own, "p_t", test->p_two_sided, 1e-9, name, compared);
  expect_as_said(own, "p_x_lt_y_plus_half", test->probability, 1e-9, name, compared);
}

TEST(RankTests, TwoSamplesAreThoseOfTheSharedGroundTruth) {
  const Case* all = test::statistics_cases();
  if (all == nullptr) GTEST_SKIP() << "needs the shared ground-truth folder";
  int compared = 0;
  for (const auto& [name, one] : all->at("two_sample").items())
    if (one.is_object() && one.contains("x")) expect_two_sample(name, one, compared);
  EXPECT_GT(compared, 120) << "the walk found the cases";
}

void expect_paired(const std::string& name, const Case& one, int& compared) {
  const auto differences = one.at("differences_rounded_1e-10").get<Numbers>();
  const auto p_of = [&](ZeroRule zeros, RankLaw law) { return wilcoxon_signed_rank(differences, zeros, law); };
  for (const auto& [zeros, rule] : {std::pair{ZeroRule::drop, "wilcox"}, std::pair{ZeroRule::pratt, "pratt"}})
    for (const auto& [law, suffix] :
         {std::pair{RankLaw::normal_continuity, "_cc"}, std::pair{RankLaw::normal, "_no_cc"}})
      expect_as_said(one.at("scipy").at(std::string(rule) + suffix), "p", p_of(zeros, law).p_two_sided, 1e-9,
                     name + " " + rule + suffix, compared);
  for (const auto& [zeros, key] : {std::pair{ZeroRule::drop, "exact_permutation_zeros_dropped"},
                                   std::pair{ZeroRule::pratt, "exact_permutation_pratt"}}) {
    if (!one.contains(key)) continue;
    const RankTest exact = p_of(zeros, RankLaw::exact);
    expect_as_said(one.at(key), "V", exact.statistic, 1e-9, name + " " + key, compared);
    expect_as_said(one.at(key), "p_less", exact.p_less, 1e-9, name + " " + key, compared);
    expect_as_said(one.at(key), "p_greater", exact.p_greater, 1e-9, name + " " + key, compared);
    expect_as_said(one.at(key), "p_two_sided", exact.p_two_sided, 1e-9, name + " " + key, compared);
  }
  const Shift shift = hodges_lehmann(differences);
  expect_as_said(one, "hodges_lehmann_median_of_walsh_averages", shift.estimate, 1e-9, name, compared);
  if (!one.at("R").contains("exact")) return;
  const Case& exact = one.at("R").at("exact");
  EXPECT_NEAR(shift.interval.low, exact.at("ci95").at(0).get<double>(), 1e-9) << name;
  EXPECT_NEAR(shift.interval.high, exact.at("ci95").at(1).get<double>(), 1e-9) << name;
}

TEST(RankTests, PairsAreThoseOfTheSharedGroundTruth) {
  const Case* all = test::statistics_cases();
  if (all == nullptr) GTEST_SKIP() << "needs the shared ground-truth folder";
  int compared = 0;
  for (const auto& [name, one] : all->at("paired").items())
    if (one.is_object() && one.contains("x")) expect_paired(name, one, compared);
  EXPECT_GT(compared, 50) << "the walk found the cases";
}

}  // namespace
}  // namespace crowdbench
