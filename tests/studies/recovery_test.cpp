// Simulated observers, of whom everything is known, through the whole analysis: estimates come back, intervals cover as
// often as they say, and "equivalent" is not said of what differs. A few seeds here; as many as one likes by
//   tools/study_evidence.sh build/release docs/study-evidence.md --seeds 500
// which takes the rows of a table that these tests print.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "core/probability.h"
#include "core/random.h"
#include "core/statistics.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/equivalence.h"
#include "studies/analysis/mixed_model.h"
#include "studies/analysis/paired_comparison.h"
#include "studies/analysis/power.h"
#include "studies/analysis/psychometric.h"
#include "studies/analysis/quest_plus.h"
#include "studies/analysis/simulated.h"
#include "tests/studies/ground_truth.h"
#include "tests/support/sanitized.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;

size_t seeds(size_t normally) {
  const char* given = std::getenv("CROWDBENCH_SEEDS");
  return given != nullptr ? std::strtoul(given, nullptr, 10) : normally;
}

// That a share which should be p came out of n within what 99.9 of 100 honest runs give, and, with 500 seeds or more,
// within `least` to `most`.
void expect_share(size_t k, size_t n, double p, double least, double most, const char* what) {
  const double share = static_cast<double>(k) / static_cast<double>(n);
  const CountLimits limits = binomial_limits(n, p);
  std::cout << fmt::format("| {} | {} of {} | {:.1f} % | {:g} % | {} to {} |\n", what, k, n, 100 * share, 100 * p,
                           limits.low, limits.high);
  const double noise = 3.3 * std::sqrt(p * (1 - p) / static_cast<double>(n));
  if (n >= 500) {
    EXPECT_GE(share, least) << what;
    EXPECT_LE(share, most) << what;
  } else {
    EXPECT_GE(share, p - noise - 1.0 / static_cast<double>(n)) << what;
    EXPECT_LE(share, p + noise + 1.0 / static_cast<double>(n)) << what;
  }
}

// Simulated answers through the door that all answers take.
Answers through_a_table(const Answers& answers) {
  const Table table = parse_table(answers_csv(answers), "simulated.csv");
  Answers out;
  add_answers(out, table, columns_by_name(table));
  return out;
}

TEST(Recovery, ThresholdOfMixedModelIsCovered) {
  const SimulatedObservers truth{.threshold = 1.5, .slope = 1.2, .threshold_sd = 0.6};
  const SimulatedDesign design{.participants = 24, .levels = {0, 1, 2, 3}, .clips = 1, .repeats = 8};
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess = 0;
  settings.curve.level = 0.5;
  const size_t n = seeds(24);
  size_t covered = 0;
  double sum = 0;
  for (size_t seed = 0; seed < n; ++seed) {
    const Analysis analysis = analyse(through_a_table(simulate_answers(truth, design, seed)), settings);
    const MixedResult& mixed = analysis.tasks.at(0).mixed.at(0);
    ASSERT_TRUE(mixed.fit.state == MixedState::fitted || mixed.fit.state == MixedState::singular);
    const auto& at = mixed.threshold;
    ASSERT_TRUE(at && at->interval);
    covered += at->interval->low <= truth.threshold && truth.threshold <= at->interval->high ? 1 : 0;
    sum += at->at;
  }
  EXPECT_NEAR(sum / static_cast<double>(n), truth.threshold, 0.6 / std::sqrt(24.0 * static_cast<double>(n)) * 4);
  expect_share(covered, n, 0.95, 0.93, 0.97, "threshold of the mixed model, table to interval");
}

TEST(Recovery, ThresholdOfPsychometricFunctionIsCovered) {
  const CurveParameters truth{.location = 3, .scale = 0.8, .guess = 0.5, .lapse = 0.01};
  const size_t n = seeds(40);
  size_t covered = 0;
  const CurveSettings settings;
  const double threshold = x_at(Curve::logistic, false, truth, settings.level).value();
  for (size_t seed = 0; seed < n; ++seed) {
    std::vector<Level> levels;
    for (uint64_t i = 0; i < 7; ++i) {
      Level level{static_cast<double>(i), 0, 40};
      for (uint64_t t = 0; t < level.of; ++t)
        level.yes += random_unit(seed, i, 100 + t) < psi(Curve::logistic, false, truth, level.x) ? 1 : 0;
      levels.push_back(level);
    }
    const CurveFit fit = fit_curve(levels, settings);
    ASSERT_TRUE(fit.state == CurveState::fitted || fit.state == CurveState::step) << state_text(fit.state);
    covered +=
        fit.threshold_profile.low.value_or(-1e9) <= threshold && threshold <= fit.threshold_profile.high.value_or(1e9)
            ? 1
            : 0;
  }
  expect_share(covered, n, 0.95, 0.93, 0.97, "threshold of the psychometric function, profile likelihood");
}

// Studies of one design: how often the interval that is told of the curve, and the mixed model's, hold the truth.
// Answers without a threshold or an interval are counted, and no part of the share.
void expect_covered(const std::string& name, const SimulatedObservers& truth, const SimulatedDesign& design,
                    const AnalysisSettings& settings, size_t n) {
  size_t told = 0, covered = 0, mixed_told = 0, mixed_covered = 0;
  for (size_t seed = 0; seed < n; ++seed) {
    const Analysis analysis = analyse(simulate_answers(truth, design, 1000 + seed), settings);
    const auto interval = threshold_interval(analysis.tasks.at(0).curves.at(0));
    if (interval && !interval->method.empty()) {
      ++told;
      covered += interval->low.value_or(-1e9) <= truth.threshold && truth.threshold <= interval->high.value_or(1e9);
    }
    const auto& mixed = analysis.tasks[0].mixed.at(0).threshold;
    if (mixed && mixed->interval) {
      ++mixed_told;
      mixed_covered += mixed->interval->low <= truth.threshold && truth.threshold <= mixed->interval->high;
    }
  }
  EXPECT_GE(told, n * 9 / 10) << name;
  expect_share(covered, told, 0.95, 0.93, 0.97, ("threshold over " + name + ", jackknife").c_str());
  std::cout << fmt::format(
      "| threshold over {}, mixed model | {} of {} | {:.1f} % | 95 % | - |\n", name, mixed_covered, mixed_told,
      100 * static_cast<double>(mixed_covered) / static_cast<double>(std::max<size_t>(1, mixed_told)));
  if (mixed_told == 0) return;
  // Of few clips the sentence says that it is somewhat less.
  const double nominal = design.clips > 1 && design.clips < 5 ? 0.92 : 0.95;
  const auto of = static_cast<double>(mixed_told);
  EXPECT_GE(static_cast<double>(mixed_covered) / of,
            nominal - (n >= 500 ? 0.02 : 3.3 * std::sqrt(nominal * (1 - nominal) / of) + 1 / of))
      << "mixed model, " << name;
}

// Participants whose thresholds differ, few and many of them.
void expect_covered_over_participants(const char* name, const SimulatedObservers& truth, SimulatedDesign design,
                                      AnalysisSettings settings, size_t n) {
  settings.resamples = 0;
  for (const uint32_t participants : {3U, 5U, 9U, 24U}) {
    design.participants = participants;
    expect_covered(fmt::format("{} participants, {}", participants, name), truth, design, settings, n);
  }
}

TEST(Recovery, ThresholdOverFewParticipantsIsCovered) {
  CROWDBENCH_SKIP_SANITIZED("ThresholdOfMixedModelIsCovered");
  AnalysisSettings settings;
  settings.curve.guess = 0;
  settings.curve.level = 0.5;
  expect_covered_over_participants("yes or no", {.threshold = 1.5, .slope = 1.2, .threshold_sd = 0.6},
                                   {.levels = {0, 1, 2, 3}, .clips = 1, .repeats = 8}, settings, seeds(10));
  settings.curve.guess = 0.5;
  settings.curve.level = 0.75;
  settings.curve.falling = true;
  expect_covered_over_participants("forced choice, falling",
                                   {.threshold = 150, .slope = -0.03, .threshold_sd = 30, .guess = 0.5},
                                   {.levels = {60, 105, 150, 195, 240}, .clips = 1, .repeats = 8}, settings, seeds(10));
}

// Clips that differ as much as participants do, few and many of them, and clips that do not differ.
TEST(Recovery, ThresholdOverFewClipsIsCovered) {
  CROWDBENCH_SKIP_SANITIZED("ThresholdOfMixedModelIsCovered");
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess = 0;
  settings.curve.level = 0.5;
  settings.curve.lapse_rate = Rate::fixed;
  const size_t n = seeds(6);
  for (const double clip_sd : {0.5, 1.0, 0.0})
    for (const auto& [participants, clips] : {std::pair{12U, 3U}, {12U, 6U}, {24U, 10U}}) {
      if (participants > 12 && n < 50) continue;  // costs most, and holds best
      expect_covered(fmt::format("{} participants and {} clips of sd {}", participants, clips, clip_sd),
                     {.threshold = 12, .slope = 0.5, .threshold_sd = 1, .clip_sd = clip_sd},
                     {.participants = participants, .levels = {6, 9, 12, 15, 18}, .clips = clips, .repeats = 2},
                     settings, n);
    }
}

TEST(Recovery, DifferencesOfWorthsAreCovered) {
  const SimulatedRanking truth{.log_worth = {0.9, 0.3, 0, -0.5}, .log_nu = -0.6, .position = 0.3};
  const size_t n = seeds(100);
  size_t covered = 0;
  size_t ordered = 0;
  for (size_t seed = 0; seed < n; ++seed) {
    const Worths fit = fit_worths(simulate_comparisons(truth, 20, 2, seed), 4, true);
    ASSERT_EQ(fit.state, WorthState::fitted);
    const Difference d = difference_of(fit, 0, 3);
    covered += std::fabs(d.value - 1.4) <= 1.959964 * d.se ? 1 : 0;
    ordered += fit.log_worth[0] > fit.log_worth[1] && fit.log_worth[1] > fit.log_worth[3] ? 1 : 0;
  }
  expect_share(covered, n, 0.95, 0.93, 0.97, "difference of two log-worths, ties and position in the model");
  std::cout << fmt::format("| ranking of items 1, 2 and 4 of 4 as it was made | {} of {} | {:.1f} % | - | - |\n",
                           ordered, n, 100 * static_cast<double>(ordered) / static_cast<double>(n));
  EXPECT_GT(ordered, n * 9 / 10);
}

// Participants differ, and their mean lies exactly at the margin: what may be called equivalent at most once in twenty.
TEST(Recovery, EquivalentIsNotSaidOfWhatLiesAtTheMargin) {
  const size_t n = seeds(100);
  size_t said = 0;
  size_t said_of_equal = 0;
  for (const double truth : {0.6, 0.5})
    for (size_t seed = 0; seed < n; ++seed) {
      std::vector<Share> shares;
      for (uint64_t p = 0; p < 24; ++p) {
        // Shares spread evenly by up to .1 either way: their mean is the truth.
        const double own = truth + 0.2 * (random_unit(seed, p, 1) - 0.5);
        Share share{0, 40};
        for (uint64_t t = 0; t < share.of; ++t) share.chosen += random_unit(seed, p, 100 + t) < own ? 1 : 0;
        shares.push_back(share);
      }
      const bool equivalent = judge_equivalence(shares, {.margin = 0.1}).verdict == Verdict::equivalent;
      (truth == 0.5 ? said_of_equal : said) += equivalent ? 1 : 0;
    }
  const auto row = [n](const char* what, size_t k, const char* nominal) {
    std::cout << fmt::format("| {} | {} of {} | {:.1f} % | {} | - |\n", what, k, n,
                             100 * static_cast<double>(k) / static_cast<double>(n), nominal);
  };
  row("\"equivalent\" said of what lies at the margin", said, "at most 5 %");
  row("\"equivalent\" said of what is equal", said_of_equal, "-");
  EXPECT_LE(static_cast<double>(said),
            0.05 * static_cast<double>(n) + 3.3 * std::sqrt(0.05 * 0.95 * static_cast<double>(n)) * (n < 500));
  EXPECT_GT(said_of_equal, n * 9 / 10);
}

// The interval in which the posterior of the threshold holds all but 2.5 % at either end, between the grid's points.
Interval posterior_interval(const QuestPlus& quest, const std::vector<double>& grid) {
  const std::vector<double> marginal = quest.marginal(0);
  const auto at = [&](double share) {
    double below = 0;
    for (size_t i = 0; i < grid.size(); ++i) {
      if (below + marginal[i] >= share)  // what a point holds lies half a step to either side of it
        return grid[i] + (grid[1] - grid[0]) * ((share - below) / marginal[i] - 0.5);
      below += marginal[i];
    }
    return grid.back();
  };
  return {at(0.025), at(0.975)};
}

// As wide an interval with six tenths of the trials: the width of the posterior's 95 % interval, how often it holds the
// truth, and the error of the posterior's mean, against those of constant stimuli on the same grid.
TEST(Recovery, QuestPlusNeedsFewerTrials) {
  QuestSettings grid{.function = QuestFunction::normal,
                     .stimuli = {},
                     .threshold = {},
                     .slope = {0.7, 1, 1.5, 2.2},
                     .guess = {0.5},
                     .lapse = {0.02}};
  for (int i = 0; i <= 20; ++i) grid.stimuli.push_back(i);
  for (int i = 0; i <= 40; ++i) grid.threshold.push_back(i * 0.5);
  constexpr size_t kConstant = 100;
  constexpr size_t kAdaptive = 60;
  const size_t n = seeds(40);
  struct Method {
    std::vector<double> errors, widths;
    size_t held = 0;
    void add(const QuestPlus& quest, const std::vector<double>& thresholds, double truth) {
      const Interval interval = posterior_interval(quest, thresholds);
      errors.push_back(std::fabs(quest.mean()[0] - truth));
      widths.push_back(interval.high - interval.low);
      held += interval.low <= truth && truth <= interval.high ? 1 : 0;
    }
  };
  Method constant;
  Method adaptive;
  for (size_t seed = 0; seed < n; ++seed) {
    const double truth = 6 + 8 * random_unit(seed, 0, 1);
    const auto yes = [&](double x, uint64_t trial, uint64_t purpose) {
      return random_unit(seed, trial, purpose) < 0.5 + 0.48 * 0.5 * std::erfc(-(x - truth) / std::sqrt(2.0));
    };
    QuestPlus fixed(grid);
    for (size_t t = 0; t < kConstant; ++t) {
      const size_t stimulus = t % 5 * 3 + 4;  // 4, 7, 10, 13, 16: over all thresholds there may be
      fixed.answer(stimulus, yes(grid.stimuli[stimulus], t, 2));
    }
    QuestPlus quest(grid);
    for (size_t t = 0; t < kAdaptive; ++t) {
      const size_t stimulus = quest.next().stimulus;
      quest.answer(stimulus, yes(grid.stimuli[stimulus], t, 3));
    }
    constant.add(fixed, grid.threshold, truth);
    adaptive.add(quest, grid.threshold, truth);
  }
  const auto row = [n](const char* name, size_t trials, const Method& m) {
    std::cout << fmt::format("| {} | {} | {:.3f} | {:.3f} | {} of {} |\n", name, trials, median(m.widths),
                             median(m.errors), m.held, n);
  };
  row("constant stimuli", kConstant, constant);
  row("QUEST+", kAdaptive, adaptive);
  EXPECT_LE(median(adaptive.widths), median(constant.widths));
  EXPECT_LE(median(adaptive.errors), median(constant.errors));
  // They hold more than they say: the truths lie in the middle of the grid, and have one slope, which the posterior
  // does not know.
  const double noise = 3.3 * std::sqrt(0.95 * 0.05 * static_cast<double>(n)) + 1;
  for (const Method* m : {&constant, &adaptive})
    EXPECT_GE(static_cast<double>(m->held), 0.95 * static_cast<double>(n) - noise);
}

TEST(Recovery, PowerIsThatOfLme4) {
  CROWDBENCH_SKIP_SANITIZED("ThresholdOfMixedModelIsCovered");
  const Expected& expected = test::statistics_expected();
  const size_t n = seeds(40);
  for (const auto& [name, c] : expected.at("power_simulation").items()) {
    const Expected& truth = c.at("truth");
    for (const Expected& row : c.at("rows")) {
      const Power got = simulate_power({.intercept = truth.at("b0").get<double>(),
                                        .effect = truth.at("b1").get<double>(),
                                        .participant_sd = truth.at("so").get<double>(),
                                        .clip_sd = truth.at("sc").get<double>(),
                                        .participants = row.at("observers").get<uint32_t>(),
                                        .clips = truth.at("nclip").get<uint32_t>(),
                                        .simulations = n});
      SCOPED_TRACE(name + ", " + row.at("observers").dump());
      const auto reference = row.at("power").get<double>();
      std::cout << fmt::format("| {} | {} | {:.3f} +- {:.3f} | {:.3f} +- {:.3f} |\n", name,
                               row.at("observers").get<int>(), got.power, got.power_se, reference,
                               row.at("mc_se").get<double>());
      const double own = std::sqrt(reference * (1 - reference) / static_cast<double>(n));
      EXPECT_NEAR(got.power, reference, 3 * std::hypot(row.at("mc_se").get<double>(), own));
      EXPECT_NEAR(got.mean_se / row.at("mean_se").get<double>(), 1, 0.05);
      EXPECT_EQ(got.failed, 0U);
    }
  }
}

TEST(Simulated, AnswersAreReproducibleAndAsAsked) {
  const SimulatedObservers observers{.threshold = 2, .slope = 3, .guess = 0.2, .lapse = 0.1};
  const SimulatedDesign design{.participants = 30, .levels = {-20, 2, 20}, .clips = 5, .repeats = 10};
  const Answers answers = simulate_answers(observers, design, 7);
  ASSERT_EQ(answers.rows.size(), 30U * 3 * 5 * 10);
  std::map<double, double> yes;
  for (const Answer& a : answers.rows) yes[*a.level] += static_cast<double>(a.yes) / 1500;
  EXPECT_NEAR(yes[-20], 0.2, 0.04);
  EXPECT_NEAR(yes[2], 0.2 + 0.7 / 2, 0.05);
  EXPECT_NEAR(yes[20], 0.9, 0.03);
  EXPECT_EQ(answers_csv(answers), answers_csv(simulate_answers(observers, design, 7)));
  EXPECT_NE(answers_csv(answers), answers_csv(simulate_answers(observers, design, 8)));
  // The table comes in by the door through which all tables come.
  const Table table = parse_table(answers_csv(answers), "t.csv");
  EXPECT_EQ(table.rows[0].fields[0], "simulated");
  Answers read;
  add_answers(read, table, columns_by_name(table));
  EXPECT_EQ(read.rows.size(), answers.rows.size());
  EXPECT_EQ(read.participants[0], "simulated 1");
  // Fewer observers are the first of more.
  SimulatedDesign fewer = design;
  fewer.participants = 3;
  EXPECT_EQ(answers_csv(answers).rfind(answers_csv(simulate_answers(observers, fewer, 7)), 0), 0U);
}

TEST(Simulated, BiasAndLearningMoveAnswers) {
  const SimulatedDesign design{.participants = 40, .levels = {0}, .clips = 1, .repeats = 40};
  const Answers learned = simulate_answers({.learning = 4}, design, 3);
  double early = 0;
  double late = 0;
  for (const Answer& a : learned.rows) (std::stoi(a.trial) <= 20 ? early : late) += static_cast<double>(a.yes);
  EXPECT_GT(late, 1.5 * early);
  // Of every two repeats the first has what is looked for on the first side. Nothing is seen at -20: all are guesses.
  SimulatedDesign blind = design;
  blind.levels = {-20};
  const auto chosen_first = [&](double bias, double guess) {
    double first = 0;
    for (const Answer& a : simulate_answers({.guess = guess, .side_bias = bias}, blind, 3).rows)
      first += a.yes_first.value() == (a.yes > 0) ? 1.0 / 1600 : 0;
    return first;
  };
  EXPECT_NEAR(chosen_first(0, 0.5), 0.5, 0.04);
  EXPECT_NEAR(chosen_first(1, 0.5), logistic_cdf(1), 0.04);
  EXPECT_NEAR(chosen_first(-1, 0.5), logistic_cdf(-1), 0.04);
  EXPECT_NEAR(biased_guess(0.5, 0.1, 5), 0.9, 1e-12);
  EXPECT_EQ(biased_guess(0, 0, 2), 0) << "nobody guesses";
}

}  // namespace
}  // namespace crowdbench::studies
