// Orders of presentation, counted; and QUEST+ against two other programs, answer by answer.
#include "studies/analysis/designs.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "studies/analysis/quest_plus.h"
#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;

TEST(Designs, WilliamsBalancesPlacesAndNeighbours) {
  for (uint32_t n = 2; n <= 12; ++n) {
    const auto rows = williams_design(n);
    ASSERT_EQ(rows.size(), n % 2 == 0 ? n : 2 * n) << n;
    std::map<std::pair<size_t, uint32_t>, uint32_t> places;
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> after;
    for (const auto& row : rows) {
      EXPECT_EQ(std::set<uint32_t>(row.begin(), row.end()).size(), n);
      for (size_t i = 0; i < n; ++i) {
        ++places[{i, row[i]}];
        if (i > 0) ++after[{row[i - 1], row[i]}];
      }
    }
    const uint32_t times = n % 2 == 0 ? 1 : 2;
    EXPECT_EQ(places.size(), size_t{n} * n);
    for (const auto& [place, count] : places) EXPECT_EQ(count, times) << n;
    EXPECT_EQ(after.size(), size_t{n} * (n - 1));
    for (const auto& [pair, count] : after) EXPECT_EQ(count, times) << n << ": " << pair.first << pair.second;
  }
  EXPECT_EQ(williams_design(1), (std::vector<std::vector<uint32_t>>{{0}}));
  const Expected& expected = test::statistics_expected();
  const Expected& williams = expected.at("designs").at("williams");
  EXPECT_EQ(williams_design(4), williams.at("example_n4").get<std::vector<std::vector<uint32_t>>>());
  EXPECT_EQ(williams_design(5), williams.at("example_n5").get<std::vector<std::vector<uint32_t>>>());
}

TEST(Designs, RoundRobinMeetsAllOnceAndBalancesSides) {
  for (uint32_t n = 2; n <= 11; ++n) {
    std::set<std::pair<uint32_t, uint32_t>> met;
    std::vector<int> sides(n, 0);  // shown first less shown second
    const auto rounds = round_robin(n);
    EXPECT_EQ(rounds.size(), n % 2 == 0 ? n - 1 : n);
    for (const Pairs& round : rounds) {
      std::set<uint32_t> busy;
      for (const auto& [a, b] : round) {
        EXPECT_TRUE(busy.insert(a).second && busy.insert(b).second) << n;
        EXPECT_TRUE(met.insert(std::minmax(a, b)).second) << n;
        ++sides[a];
        --sides[b];
      }
    }
    EXPECT_EQ(met.size(), size_t{n} * (n - 1) / 2);
    for (const int side : sides) EXPECT_LE(std::abs(side), n % 2 == 0 ? 1 : 0) << n;
  }
}

QuestSettings quest_of(const Expected& c) {
  QuestSettings out;
  out.stimuli = c.at("stimuli").get<std::vector<double>>();
  const Expected& p = c.at("parameters");
  const bool normal = c.at("function") == "norm_cdf";
  out.function = normal                  ? QuestFunction::normal
                 : c.at("scale") == "dB" ? QuestFunction::weibull_db
                                         : QuestFunction::weibull_log10;
  out.threshold = p.at(normal ? "mean" : "threshold").get<std::vector<double>>();
  out.slope = p.at(normal ? "sd" : "slope").get<std::vector<double>>();
  out.guess = p.at("lower_asymptote").get<std::vector<double>>();
  out.lapse = p.at("lapse_rate").get<std::vector<double>>();
  return out;
}

TEST(QuestPlusRuns, AreThoseOfTwoOtherPrograms) {
  const Expected& expected = test::statistics_expected();
  size_t runs = 0;
  for (const auto& [name, c] : expected.at("questplus").items()) {
    if (!c.contains("trials")) continue;
    ++runs;
    SCOPED_TRACE(name);
    const std::array<std::string, 4> names =
        c.at("function") == "norm_cdf"
            ? std::array<std::string, 4>{"mean", "sd", "lower_asymptote", "lapse_rate"}
            : std::array<std::string, 4>{"threshold", "slope", "lower_asymptote", "lapse_rate"};
    QuestPlus quest(quest_of(c));
    for (const Expected& check : c.at("psi_check"))
      EXPECT_NEAR(quest.psi(check.at("stim_index").get<size_t>(), check.at("param_index_c_order").get<size_t>()),
                  check.at("psi").get<double>(), 1e-12);
    for (const Expected& t : c.at("trials")) {
      const QuestPlus::Choice choice = quest.next();
      ASSERT_EQ(choice.stimulus, t.at("stim_index").get<size_t>()) << t.at("trial");
      EXPECT_NEAR(choice.expected_entropy, t.at("expected_entropy").get<double>(), 1e-9);
      quest.answer(choice.stimulus, t.at("answer") == 1);
      EXPECT_NEAR(quest.entropy(), t.at("entropy_after").get<double>(), 1e-9);
      for (size_t p = 0; p < names.size(); ++p) {
        if (!t.at("mean").contains(names[p])) continue;
        EXPECT_NEAR(quest.mean()[p], t.at("mean").at(names[p]).get<double>(), 1e-9);
        EXPECT_NEAR(quest.sd()[p], t.at("sd").at(names[p]).get<double>(), 1e-8);
        if (t.at("mode_gap_rel").get<double>() > 1e-9) {
          EXPECT_EQ(quest.mode()[p], t.at("joint_mode").at(names[p]).get<double>());
        }
      }
    }
    for (size_t p = 0; p < names.size(); ++p) {
      if (!c.at("final_marginal_posterior").contains(names[p])) continue;
      const auto marginal = c.at("final_marginal_posterior").at(names[p]).get<std::vector<double>>();
      for (size_t i = 0; i < marginal.size(); ++i) EXPECT_NEAR(quest.marginal(p)[i], marginal[i], 1e-9);
    }
  }
  EXPECT_GE(runs, 1U);
}

}  // namespace
}  // namespace crowdbench::studies
