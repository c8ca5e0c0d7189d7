// Worths and JOD: against psychotools, BradleyTerry2, Poisson regression and pwcmp, and where there is no one scale.
#include "studies/analysis/paired_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;
using Groups = std::vector<std::vector<uint32_t>>;

std::vector<Comparison> rows_of(const Expected& rows) {
  std::vector<Comparison> out;
  for (size_t i = 0; i < rows.at("i").size(); ++i) {
    Comparison c{.a = rows.at("i")[i].get<uint32_t>() - 1,
                 .b = rows.at("j")[i].get<uint32_t>() - 1,
                 .a_wins = rows.at("wi")[i].get<uint64_t>(),
                 .ties = rows.at("t")[i].get<uint64_t>(),
                 .b_wins = rows.at("wj")[i].get<uint64_t>()};
    if (rows.contains("first")) c.a_is_first = rows.at("first")[i].get<uint32_t>() - 1 == c.a;
    out.push_back(c);
  }
  return out;
}

// Tolerances are the file's: estimates 1e-5, standard errors 1e-4 of themselves, log-likelihood 1e-6.
void expect_worths(const Worths& got, const Expected& expected) {
  ASSERT_EQ(got.state, WorthState::fitted);
  EXPECT_NEAR(got.log_likelihood, expected.at("loglik").get<double>(), 1e-6);
  for (size_t i = 0; i < got.log_worth.size(); ++i) {
    EXPECT_NEAR(got.log_worth[i], expected.at("log_worth_sum_zero")[i].get<double>(), 1e-5);
    EXPECT_NEAR(got.se[i] / expected.at("se_sum_zero")[i].get<double>(), 1, 1e-4);
    EXPECT_NEAR(got.worth[i], expected.at("worth_sum_one")[i].get<double>(), 1e-5);
  }
  for (const Expected& d : expected.at("differences")) {
    const Difference got_difference = difference_of(got, d.at("i").get<size_t>() - 1, d.at("j").get<size_t>() - 1);
    EXPECT_NEAR(got_difference.value, d.at("diff").get<double>(), 1e-5);
    EXPECT_NEAR(got_difference.se / d.at("se").get<double>(), 1, 1e-4);
  }
  if (!expected.contains("log_nu")) return;
  EXPECT_NEAR(got.log_nu.value(), expected.at("log_nu").get<double>(), 1e-5);
  EXPECT_NEAR(got.log_nu_se.value() / expected.at("se_log_nu").get<double>(), 1, 1e-4);
}

TEST(Worths, WithTiesAreThoseOfPsychotools) {
  const Expected& expected = test::statistics_expected();
  const Expected& all = expected.at("bradley_terry_ties");
  for (const char* name : {"sim_crowd_4", "few_ties_3", "sim_davidson_6"}) {
    SCOPED_TRACE(name);
    const Expected& c = all.at(name);
    expect_worths(fit_worths(rows_of(c.at("rows")), c.at("labels").size(), false), c.at("psychotools"));
    // Ties left out.
    std::vector<Comparison> dropped = rows_of(c.at("rows"));
    for (Comparison& r : dropped) r.ties = 0;
    const Worths plain = fit_worths(dropped, c.at("labels").size(), false);
    EXPECT_FALSE(plain.log_nu);
    EXPECT_NEAR(plain.log_likelihood, c.at("ties_dropped_BT").at("loglik").get<double>(), 1e-6);
    EXPECT_NEAR(difference_of(plain, 0, c.at("labels").size() - 1).value,
                c.at("ties_dropped_BT").at("log_worth_ref_last_0")[0].get<double>(), 1e-5);
  }
  // No ties at all: the plain model, and no tie parameter.
  const Worths none = fit_worths(rows_of(all.at("zero_ties_3").at("rows")), 3, false);
  EXPECT_FALSE(none.log_nu);
  expect_worths(none, all.at("zero_ties_3").at("psychotools_plain"));
}

TEST(Worths, WithPositionAreThoseOfPoissonRegression) {
  const Expected& expected = test::statistics_expected();
  const Expected& c = expected.at("bradley_terry_ties").at("position_ties_3");
  const std::vector<Comparison> rows = rows_of(c.at("rows"));
  const Worths got = fit_worths(rows, 3, true);
  expect_worths(got, c.at("poisson_glm"));
  EXPECT_NEAR(got.position.value(), c.at("poisson_glm").at("position").get<double>(), 1e-5);
  EXPECT_NEAR(got.position_se.value() / c.at("poisson_glm").at("se_position").get<double>(), 1, 1e-4);
  EXPECT_NEAR(fit_worths(rows, 3, false).log_likelihood, c.at("without_position").at("loglik").get<double>(), 1e-6);

  if (!expected.at("bradley_terry_ties").contains("position_no_ties_baseball_home"))
    GTEST_SKIP() << "the rest needs the shared ground-truth folder";
  const Expected& home = expected.at("bradley_terry_ties").at("position_no_ties_baseball_home");
  std::vector<Comparison> games;
  for (size_t i = 0; i < home.at("home").size(); ++i)
    games.push_back({.a = home.at("home")[i].get<uint32_t>() - 1,
                     .b = home.at("away")[i].get<uint32_t>() - 1,
                     .a_is_first = true,
                     .a_wins = home.at("home_wins")[i].get<uint64_t>(),
                     .b_wins = home.at("away_wins")[i].get<uint64_t>()});
  const Worths teams = fit_worths(games, 7, true);
  ASSERT_EQ(teams.state, WorthState::fitted);
  for (size_t i = 1; i < 7; ++i) {
    EXPECT_NEAR(difference_of(teams, i, 0).value, home.at("BradleyTerry2").at("coef")[i - 1].get<double>(), 1e-5);
    EXPECT_NEAR(difference_of(teams, i, 0).se / home.at("BradleyTerry2").at("se")[i - 1].get<double>(), 1, 1e-4);
  }
  EXPECT_NEAR(teams.position.value(), home.at("BradleyTerry2").at("coef")[6].get<double>(), 1e-5);
}

TEST(Worths, WithoutTiesAreThoseOfBradleyTerry2) {
  const Expected& expected = test::studies_expected();
  for (const auto& [name, c] : expected.at("paired_comparison").items()) {
    SCOPED_TRACE(name);
    std::map<std::string, uint32_t> index;
    const auto of = [&](const Expected& item) {
      return index.emplace(item.get<std::string>(), static_cast<uint32_t>(index.size())).first->second;
    };
    std::vector<Comparison> rows;
    for (const Expected& r : c.at("table")) {
      const uint32_t a = of(r.at("p1"));
      const uint32_t b = of(r.at("p2"));
      rows.push_back({.a = a, .b = b, .a_wins = r.at("win1").get<uint64_t>(), .b_wins = r.at("win2").get<uint64_t>()});
    }
    const Worths got = fit_worths(rows, index.size(), false);
    ASSERT_EQ(got.state, WorthState::fitted);
    const size_t reference = index.at(c.at("reference").get<std::string>());
    for (const auto& [item, i] : index) {
      EXPECT_NEAR(got.log_worth[i], c.at("logit").at("ability_sum_zero").at(item).get<double>(), 1e-5) << item;
      EXPECT_NEAR(difference_of(got, i, reference).se, c.at("logit").at("se").at(item).get<double>(), 1e-4) << item;
      EXPECT_NEAR(got.worth[i], c.at("logit").at("strength_sum_one").at(item).get<double>(), 1e-5) << item;
    }
    // The probit row, in units of 1.4826.
    Wins wins(index.size(), std::vector<double>(index.size(), 0));
    for (const Comparison& r : rows) {
      wins[r.a][r.b] += static_cast<double>(r.a_wins);
      wins[r.b][r.a] += static_cast<double>(r.b_wins);
    }
    const Jod jod = fit_jod(wins, JodPrior::none);
    ASSERT_EQ(jod.state, WorthState::fitted);
    for (const auto& [item, i] : index)
      EXPECT_NEAR(jod.q[i] / 1.4826, c.at("probit").at("ability_sum_zero").at(item).get<double>(), 1e-5) << item;
  }
}

TEST(Worths, AreRefusedWhereThereIsNoOneScale) {
  const std::vector<Comparison> apart = {{.a = 0, .b = 1, .a_wins = 11, .ties = 4, .b_wins = 5},
                                         {.a = 2, .b = 3, .a_wins = 6, .ties = 3, .b_wins = 11}};
  const Worths disconnected = fit_worths(apart, 4, false);
  EXPECT_EQ(disconnected.state, WorthState::disconnected);
  EXPECT_EQ(disconnected.groups, (Groups{{0, 1}, {2, 3}}));
  EXPECT_TRUE(disconnected.log_worth.empty());
  const std::vector<Comparison> unbeaten = {{.a = 0, .b = 1, .a_wins = 10},
                                            {.a = 0, .b = 2, .a_wins = 10},
                                            {.a = 1, .b = 2, .a_wins = 6, .ties = 1, .b_wins = 3}};
  const Worths infinite = fit_worths(unbeaten, 3, false);
  EXPECT_EQ(infinite.state, WorthState::unbeaten);
  EXPECT_EQ(infinite.groups, (Groups{{0}, {1, 2}}));
  // A tie with the unbeaten one makes the distance finite.
  std::vector<Comparison> tied = unbeaten;
  tied[0].ties = 1;
  EXPECT_EQ(fit_worths(tied, 3, false).state, WorthState::fitted);
  EXPECT_EQ(fit_worths(std::vector<Comparison>{{.a = 0, .b = 1, .ties = 5}}, 2, false).state, WorthState::all_ties);
  const std::vector<Comparison> first = {{.a = 0, .b = 1, .a_is_first = true, .a_wins = 5},
                                         {.a = 1, .b = 0, .a_is_first = true, .a_wins = 5}};
  EXPECT_EQ(fit_worths(first, 2, true).state, WorthState::one_position);
  EXPECT_EQ(fit_worths(first, 2, false).state, WorthState::fitted);
  EXPECT_EQ(fit_worths({}, 3, false).state, WorthState::no_data);
  EXPECT_EQ(fit_jod({{0, 5, 0, 0}, {3, 0, 0, 0}, {0, 0, 0, 2}, {0, 0, 2, 0}}, JodPrior::gaussian).state,
            WorthState::disconnected);
  EXPECT_EQ(fit_jod({{0, 5}, {0, 0}}, JodPrior::none).state, WorthState::unbeaten);
  EXPECT_EQ(fit_jod({{0, 5}, {0, 0}}, JodPrior::gaussian).state, WorthState::fitted);
}

Wins wins_of(const Expected& matrix) { return matrix.get<Wins>(); }

TEST(JodScale, IsThatOfPwcmp) {
  const Expected& expected = test::statistics_expected();
  size_t cases = 0;
  for (const auto& [name, c] : expected.at("jod_scaling").items()) {
    if (name.starts_with("disconnected") || !c.contains("D")) continue;
    SCOPED_TRACE(name);
    ++cases;
    for (const auto& [prior, key] :
         {std::pair(JodPrior::none, "none_mean0"), std::pair(JodPrior::gaussian, "gaussian_mean0")}) {
      const Jod got = fit_jod(wins_of(c.at("D")), prior);
      ASSERT_EQ(got.state, WorthState::fitted);
      for (size_t i = 0; i < got.q.size(); ++i)
        EXPECT_NEAR(got.q[i], c.at("pwcmp").at(key)[i].get<double>(), 1e-4) << key;
    }
    if (!c.contains("ml_case_v")) continue;
    const Jod got = fit_jod(wins_of(c.at("D")), JodPrior::none);
    EXPECT_NEAR(got.negative_log_likelihood, c.at("ml_case_v").at("neg_log_lik").get<double>(), 1e-4);
    for (size_t i = 0; i < got.q.size(); ++i)
      EXPECT_NEAR(got.se[i], c.at("ml_case_v").at("se_first_0")[i].get<double>(), 1e-4);
  }
  EXPECT_GE(cases, 2U);
}

TEST(JodScale, BootstrapOfGivenRowsIsPwcmps) {
  const Expected& expected = test::statistics_expected();
  if (!expected.at("jod_scaling").contains("bootstrap_12obs_4")) GTEST_SKIP() << "needs the shared ground-truth folder";
  const Expected& c = expected.at("jod_scaling").at("bootstrap_12obs_4");
  std::vector<Wins> observers;
  for (const Expected& column : c.at("per_observer_column_major")) {
    Wins wins(4, std::vector<double>(4));
    for (size_t i = 0; i < 16; ++i) wins[i % 4][i / 4] = column[i].get<double>();
    observers.push_back(wins);
  }
  std::vector<std::vector<size_t>> draws;
  for (const Expected& row : c.at("bootstrap_rows_1based")) {
    draws.emplace_back();
    for (const Expected& o : row) draws.back().push_back(o.get<size_t>() - 1);
  }
  for (const auto& [prior, key] :
       {std::pair(JodPrior::none, "bootstrap_none"), std::pair(JodPrior::gaussian, "bootstrap_gaussian")}) {
    const JodIntervals got = bootstrap_jod(observers, draws, prior);
    ASSERT_EQ(got.q.size(), 4U);
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(got.q[i].low, c.at(key).at("ci95_numpy_linear_type7")[0][i].get<double>(), 2e-4) << key;
      EXPECT_NEAR(got.q[i].high, c.at(key).at("ci95_numpy_linear_type7")[1][i].get<double>(), 2e-4) << key;
    }
  }
  EXPECT_EQ(bootstrap_draws(5, 3, 1), bootstrap_draws(5, 3, 1));
  EXPECT_NE(bootstrap_draws(5, 3, 1), bootstrap_draws(5, 3, 2));
}

}  // namespace
}  // namespace crowdbench::studies
