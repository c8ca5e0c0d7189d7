// What is said of answers: two conditions against each other, scores against answers, whether it was planned, the forms
// of other tools, and what tables of the worst kind end in.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "core/error.h"
#include "core/files.h"
#include "core/probability.h"
#include "core/random.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/analysis_output.h"
#include "studies/analysis/analysis_text.h"
#include "studies/analysis/exports.h"
#include "studies/analysis/plan_standing.h"
#include "studies/analysis/text_numbers.h"
#include "studies/analysis/verdict_sentences.h"
#include "tests/studies/answer_tables.h"
#include "tests/studies/ground_truth.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::studies {
namespace {

using test::answers_of;
using Expected = nlohmann::json;

// ---- two conditions

TEST(TwoConditions, AreThoseOfStatsmodelsAndTheLikelihoodSearch) {
  size_t compared = 0;
  for (const Expected& c : test::statistics_expected().at("equivalence").at("two_proportions"))
    for (const Expected& t : c.at("tost")) {
      const auto name = t.at("method").get<std::string>();
      const bool score = name.starts_with("score");
      const DifferenceMethod method = score            ? DifferenceMethod::score
                                      : name == "wald" ? DifferenceMethod::wald
                                                       : DifferenceMethod::agresti_caffo;
      const Tost got =
          tost_difference(c.at("count1").get<uint64_t>(), c.at("nobs1").get<uint64_t>(), c.at("count2").get<uint64_t>(),
                          c.at("nobs2").get<uint64_t>(), t.at("margin").get<double>(), method);
      SCOPED_TRACE(c.dump().substr(0, 60) + " " + name);
      // The score's z of the likelihood search is exact to 1e-4.
      const double tolerance = score ? 5e-5 : 1e-9;
      EXPECT_NEAR(got.p_low, t.at("p_low").get<double>(), tolerance);
      EXPECT_NEAR(got.p_upp, t.at("p_upp").get<double>(), tolerance);
      EXPECT_EQ(got.p, std::max(got.p_low, got.p_upp));
      ++compared;
    }
  EXPECT_GE(compared, 9U);
}

TEST(TwoConditions, VerdictNeedsTrialsAndParticipants) {
  const EquivalenceSettings settings{.margin = 0.1};
  std::vector<SharePair> alike;
  std::vector<SharePair> apart;
  std::vector<SharePair> torn;  // the same shares in all, and every participant on one side
  for (uint64_t p = 0; p < 20; ++p) {
    alike.push_back({{20 + p % 2, 40}, {21 - p % 2, 40}});
    apart.push_back({{30 + p % 3, 40}, {20, 40}});
    torn.push_back({{p % 2 == 0 ? 36U : 4U, 40}, {p % 2 == 0 ? 4U : 36U, 40}});
  }
  EXPECT_EQ(judge_difference(alike, true, settings).verdict, Verdict::equivalent);
  const DifferenceEquivalence different = judge_difference(apart, true, settings);
  EXPECT_EQ(different.verdict, Verdict::different);
  EXPECT_NEAR(different.difference, (30 * 20 + 19) / 800.0 - 0.5, 1e-12);
  const DifferenceEquivalence unsure = judge_difference(torn, true, settings);
  EXPECT_LE(unsure.score.p, 0.05) << "its trials alone would say equivalent";
  EXPECT_EQ(unsure.verdict, Verdict::not_enough_data);
  EXPECT_GT(unsure.more_participants, 100U);
  // Nobody answered both.
  const std::vector<SharePair> strangers = {{{300, 600}, {0, 0}}, {{0, 0}, {300, 600}}};
  EXPECT_EQ(judge_difference(strangers, true, settings).verdict, Verdict::not_enough_data);
  EXPECT_EQ(judge_difference(strangers, true, settings).more_participants, 2U);
  EXPECT_EQ(judge_difference(strangers, false, settings).verdict, Verdict::equivalent);
  // Of so many trials of either condition the test has about the power that was asked for.
  const DifferenceEquivalence few =
      judge_difference(std::vector<SharePair>{{{10, 20}, {10, 20}}}, false, {.margin = 0.15});
  const auto n = few.trials_needed.value();
  EXPECT_EQ(few.more_trials, n - 20);
  double power = 0;
  const std::vector<double> chances = binomial_probabilities(n, 0.5);
  for (uint64_t i = 0; i <= n; i += 1)
    for (uint64_t j = n * 3 / 10; j <= n * 7 / 10; ++j)
      if (chances[i] * chances[j] > 1e-9 && tost_difference(i, n, j, n, 0.15, DifferenceMethod::score).p <= 0.05)
        power += chances[i] * chances[j];
  EXPECT_NEAR(power, 0.8, 0.02);
}

TEST(TwoConditions, StandInTheAnalysis) {
  std::string text = "participant,condition,yes,no\n";
  for (int p = 0; p < 12; ++p)
    text += fmt::format("{},near,{},{}\n{},far,{},{}\n{},off,{},{}\n", p, 20 + p % 2, 20 - p % 2, p, 21 - p % 2,
                        19 + p % 2, p, 34 + p % 3, 6 - p % 3);
  const Analysis a = analyse(answers_of(text), {.between = 0.1, .resamples = 0});
  ASSERT_EQ(a.tasks[0].differences.size(), 3U);
  EXPECT_EQ(a.tasks[0].differences[0].equivalence.verdict, Verdict::equivalent);
  EXPECT_EQ(a.tasks[0].differences[1].equivalence.verdict, Verdict::different);
  EXPECT_GE(a.tasks[0].differences[1].holm, a.tasks[0].differences[1].equivalence.different_score);
  const std::string page = analysis_markdown(a);
  EXPECT_NE(page.find("near and far are equivalent within 0.1"), std::string::npos) << page;
  EXPECT_NE(page.find("near and off are different"), std::string::npos) << page;
}

// ---- scores

// Thirty clips, ten participants; the chance of a yes follows `truth`.
std::string rated(std::string& scores) {
  std::string text = "participant,clip,answer\n";
  scores = "clip,truth,same_order,noise,constant,absent\n";
  for (uint64_t c = 0; c < 30; ++c) {
    const double truth = -2 + 4.0 * static_cast<double>(c) / 29;
    scores += fmt::format("c{},{},{},{},7,\n", c, truth, std::exp(truth), random_unit(5, c, 1));
    for (uint64_t p = 0; p < 10; ++p)
      text += fmt::format("p{},c{},{}\n", p, c, random_unit(c, p, 10) < logistic_cdf(truth) ? "yes" : "no");
  }
  return text;
}

// As many answers as the power asked for takes, whose interval crosses the margin: more are not what it wants.
TEST(Equivalent, EnoughAnswersMayLeaveItUndecided) {
  std::string text = "participant,condition,yes,no\n";
  for (int p = 0; p < 40; ++p) text += fmt::format("{},far,{},{}\n", p, 13 - p % 2, 7 + p % 2);
  AnalysisSettings settings{.random = RandomEffects::none, .resamples = 0};
  settings.margin = 0.13;
  Analysis a = analyse(answers_of(text), settings);
  Equivalence& e = a.tasks.at(0).conditions.at(0).equivalence.value();
  e.verdict = Verdict::not_enough_data;
  e.more_trials = e.more_participants = 0;
  const std::string enough = verdict_sentences(a.tasks[0], settings).at(0);
  EXPECT_NE(
      enough.find("It is undecided whether it lies within 0.13 of 0.5: the answers are as many as the power asked"),
      std::string::npos)
      << enough;
  EXPECT_EQ(enough.find("Not enough"), std::string::npos) << enough;
  e.more_trials = 7;
  const std::string few = verdict_sentences(a.tasks[0], settings).at(0);
  EXPECT_NE(few.find("Not enough data to say whether it lies within 0.13 of 0.5: about 7 more trials"),
            std::string::npos)
      << few;
}

TEST(AnalysisText, SaysThatTwoStudiesAreTakenTogether) {
  const auto lead_of = [](const char* second) {
    const std::string text = fmt::format("participant,study,condition,answer\n1,{0},x,yes\n2,{1},x,no\n",
                                         std::string(64, 'a'), std::string(64, second[0]));
    return analysis_text(analyse(answers_of(text), {.resamples = 0})).lead.at(0);
  };
  EXPECT_EQ(lead_of("b").rfind("The answers are of 2 studies", 0), 0U) << lead_of("b");
  EXPECT_EQ(lead_of("a").find("studies"), std::string::npos) << lead_of("a");
}

TEST(Scores, AreHeldAgainstAnswers) {
  std::string scores;
  const Answers answers = answers_of(rated(scores));
  const AnalysisSettings settings{.random = RandomEffects::none, .resamples = 300};
  const Analysis a = analyse(answers, settings, score_table(parse_table(scores, "s.csv")));
  const ScorePredictions& p = a.tasks.at(0).prediction.value();
  ASSERT_EQ(p.scores.size(), 5U);
  EXPECT_EQ(p.answers, 300U);
  EXPECT_EQ(p.stimuli, 30U);
  EXPECT_EQ(p.scores[*p.best].score, "truth");
  EXPECT_EQ(p.scores[3].state, PredictionState::one_value);
  EXPECT_EQ(p.scores[4].state, PredictionState::no_values);
  const ScorePrediction& truth = p.scores[0];
  EXPECT_GT(truth.auc, 0.65);
  EXPECT_FALSE(truth.falls);
  EXPECT_LT(truth.auc_interval->low, truth.auc);
  EXPECT_GT(truth.auc_interval->high, truth.auc);
  EXPECT_NEAR(truth.calibration_slope.value(), 1, 0.35);
  EXPECT_LT(truth.slope_interval->low, 1);
  EXPECT_NEAR(truth.auc, p.scores[1].auc, 1e-12) << "an area knows the order alone";
  ASSERT_EQ(p.contests.size(), 3U);
  for (const ScoreContest& c : p.contests)
    if (p.scores[c.a].score != "noise" && p.scores[c.b].score != "noise") {
      EXPECT_FALSE(c.distinguishable);
      EXPECT_EQ(c.difference, 0);
    } else {
      EXPECT_TRUE(c.distinguishable) << c.interval->low;
    }
  ASSERT_TRUE(p.best_interval.has_value());
  EXPECT_LT(p.best_interval->low, truth.auc_interval->low) << "it is the best of three";
  TaskResult unsure = a.tasks[0];
  unsure.prediction->best_interval.reset();
  EXPECT_NE(verdict_sentences(unsure, settings).back().find("without an interval none is best"), std::string::npos);
  const std::vector<std::string> said = verdict_sentences(a.tasks[0], settings);
  EXPECT_NE(said.back().find("truth and same_order stand highest alike, and neither is shown to be best (AUC"),
            std::string::npos)
      << said.back();
  EXPECT_NE(
      said.back().find(fmt::format("95 % interval {:.2f} to {:.2f} by Bonferroni's rule, since it is the best of 3",
                                   p.best_interval->low, p.best_interval->high)),
      std::string::npos)
      << said.back();
  TaskResult level = a.tasks[0];
  std::erase_if(level.prediction->scores, [](const ScorePrediction& one) { return one.score == "noise"; });
  level.prediction->contests.clear();
  EXPECT_NE(verdict_sentences(level, settings).back().find("none stands highest: truth, same_order have one AUC"),
            std::string::npos);
  TaskResult first = a.tasks[0];
  first.prediction->scores[1].auc -= 0.01;
  EXPECT_NE(verdict_sentences(first, settings).back().find("truth stands highest, and is not shown to be best (AUC"),
            std::string::npos);
  EXPECT_NE(verdict_sentences(first, settings).back().find("not distinguishable from it: same_order."),
            std::string::npos);
  const AnalysisText text = analysis_text(a);
  ASSERT_EQ(text.tasks.size(), 1U);
  EXPECT_EQ(text.tasks[0].verdicts, said);
  const Analysis again = analyse(answers, settings, score_table(parse_table(scores, "s.csv")));
  EXPECT_EQ(analysis_json(a).dump(), analysis_json(again).dump());
}

TEST(Scores, AreasAreRightByHand) {
  // Of the nine pairs of a yes and a no 8 are in order, and one is equal.
  PredictedAnswers answers;
  answers.values = {{1.0}, {2.0}, {3.0}};
  answers.cells = {{0, 0, 0, 2}, {0, 1, 1, 2}, {0, 2, 2, 2}};
  const ScorePredictions up = predict_by_scores({"s"}, answers, 0.95, 1, 0);
  EXPECT_NEAR(up.scores[0].auc, 1 - (0.5 * 1) / 9, 1e-12);
  for (auto& v : answers.values) v[0] = -*v[0];
  const ScorePredictions down = predict_by_scores({"s"}, answers, 0.95, 1, 0);
  EXPECT_TRUE(down.scores[0].falls);
  EXPECT_NEAR(down.scores[0].auc, up.scores[0].auc, 1e-12);
  EXPECT_FALSE(down.scores[0].calibration_slope) << "three stimuli are too few";
  answers.cells = {{0, 0, 2, 2}, {0, 1, 2, 2}};
  EXPECT_EQ(predict_by_scores({"s"}, answers, 0.95, 1, 10).scores[0].state, PredictionState::all_alike);
}

TEST(Scores, OfItemsDoNotCareWhichStandsFirst) {
  const std::string scores = "item,error\nmesh,0\nflat,2\nrelief,1\n";
  const ScoreTable table = score_table(parse_table(scores, "s.csv"));
  const auto prediction = [&](const std::string& text) {
    return analyse(answers_of(text), {.resamples = 20}, table).tasks.at(0).prediction.value();
  };
  const ScorePredictions one =
      prediction("participant,item_a,item_b,yes,no\n1,mesh,flat,9,1\n1,relief,flat,7,3\n1,mesh,relief,6,4\n");
  const ScorePredictions turned =
      prediction("participant,item_a,item_b,yes,no\n1,flat,mesh,1,9\n1,flat,relief,3,7\n1,relief,mesh,4,6\n");
  EXPECT_NEAR(one.scores[0].auc, turned.scores[0].auc, 1e-12);
  EXPECT_GT(one.scores[0].auc, 0.6);
  EXPECT_TRUE(one.scores[0].falls) << "less error is chosen";
  EXPECT_EQ(one.answers, 30U);
}

TEST(Scores, OfClipsSayNothingOfAChoiceOfTwoItems) {
  const ScoreTable table = score_table(parse_table("clip,error\na,0\nb,2\n", "s.csv"));
  try {
    analyse(answers_of("clip,item_a,item_b,yes,no\na,mesh,flat,9,1\nb,mesh,flat,2,8\n"), {.resamples = 0}, table);
    ADD_FAILURE() << "a direction was made up";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("do not say which of two items is chosen"), std::string::npos)
        << error.what();
  }
}

TEST(Scores, OfAStudyAreHeldToTheLimitsOfTables) {
  const support::ScratchFolder folder;
  const auto fault = [&](const std::string& stimuli) -> std::string {
    write_file(folder / "study.json", "{\"stimuli\": [" + stimuli + "]}");
    try {
      read_scores(folder / "study.json");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const std::string one = R"({"id": "s1", "scores": [{"score": "ssim", "mean": 1}]})";
  EXPECT_EQ(fault(one), "");
  EXPECT_NE(fault(one + "," + one).find("has the stimulus 's1' twice"), std::string::npos);
  std::string many;
  for (size_t i = 0; i <= kMostScores; ++i)
    many += (i > 0 ? "," : "") + fmt::format(R"({{"score": "x{}", "mean": 1}})", i);
  EXPECT_NE(fault(R"({"id": "s1", "scores": [)" + many + "]}").find("has 65 scores"), std::string::npos);
}

TEST(Scores, OfAnotherStudyAreRefused) {
  const support::ScratchFolder folder;
  const auto scores_of = [&](const std::string& hash) {
    write_file(folder / "study.json", R"({"hash": ")" + hash +
                                          R"(", "stimuli": [{"id": "s1", "scores": [{"score": "ssim", "mean": 1}]},)" +
                                          R"({"id": "s2", "scores": [{"score": "ssim", "mean": 0.5}]}]})");
    return read_scores(folder / "study.json");
  };
  const std::string ours(64, 'a');
  const auto analysed = [&](const std::string& text, const std::string& hash) {
    return analyse(answers_of(text), {.random = RandomEffects::none, .resamples = 0}, scores_of(hash));
  };
  const std::string rows = "study,stimulus,yes,no\n" + ours + ",s1,3,1\n" + ours + ",s2,1,3\n";
  EXPECT_TRUE(analysed(rows, ours).tasks.at(0).prediction);
  try {
    analysed(rows, std::string(64, 'b'));
    ADD_FAILURE() << "stimuli of another study have the same ids";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("study.json"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("is of the study bbbbbbbbbbbb, and the answers are of aaaaaaaaaaaa"),
              std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(analysed("stimulus,yes,no\ns1,3,1\ns2,1,3\n", ours).tasks.at(0).prediction) << "not known";
}

TEST(Verdicts, BeginWithWhatWasAskedAndSayWhichSideIsPreferred) {
  // Six people who choose the first side in 8 of 10, the yes standing there as often as not; the seventh says no side.
  std::string text = "participant,condition,yes_first,yes,no\n";
  for (int p = 0; p < 6; ++p) text += fmt::format("{0},far,1,{1},{2}\n{0},far,0,{2},{1}\n", p, 7 + p % 3, 3 - p % 3);
  text += "6,far,,5,5\n";
  AnalysisSettings settings{.random = RandomEffects::none, .resamples = 0};
  settings.asked = {"Which looks better?", "that the half under test was chosen"};
  const Analysis a = analyse(answers_of(text), settings);
  const SideResult& side = a.tasks.at(0).side.value();
  EXPECT_EQ(side.first, 60U);
  EXPECT_EQ(side.of, 120U);
  EXPECT_NEAR(side.chosen_first, 0.8, 1e-12);
  EXPECT_NEAR(side.share, 0.5, 1e-12);
  EXPECT_EQ(side.participants, 6U);
  // Shares of .7, .8 and .9 twice each: standard deviation .0894, by the root of 6, by t of 5 degrees of freedom.
  ASSERT_TRUE(side.interval);
  EXPECT_NEAR(side.interval->high - 0.8, 2.570582 * std::sqrt(0.04 / 5 / 6), 1e-6);
  const std::vector<std::string> said = verdict_sentences(a.tasks[0], settings);
  EXPECT_EQ(said.front(), "Asked was: \"Which looks better?\" \"Yes\" means that the half under test was chosen.");
  EXPECT_NE(said.back().find("chosen in 80 % of the answers"), std::string::npos) << said.back();
  EXPECT_NE(said.back().find("a side is preferred"), std::string::npos) << said.back();
  EXPECT_NE(said.back().find("stood first in 60 of 120: shares are of both sides alike."), std::string::npos);
  // Sides that were not balanced: the share of yes is said as it is of both alike.
  const Analysis skewed =
      analyse(answers_of("participant,condition,yes_first,yes,no\n1,far,1,16,4\n1,far,0,2,8\n"), settings);
  EXPECT_NE(verdict_sentences(skewed.tasks[0], settings).back().find("of both sides alike it is 0.500"),
            std::string::npos);
  EXPECT_FALSE(analyse(answers_of("yes_first,yes,no\n1,5,5\n"), settings).tasks[0].side) << "of one side";
}

TEST(Rankings, SayWhichPairsAreApartWhereTheWidestGapIsNot) {
  // a and b are known well, c hardly.
  const auto said = [](const char* text) {
    const AnalysisSettings settings{.random = RandomEffects::none, .resamples = 0};
    const Analysis a = analyse(answers_of(text), settings);
    return verdict_sentences(a.tasks[0], settings).back();
  };
  const std::string some = said("item_a,item_b,yes,no\na,b,600,400\nb,c,5,1\n");
  EXPECT_NE(some.find("not distinguishable from none; distinguishable is: a from b."), std::string::npos) << some;
  const std::string none = said("item_a,item_b,yes,no\na,b,6,4\nb,c,3,2\n");
  EXPECT_NE(none.find("none is distinguishable from another"), std::string::npos) << none;
}

TEST(Rankings, SayWhatMayStandAtTheEndsAsWell) {
  const auto said = [](const char* text) {
    const AnalysisSettings settings{.random = RandomEffects::none, .resamples = 0};
    const Analysis a = analyse(answers_of(text), settings);
    return verdict_sentences(a.tasks[0], settings).back();
  };
  const std::string sure = said("item_a,item_b,yes,no\na,b,80,20\nb,c,80,20\na,c,95,5\n");
  EXPECT_NE(sure.find("a stands highest and c lowest"), std::string::npos) << sure;
  EXPECT_EQ(sure.find("distinguishable"), std::string::npos) << sure;
  const std::string unsure = said("item_a,item_b,yes,no\na,b,11,9\nb,c,16,4\na,c,17,3\n");
  EXPECT_NE(unsure.find("a stands highest and c lowest"), std::string::npos) << unsure;
  EXPECT_NE(unsure.find("; not distinguishable from a: b."), std::string::npos) << unsure;
  const std::string unbeaten = said("item_a,item_b,yes,no\na,b,20,0\nb,c,16,4\na,c,20,0\n");
  EXPECT_NE(unbeaten.find("which of them differ is not known (unbeaten"), std::string::npos) << unbeaten;
  EXPECT_EQ(said("item_a,item_b,yes,ties,no\na,b,0,20,0\n"), "There is no ranking: nobody preferred anything.");
}

// Five who all say yes ten times differ by nothing, which does not make their mean exact.
TEST(Verdicts, IntervalsAreNoNarrowerThanThatOfTheTrials) {
  std::string text = "participant,yes,no\n";
  for (int p = 0; p < 5; ++p) text += fmt::format("p{},10,0\n", p);
  const AnalysisSettings settings{.margin = 0.1, .random = RandomEffects::none, .resamples = 0};
  const Analysis a = analyse(answers_of(text), settings);
  const std::string said = verdict_sentences(a.tasks[0], settings).front();
  // Clopper and Pearson's 90 % of 50 of 50 begins at 0.05^(1/50).
  EXPECT_NE(said.find(fmt::format("90 % interval {:.3f} to 1.000", std::pow(0.05, 1.0 / 50))), std::string::npos)
      << said;
}

TEST(Scores, RefuseWithTheLine) {
  const std::pair<const char*, const char*> wrong[] = {
      {"name,s\na,1\n", "s.csv:1: has no column that says whose scores they are"},
      {"clip,item,s\na,b,1\n", "s.csv:1: says twice whose scores they are"},
      {"clip\na\n", "s.csv:1: has 0 scores"},
      {"clip,s\na,x\n", "s.csv:2: 'x' in column 's' is not a score"},
      {"clip,s\na,inf\n", "s.csv:2: 'inf' in column 's' is not a score"},
      {"clip,s\na,1\na,2\n", "s.csv:3: has scores of 'a' again"},
      {"clip,s\nother,1\n", "s.csv: has scores of nothing that the answers name"},
  };
  for (const auto& [text, says] : wrong) {
    try {
      analyse(answers_of("clip,answer\na,yes\na,no\n"), {.resamples = 0}, score_table(parse_table(text, "s.csv")));
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(says, 0), 0U) << error.what();
    }
  }
}

// ---- planned or not

TEST(PlanStanding, SaysWhateverSpeaksAgainstIt) {
  const std::string a(64, 'a');
  const std::string b(64, 'b');
  const Answers of_a = answers_of("study,answer\n" + a + ",yes\n");
  const Answers of_b = answers_of("study,answer\n" + b + ",yes\n");
  const Answers of_nothing = answers_of("answer\nyes\n");
  const PlanFacts frozen{"p.toml", a, a, {}};
  EXPECT_EQ(plan_standing(frozen, of_a, {}).standing, Standing::planned);
  EXPECT_EQ(plan_standing({"p.toml", a, std::nullopt, {}}, of_a, {}).standing, Standing::not_planned);
  EXPECT_EQ(plan_standing({"p.toml", b, a, {}}, of_a, {}).standing, Standing::not_planned) << "changed";
  EXPECT_EQ(plan_standing(frozen, of_b, {}).standing, Standing::not_planned);
  EXPECT_EQ(plan_standing(frozen, of_nothing, {}).standing, Standing::not_planned);
  const PlanStanding other = plan_standing(frozen, of_a, {"--ties split"});
  EXPECT_EQ(other.standing, Standing::not_planned);
  EXPECT_NE(other.sentences.at(0).find("--ties split"), std::string::npos);
  const PlanStanding deviates = plan_standing({"p.toml", b, a, {{b, "a clip was broken"}}}, of_b, {});
  EXPECT_EQ(deviates.standing, Standing::deviates);
  EXPECT_NE(deviates.sentences.at(0).find("a clip was broken"), std::string::npos);
}

// ---- other tools

std::string file_named(const std::vector<ExportedFile>& files, const std::string& name) {
  for (const ExportedFile& file : files)
    if (file.name == name) return file.text;
  ADD_FAILURE() << "no " << name;
  return "";
}

TEST(Exports, HoldTheSameData) {
  std::string text = "who,trial,x,what,seen\n";
  for (int p = 0; p < 6; ++p)
    for (int t = 0; t < 12; ++t)
      text += fmt::format("\"p, {}\",{},{},\"a \"\"b\"\"\",{}\n", p, t, t % 4, (t * 7 + p * 5) % 11 < 3 + t % 4 * 2);
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess = 0;
  const Analysis a =
      analyse(answers_of(text, "participant=who,trial=trial,level=x,condition=what,answer=seen"), settings);
  const std::vector<ExportedFile> files = export_files(a);
  const std::string data = file_named(files, "data/study_answers_data.csv");
  EXPECT_EQ(data.substr(0, data.find('\n')), "participant,trial,condition,level,yes,ties,no,chosen,decided");
  // Read back, it gives the same results.
  Expected first = Expected::parse(analysis_json(a).dump());
  Expected second = Expected::parse(analysis_json(analyse(answers_of(data), settings)).dump());
  EXPECT_EQ(first, second);
  const Table triplets = parse_table(file_named(files, "psignifit/1-1.csv"), "p");
  ASSERT_EQ(triplets.rows.size(), 4U);
  EXPECT_EQ(triplets.columns, (std::vector<std::string>{"level", "correct", "total"}));
  EXPECT_EQ(triplets.rows[0].fields[2], "18");
  const Expected description = Expected::parse(file_named(files, "dataset_description.json"));
  EXPECT_EQ(description.at("@type"), "Dataset");
  EXPECT_EQ(description.at("variableMeasured").size(), 9U);
  const std::string script = file_named(files, "analysis.R");
  EXPECT_NE(script.find("glmer("), std::string::npos);
  EXPECT_NE(
      script.find("cbind(2 * chosen, 2 * (decided - chosen)) ~ 1 + centred + (1 | participant), 0, \"logit\", 25"),
      std::string::npos)
      << script.substr(script.size() - 400);
  EXPECT_NE(script.find("condition == \"a \\\"b\\\"\""), std::string::npos);
  EXPECT_EQ(parse_table(file_named(files, "estimates.csv"), "e").rows.size(), 2U);
}

TEST(Exports, ComparisonsForPwcmpAreOneARow) {
  const Analysis a = analyse(
      answers_of("participant,condition,item_a,item_b,yes,ties,no\nA,far,mesh,flat,2,5,1\nB,far,flat,mesh,0,0,1\n"),
      {.resamples = 0});
  EXPECT_EQ(file_named(export_files(a), "pwcmp/1.csv"),
            "Observer,Session,Scene,Condition_1,Condition_2,Selection\n"
            "A,1,far,mesh,flat,1\nA,1,far,mesh,flat,1\nA,1,far,mesh,flat,2\nB,1,far,flat,mesh,2\n");
}

// Names that a spreadsheet would run have an apostrophe before them, in every file alike; numbers are left alone.
TEST(Exports, NamesAreNoFormulas) {
  EXPECT_EQ(text::spreadsheet_safe("=cmd|calc!A1"), "'=cmd|calc!A1");
  for (const char* name : {"+x", "-x", "@x", "\tx", "-", "-5;1"})
    EXPECT_EQ(text::spreadsheet_safe(name)[0], '\'') << name;
  for (const char* name : {"", "x", "a=b", "-5", "+1.5", "-1e-3", "5"}) EXPECT_EQ(text::spreadsheet_safe(name), name);
  std::string table = "participant,condition,level,answer\n";
  for (int p = 0; p < 4; ++p)
    for (int t = 0; t < 8; ++t)
      table += fmt::format("=who{},@far,{},{}\n", p, t % 4 - 2, (t * 7 + p * 5) % 11 < 3 + t % 4 * 2 ? "yes" : "no");
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess = 0;
  const std::vector<ExportedFile> files = export_files(analyse(answers_of(table), settings));
  const Table data = parse_table(file_named(files, "data/study_answers_data.csv"), "d");
  EXPECT_EQ(data.rows.at(0).fields.at(0), "'=who0");
  EXPECT_EQ(data.rows.at(0).fields.at(1), "'@far");
  EXPECT_EQ(data.rows.at(0).fields.at(2), "-2");
  EXPECT_NE(file_named(files, "analysis.R").find("condition == \"'@far\""), std::string::npos);
  EXPECT_EQ(parse_table(file_named(files, "estimates.csv"), "e").rows.at(0).fields.at(1), "'@far");
  EXPECT_NE(file_named(files, "README.md").find("apostrophe"), std::string::npos);
  const Analysis pairs = analyse(answers_of("participant,item_a,item_b,yes,no\nA,=x,+y,1,0\nB,=x,+y,0,1\n"), settings);
  EXPECT_NE(file_named(export_files(pairs), "pwcmp/1.csv").find("A,1,all,'=x,'+y,1"), std::string::npos);
}

// lme4 is to be given what was fitted here.
TEST(Exports, TheScriptLeavesOutWhatHasNoSignal) {
  std::string table = "participant,level,signal,yes,no\n";
  for (int p = 0; p < 4; ++p)
    for (int level = 0; level < 4; ++level)
      table += fmt::format("{},{},1,{},{}\n{},{},0,2,8\n", p, level, 2 + 2 * level, 8 - 2 * level, p, level);
  AnalysisSettings settings{.resamples = 0};
  settings.curve.guess_rate = Rate::free;
  const Analysis a = analyse(answers_of(table), settings);
  EXPECT_EQ(a.tasks.at(0).mixed.at(0).fit.answers, 160U);
  const std::string script = file_named(export_files(a), "analysis.R");
  EXPECT_NE(script.find("answers[answers$signal != \"0\", ]"), std::string::npos);
  EXPECT_NE(script.find(fmt::format(", {}, \"logit\"", a.tasks[0].mixed[0].settings.guess)), std::string::npos)
      << "the rate of guesses to its last digit";
}

// ---- the worst tables

// Every number that is told is one.
void expect_numbers(const Analysis& analysis) {
  const std::string page = analysis_markdown(analysis);
  std::smatch found;
  EXPECT_FALSE(std::regex_search(page, found, std::regex("\\b(nan|inf)\\b"))) << page;
}

TEST(HostileTables, EndInAResultOrOneLine) {
  const auto rows = [](int n, auto&& row) {
    std::string out;
    for (int i = 0; i < n; ++i) out += row(i);
    return out;
  };
  const std::pair<std::string, std::string> cases[] = {
      {"level,answer\n1e308,yes\n-1e308,no\n", "t.csv:2: '1e308' in column 'level'"},
      {"level,answer\n1e-300,yes\n1,no\n", "t.csv:2: '1e-300' in column 'level'"},
      {"level,yes,total\n-1e15,5,10\n0,6,10\n1e15,9,10\n", ""},
      {"level,yes,total\n1,500000000,1000000000\n2,900000000,1000000000\n3,999999999,1000000000\n", ""},
      {"participant,condition,yes,no\n1,a,500000000,500000000\n2,a,500000000,499000000\n1,b,1,1000000000\n2,b,2,1\n",
       ""},
      {"item_a,item_b,yes,no\nx,y,1000000000,1000000000\ny,z,1000000000,1\nx,z,1,1\n", ""},
      {"yes,no\n2000000000,1\n", "t.csv:2: '2000000000' in column 'yes'"},
      {"condition,answer\n" + rows(101, [](int i) { return fmt::format("c{},yes\n", i); }),
       "t.csv: the answers have 101 conditions, and at most 100 are analysed"},
      {"item_a,item_b,answer\n" + rows(51, [](int i) { return fmt::format("i{},i{},a\n", i, i + 1); }),
       "t.csv: the answers have 52 items, and at most 50 are analysed"},
      {"level,answer\n" + rows(501, [](int i) { return fmt::format("{},yes\n", i); }),
       "t.csv: the answers have 501 levels in one condition, and at most 500 are analysed"},
      {"participant,clip,answer\n" + rows(1500, [](int i) { return fmt::format("p{},c{},yes\n", i, i); }),
       "t.csv: the answers have 3000 participants and clips, and at most 2000 are analysed"},
      {"answer,hidden\nyes,2\nno,x\n", "t.csv:3: 'x' in column 'hidden'"},
      {"answer,frames_dropped\nyes,-1\n", "t.csv:2: '-1' in column 'frames_dropped'"},
  };
  for (const auto& [text, says] : cases) {
    SCOPED_TRACE(text.substr(0, 60));
    try {
      const Analysis a = analyse(answers_of(text), {.margin = 0.1, .between = 0.1, .resamples = 20});
      EXPECT_EQ(says, "");
      expect_numbers(a);
    } catch (const Error& error) {
      EXPECT_NE(says, "") << error.what();
      EXPECT_EQ(std::string(error.what()).rfind(says, 0), 0U) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(HostileTables, TestsOfManyTrialsAreThoseOfFew) {
  // Where outcomes are no longer gone through one by one, the p value goes on as before.
  for (const double p0 : {0.5, 0.3, 0.01}) {
    const auto k = static_cast<uint64_t>(100'000 * p0) + 150;
    const double few = binomial_test(k, 100'000, p0).two_sided;
    const double many = binomial_test(k, 100'001, p0).two_sided;
    EXPECT_NEAR(few, many, 0.01 * few + 1e-12) << p0;
  }
  EXPECT_EQ(binomial_test(1'000'000'000, 2'000'000'000, 0.5).two_sided, 1);
  const BinomialTest off = binomial_test(1'000'050'000, 2'000'000'000, 0.5);
  EXPECT_NEAR(off.two_sided, two_sided_normal_p(50'000 / std::sqrt(5e8)), 1e-4);
  EXPECT_NEAR(off.two_sided, 2 * off.greater, 1e-6);
}

TEST(HostileTables, TrialsAreLeftOutByTheirRules) {
  AnalysisSettings settings{.resamples = 0};
  settings.trials = {.shortest_rt_ms = 200, .most_frames_dropped = 3, .hidden = true};
  const Analysis a = analyse(
      answers_of("answer,rt,frames_dropped,hidden\nyes,150,0,0\nyes,250,4,1\nyes,250,3,2\nno,250,3,0\nyes,,,\n"),
      settings);
  EXPECT_EQ(a.left_out.fast, 1U);
  EXPECT_EQ(a.left_out.dropped, 1U);
  EXPECT_EQ(a.left_out.hidden, 1U);
  EXPECT_EQ(a.rows, 2U);
  const std::string page = analysis_markdown(a);
  EXPECT_NE(page.find("Left out, answered within 200 ms: 1 trial."), std::string::npos) << page;
}

TEST(HostileTables, WhoHidesThePageInCatchTrialsHasNotPassedThem) {
  AnalysisSettings settings{.random = RandomEffects::none, .catch_least = 0.5, .resamples = 0};
  settings.trials.hidden = true;
  const Analysis a =
      analyse(answers_of("participant,answer,expected,hidden,catch\n1,upper,upper,1,broken\n1,upper,upper,0,\n"
                         "2,upper,upper,0,broken\n2,upper,lower,0,\n2,upper,lower,1,\n"),
              settings);
  ASSERT_EQ(a.excluded.size(), 1U);
  EXPECT_EQ(a.excluded[0].participant, "1");
  EXPECT_EQ(a.excluded[0].right, 0U);
  EXPECT_EQ(a.catch_rows, 2U);
  EXPECT_EQ(a.left_out.hidden, 1U);
  EXPECT_EQ(a.left_out.hidden_catch, 1U);
  EXPECT_EQ(a.rows, 1U);
  const std::string page = analysis_markdown(a);
  EXPECT_NE(page.find("1 of them, during which the page was out of sight, counts as wrong."), std::string::npos)
      << page;
}

}  // namespace
}  // namespace crowdbench::studies
