// Shares, exact tests, equivalence and signal detection: by hand, and against R, scipy and statsmodels.
#include "studies/analysis/proportions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/probability.h"
#include "studies/analysis/equivalence.h"
#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;

TEST(Distributions, AreInverseToEachOtherAndRightByHand) {
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);
  for (const double p : {1e-300, 1e-12, 0.01, 0.3, 0.5, 0.9, 1 - 1e-9})
    EXPECT_NEAR(normal_cdf(normal_quantile(p)) / p, 1, 1e-11) << p;
  for (const double x : {-29.9, -30.1})
    EXPECT_NEAR(log_normal_cdf(x) / std::log(std::erfc(-x / std::numbers::sqrt2) / 2), 1, 1e-10);
  EXPECT_NEAR(log_normal_cdf(-1e3), -5e5, 10);
  // One degree of freedom is Cauchy, two have a closed form.
  EXPECT_NEAR(student_t_cdf(1, 1), 0.75, 1e-13);
  EXPECT_NEAR(student_t_quantile(0.975, 2), 0.95 * std::sqrt(2 / (4 * 0.975 * 0.025)), 1e-12);
  EXPECT_NEAR(chi_squared_tail(3.841458820694124, 1), 0.05, 1e-13);
  EXPECT_NEAR(chi_squared_tail(5, 2), std::exp(-2.5), 1e-13);
  EXPECT_NEAR(chi_squared_tail(0.5, 2), std::exp(-0.25), 1e-13);
  EXPECT_NEAR(beta_cdf(0.3, 1, 3), 1 - std::pow(0.7, 3), 1e-14);
  EXPECT_NEAR(beta_quantile(0.5, 2, 2), 0.5, 1e-14);
  // Two coins.
  EXPECT_NEAR(binomial_at_most(1, 2, 0.5), 0.75, 1e-14);
  EXPECT_NEAR(binomial_at_least(1, 2, 0.5), 0.75, 1e-14);
  double sum = 0;
  for (const double p : binomial_probabilities(1000, 0.3)) sum += p;
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(Proportions, AreThoseOfR) {
  const Expected& expected = test::studies_expected();
  for (const Expected& c : expected.at("proportions")) {
    const auto k = c.at("k").get<uint64_t>();
    const auto n = c.at("n").get<uint64_t>();
    SCOPED_TRACE(std::to_string(k) + " of " + std::to_string(n));
    for (const auto& [name, confidence] : {std::pair("ci95", 0.95), std::pair("ci99", 0.99)}) {
      const Interval exact = clopper_pearson(k, n, confidence);
      const Interval score = wilson(k, n, confidence);
      EXPECT_NEAR(exact.low, c.at(name).at("clopper_pearson")[0].get<double>(), 1e-9);
      EXPECT_NEAR(exact.high, c.at(name).at("clopper_pearson")[1].get<double>(), 1e-9);
      EXPECT_NEAR(score.low, c.at(name).at("wilson")[0].get<double>(), 1e-9);
      EXPECT_NEAR(score.high, c.at(name).at("wilson")[1].get<double>(), 1e-9);
    }
    for (const Expected& t : c.at("binom_test")) {
      const BinomialTest p = binomial_test(k, n, t.at("p0").get<double>());
      EXPECT_NEAR(p.two_sided, t.at("two_sided").get<double>(), 1e-9);
      EXPECT_NEAR(p.greater, t.at("greater").get<double>(), 1e-9);
      EXPECT_NEAR(p.less, t.at("less").get<double>(), 1e-9);
      // And where they are tiny, as ratios.
      EXPECT_NEAR(p.two_sided / t.at("two_sided").get<double>(), 1, 1e-8);
    }
  }
  // The file's own are by numerical integration, and 3e-10 where they must be 0: its definition is what holds.
  for (const Expected& c : expected.at("dprime_2afc"))
    EXPECT_NEAR(d_prime_2afc(c.at("p").get<double>()), c.at("dprime").get<double>(), 5e-5);
  EXPECT_NEAR(d_prime_2afc(0.75), std::numbers::sqrt2 * 0.6744897501960817, 1e-14);
}

TEST(SignalDetection, ByHand) {
  // 84.13 % hits and 15.87 % false alarms are one standard deviation either side.
  const auto even = signal_detection(8413, 10000, 1587, 10000);
  ASSERT_TRUE(even);
  EXPECT_NEAR(even->d_prime, 2, 1e-3);
  EXPECT_NEAR(even->criterion, 0, 1e-12);
  EXPECT_FALSE(even->corrected);
  // Variance of z: p q / (n phi(z)^2), and both rates have the same.
  EXPECT_NEAR(even->d_prime_se, std::sqrt(2 * 0.8413 * 0.1587 / 1e4) / normal_density(1), 1e-4);
  const auto perfect = signal_detection(10, 10, 0, 10);
  ASSERT_TRUE(perfect);
  EXPECT_TRUE(perfect->corrected);
  EXPECT_NEAR(perfect->d_prime, 2 * normal_quantile(10.5 / 11), 1e-12);
  EXPECT_FALSE(signal_detection(3, 5, 0, 0));
}

TEST(Equivalence, IsThatOfRAndStatsmodels) {
  const Expected& expected = test::statistics_expected();
  for (const Expected& c : expected.at("equivalence").at("one_proportion_tost")) {
    SCOPED_TRACE(c.dump().substr(0, 60));
    const auto k = c.at("k").get<uint64_t>();
    const auto n = c.at("n").get<uint64_t>();
    const auto low = c.at("low").get<double>();
    const auto upp = c.at("upp").get<double>();
    for (const auto& [name, tost] :
         {std::pair("exact", tost_exact(k, n, low, upp)), std::pair("score", tost_score(k, n, low, upp)),
          std::pair("wald", tost_wald(k, n, low, upp))}) {
      if (!c.contains(name) || !c.at(name).contains("p")) continue;
      EXPECT_NEAR(tost.p, c.at(name).at("p").get<double>(), 1e-9) << name;
      EXPECT_NEAR(tost.p_low, c.at(name).at("p_low").get<double>(), 1e-9) << name;
      EXPECT_NEAR(tost.p_upp, c.at(name).at("p_upp").get<double>(), 1e-9) << name;
    }
    EXPECT_EQ(tost_exact(k, n, low, upp).p <= 0.05, c.at("equivalent_at_05").at("exact").get<bool>());
    const Interval ninety = clopper_pearson(k, n, 0.9);
    EXPECT_EQ(ninety.low > low && ninety.high < upp, c.at("equivalent_at_05").at("exact").get<bool>());
  }
  for (const Expected& c : expected.at("equivalence").at("power_table"))
    EXPECT_NEAR(tost_power(c.at("n").get<uint64_t>(), c.at("low").get<double>(), c.at("upp").get<double>(),
                           c.at("p_true").get<double>(), c.at("alpha").get<double>()),
                c.at("power_exact").get<double>(), 1e-9)
        << c.dump();
}

TEST(Equivalence, SampleSizesAreExact) {
  const Expected& expected = test::statistics_expected();
  for (const Expected& c : expected.at("equivalence").at("sample_size_one_proportion_exact")) {
    if (c.at("searched_to").get<uint64_t>() > 700) continue;  // the search takes the square of it
    for (const auto& [power, name] : {std::pair(0.8, "80"), std::pair(0.9, "90")}) {
      const SampleSize n =
          tost_sample_size(c.at("low").get<double>(), c.at("upp").get<double>(), c.at("p_true").get<double>(),
                           c.at("alpha").get<double>(), power, c.at("searched_to").get<uint64_t>());
      const Expected& first = c.at(std::string("first_n_") + name);
      const Expected& always = c.at(std::string("n_from_which_always_") + name);
      EXPECT_EQ(n.first, first.is_null() ? std::nullopt : std::optional(first.get<uint64_t>())) << c.dump();
      EXPECT_EQ(n.always, always.is_null() ? std::nullopt : std::optional(always.get<uint64_t>())) << c.dump();
    }
  }
}

TEST(Equivalence, VerdictNeedsTrialsAndParticipants) {
  // 24 participants of 40 trials, all near one half.
  std::vector<Share> even;
  for (uint64_t i = 0; i < 24; ++i) even.push_back({18 + i % 5, 40});
  const Equivalence same = judge_equivalence(even, {.margin = 0.1});
  EXPECT_EQ(same.verdict, Verdict::equivalent);
  EXPECT_EQ(same.trials_needed, 227U) << "from which on always, in statistics.README.md";
  EXPECT_EQ(same.more_trials, 0U);
  ASSERT_TRUE(same.interval);
  EXPECT_GT(same.interval->low, 0.4);
  EXPECT_LT(same.interval->high, 0.6);
  // As many trials and the same mean, but half of the participants always choose one side: trials alone would say
  // equal.
  std::vector<Share> apart;
  for (uint64_t i = 0; i < 24; ++i) apart.push_back({i % 2 == 0 ? 40U : 0U, 40});
  const Equivalence split = judge_equivalence(apart, {.margin = 0.1});
  EXPECT_LT(split.exact.p, 0.01);
  EXPECT_EQ(split.verdict, Verdict::not_enough_data);
  EXPECT_EQ(split.more_trials, 0U);
  EXPECT_GT(split.more_participants, 150U);
  // Seen by all.
  std::vector<Share> seen(24, Share{36, 40});
  seen[0].chosen = 35;
  EXPECT_EQ(judge_equivalence(seen, {.margin = 0.1}).verdict, Verdict::different);
  // One participant, few trials.
  const std::vector<Share> one = {{10, 20}};
  const Equivalence few = judge_equivalence(one, {.margin = 0.1});
  EXPECT_EQ(few.verdict, Verdict::not_enough_data);
  EXPECT_EQ(few.more_trials, 207U);
  EXPECT_FALSE(few.by_participant);
  // All shares equal: t has no doubt left, the trials have.
  const std::vector<Share> equal(3, Share{2, 4});
  EXPECT_EQ(judge_equivalence(equal, {.margin = 0.1}).verdict, Verdict::not_enough_data);
  EXPECT_EQ(verdict_text(Verdict::not_enough_data), "not enough data");
}

}  // namespace
}  // namespace crowdbench::studies
