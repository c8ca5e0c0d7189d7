// Tune: what it measures of a small character, and what it makes of it.
#include "bench/experiments/tune.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <set>

#include "bench/commands/tune_output.h"
#include "bench/experiments/engine_settings.h"
#include "bench/experiments/switch_distance.h"
#include "bench/experiments/tune_measure.h"
#include "bench/experiments/tune_others.h"
#include "bench/experiments/tune_pictures.h"
#include "bench/experiments/tune_predict.h"
#include "bench/experiments/tune_proof.h"
#include "bench/experiments/tune_report.h"
#include "bench/experiments/tune_rows.h"
#include "bench/experiments/tune_views.h"
#include "core/probability.h"
#include "core/random.h"
#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::bench {
namespace {

TuneSubject mannequin_of(int triangles, std::vector<double> agents_px) {
  TuneSubject subject;
  subject.character = std::make_shared<const scene::Character>(scene::make_mannequin({.triangles = triangles}));
  subject.clip = subject.character->placement.default_clip;
  subject.agents_px = std::move(agents_px);
  return subject;
}

TuneRequest request_of(const char* score, double value) {
  TuneRequest request;
  request.subjects = {mannequin_of(500, {60, 20, 20, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9})};
  request.candidates = {renderers::reference_spec(), renderers::parse_spec("mesh:triangles=100")};
  request.heights_px = {60, 24, 10};
  request.blocks.azimuths_deg = {0, 90};
  request.blocks.elevations_deg = {10};
  request.blocks.moments = 2;
  for (const metrics::Score* one : metrics::scores())
    if (one->name == score) request.error = request.pop = {one, value};
  request.cost.width = 160;
  request.cost.height = 120;
  request.cost.rounds = 4;
  request.cost_heights = 2;
  return request;
}

class TuneGl : public ::testing::Test {
 protected:
  gl::Context context_;
};

TEST_F(TuneGl, WhatMayErrIsDrawnByTheCheaperOneAndWhatMayNotByTheReference) {
  const TuneRequest lax = request_of("mae", 255);
  const TuneResult all = tune(context_, lax);
  ASSERT_TRUE(all.together.plan);
  EXPECT_TRUE(all.alone.empty());
  EXPECT_EQ(all.together.table.agents, (std::vector<double>{1, 2, 10})) << "each in the next bin that is not below it";
  const auto& errors = all.subjects[0].errors;
  ASSERT_EQ(errors.size(), 2U);
  for (size_t bin = 0; bin < 3; ++bin) {
    EXPECT_EQ(errors[0][bin].tail, 0) << "the reference against itself";
    EXPECT_GT(errors[1][bin].tail, 0);
    EXPECT_GE(errors[1][bin].interval.high, errors[1][bin].tail);
    EXPECT_LE(errors[1][bin].interval.low, errors[1][bin].tail);
    EXPECT_EQ(errors[1][bin].promised, errors[1][bin].interval.high);
    EXPECT_EQ(errors[1][bin].values.size(), 4U) << "two directions, two moments";
    const auto& cost = all.together.table.cost;
    EXPECT_EQ(all.together.plan->candidate[bin], cost[1][bin] < cost[0][bin] ? 1U : 0U) << bin;
  }

  const TuneResult none = tune(context_, request_of("mae", 0));
  ASSERT_TRUE(none.together.plan);
  EXPECT_EQ(none.together.plan->candidate, (std::vector<size_t>{0, 0, 0}));
  EXPECT_EQ(none.together.saving.low, 1);
  EXPECT_EQ(none.together.saving.high, 1);
  EXPECT_EQ(tuned_representation(lax, none.together).text(), renderers::reference_spec().text());
}

TEST_F(TuneGl, AThresholdBetweenTheErrorsOfTwoHeightsSwitchesThere) {
  TuneRequest request = request_of("mae", 255);
  const TuneResult errors = tune(context_, request);
  // Errors over the whole crop grow or fall with the height; whichever it is, one height of the two is allowed.
  const double near = errors.subjects[0].errors[1][0].interval.high;
  const double far = errors.subjects[0].errors[1][2].interval.high;
  ASSERT_NE(near, far);
  request.error.value = 0.5 * (near + far);
  request.pop.value = 255;
  const TuneResult result = tune(context_, request);
  ASSERT_TRUE(result.together.plan);
  EXPECT_EQ(result.subjects[0].errors[1][0].allowed, near < far);
  EXPECT_EQ(result.subjects[0].errors[1][2].allowed, far < near);
  // Pictures of a change: the figure before and after it, from the direction in which it shows most.
  TuneAnswer shown = result.together;
  TuneSwitch change;
  change.change = {0, 1, 2};
  change.height_px = 24;
  change.pop.block = 3;
  shown.switches = {change};
  const std::vector<TuneSwitchPictures> pictures = draw_switches(context_, request, shown);
  ASSERT_EQ(pictures.size(), 1U);
  EXPECT_EQ(pictures[0].view.azimuth_deg, 90);
  EXPECT_NEAR(pictures[0].before.height, 24 + 12, 6) << "the figure and its margin";
  EXPECT_EQ(pictures[0].before.width, pictures[0].difference.width);
  EXPECT_NE(pictures[0].before.data, pictures[0].after.data);
  // What is predicted of the candidates: a level's error, nothing of the reference.
  EXPECT_EQ(predict(context_, request, request.subjects[0], request.candidates[0]).error, 0);
  const TunePrediction level = predict(context_, request, request.subjects[0], request.candidates[1]);
  EXPECT_GT(level.error, 0);
  EXPECT_LT(level.error, 0.5);
  EXPECT_EQ(level.texel, 0);
  EXPECT_GT(predict(context_, request, request.subjects[0],
                    renderers::parse_spec(renderers::default_impostor().name + ":views=sphere-4x1,texels=32,frames=1"))
                .texel,
            0);
  // A pop of nothing forbids the change where the pictures differ.
  request.pop.value = 0;
  const TuneResult still = tune(context_, request);
  ASSERT_TRUE(still.together.plan);
  EXPECT_TRUE(still.together.switches.empty());
}

TEST_F(TuneGl, ABudgetTakesTheLeastVisibleSetThatKeepsItInTheScenarioToo) {
  TuneRequest request = request_of("mae", 0);  // a threshold that nothing but the reference keeps
  request.pop.value = 255;
  request.budget_ns = 1e12;
  const TuneResult rich = tune(context_, request);
  ASSERT_TRUE(rich.together.plan);
  EXPECT_EQ(rich.together.plan->candidate, (std::vector<size_t>{0, 0, 0})) << "time enough for no loss at all";
  EXPECT_EQ(rich.together.plan->error, 0);
  EXPECT_FALSE(rich.together.budget->measured_ns);

  request.budget_ns = 1;
  const TuneResult poor = tune(context_, request);
  EXPECT_FALSE(poor.together.plan);
  ASSERT_TRUE(poor.together.budget);
  EXPECT_GT(poor.together.budget->cheapest_ns, 1);

  // The first plan takes ten times the budget in the scenario, so that costs are ten times the table's: what is
  // found then, if anything, is cheaper by the table than a tenth.
  request.budget_ns = 1e9;
  std::vector<std::string> asked;
  request.frame_ns = [&](const renderers::Spec& spec) {
    asked.push_back(spec.text());
    return asked.size() == 1 ? 1e10 : 5e8;
  };
  const TuneResult corrected = tune(context_, request);
  ASSERT_FALSE(asked.empty());
  EXPECT_EQ(asked[0], renderers::reference_spec().text());
  EXPECT_GT(corrected.together.budget->factor, 1);
  if (corrected.together.plan) {
    EXPECT_EQ(asked.size(), 2U);
    EXPECT_EQ(*corrected.together.budget->measured_ns, 5e8);
  }

  // Every plan takes a hair more than there is: the cheapest chain is asked last, and what is said of it is over that.
  asked.clear();
  request.frame_ns = [&](const renderers::Spec& spec) {
    asked.push_back(spec.text());
    return 1.01e9;
  };
  TuneReport report;
  report.result = tune(context_, request);
  EXPECT_FALSE(report.result.together.plan);
  const TuneBudgetAnswer& last = *report.result.together.budget;
  EXPECT_GE(asked.size(), 2U);
  EXPECT_NEAR(last.factor * last.cheapest_ns, 1.01e9, 1);
  report.request = request;
  const std::string text = no_plan_text(report, report.result.together);
  EXPECT_TRUE(text.starts_with("nothing fits in 1000 ms: the cheapest set takes 1010.00 ms")) << text;
}

TEST_F(TuneGl, SeveralCharactersGetARuleEachAndOneThatHoldsForAll) {
  TuneRequest request = request_of("mae", 255);
  request.subjects.push_back(mannequin_of(2200, {50, 8}));
  const TuneResult lax = tune(context_, request);
  ASSERT_EQ(lax.subjects.size(), 2U);
  ASSERT_EQ(lax.alone.size(), 2U);
  EXPECT_EQ(lax.together.table.agents, (std::vector<double>{2, 2, 11}));
  const auto& first = lax.alone[0].table.cost[0];
  const auto& second = lax.alone[1].table.cost[0];
  EXPECT_NEAR(lax.together.table.cost[0][2], (10 * first[2] + second[2]) / 11, 1e-6 * first[2]);
  // Between the characters' own worst: what one of them may, all together may not.
  const double a = lax.subjects[0].errors[1][0].promised;
  const double b = lax.subjects[1].errors[1][0].promised;
  ASSERT_NE(a, b);
  request.error.value = 0.5 * (a + b);
  const TuneResult result = tune(context_, request);
  EXPECT_NE(result.alone[0].table.allowed[1][0], result.alone[1].table.allowed[1][0]);
  EXPECT_FALSE(result.together.table.allowed[1][0]);
  EXPECT_TRUE(result.together.table.allowed[0][0]);
  // With a budget the crowd of all is not held against what one of them may take.
  request.budget_ns = 1e12;
  size_t asked = 0;
  request.frame_ns = [&](const renderers::Spec&) { return static_cast<double>(++asked); };
  const TuneResult within = tune(context_, request);
  EXPECT_EQ(asked, 1U);
  EXPECT_TRUE(within.together.budget->measured_ns);
  EXPECT_FALSE(within.alone[0].budget->measured_ns);
  EXPECT_TRUE(within.alone[0].plan);
}

// The rule in pixels, and the promise of errors, on pictures that were not measured. Everything here is drawn by the
// one other candidate, so that its errors are what is judged.
TEST_F(TuneGl, WhatWasPromisedHoldsThroughOtherLensesAndOnUnseenFigures) {
  TuneRequest request = request_of("mae", 255);
  request.blocks = {.lowest_deg = 0, .highest_deg = 20, .views = 48, .moments = 3};
  request.heights_px = {48, 12};
  request.pop.value = 255;
  TuneResult result = tune(context_, request);
  result.together.plan = SwitchPlan{{1, 1}, 0, 0};
  result.together.switches.clear();
  std::vector<TuneLensCheck> checks = check_lenses(context_, request, result, {{240, 30}, {240, 90}, {60, 30}}, 12);
  ASSERT_EQ(checks.size(), 3U) << "one bin from which another than the reference draws on, three lenses";
  EXPECT_TRUE(checks.back().skipped) << "48 pixels take a picture of more than 60 rows";
  checks.pop_back();
  TuneReport report;
  report.request = request;
  report.result = result;
  report.lenses = checks;
  const std::vector<LensSpread> spreads = lens_spreads(report);
  ASSERT_EQ(spreads.size(), 1U);
  EXPECT_EQ(spreads[0].conditions, 2U);
  EXPECT_TRUE(spreads[0].kept);
  EXPECT_EQ(spreads[0].low, std::min(checks[0].tail, checks[1].tail));
  EXPECT_EQ(spreads[0].tuned, checks[0].tuned_tail);
  for (const TuneLensCheck& check : checks) {
    EXPECT_TRUE(check.holds) << check.lens.rows << " rows, " << check.lens.fov_y_deg << " degrees";
    EXPECT_EQ(check.views, 12U);
  }

  const renderers::Spec spec = tuned_representation(request, result.together);
  EXPECT_EQ(spec.text(), request.candidates[1].text());
  const std::vector<UnseenFigure> figures = draw_unseen(context_, request, request.subjects[0], spec, 40, 5);
  ASSERT_EQ(figures.size(), 40U);
  EXPECT_GT(figures[0].height_px, figures[39].height_px);
  EXPECT_LT(figures[0].height_px, 48);
  EXPECT_GT(figures[39].height_px, 12);
  const auto prove = [&] { return prove_errors(request, result, 0, figures); };
  const ErrorProof proof = prove();
  EXPECT_TRUE(proof.holds) << proof.worse << " of " << proof.views;
  EXPECT_EQ(proof.over_threshold, 0U);
  // A promise that nothing keeps is found out, by both.
  for (TuneError& error : result.subjects[0].errors[1]) error.promised = 0;
  EXPECT_FALSE(prove().holds);
  EXPECT_FALSE(check_lenses(context_, request, result, {{240, 30}}, 12)[0].holds);
}

TEST(TuneProof, SpeedIsPromisedForTheNextSeedAndHeldAgainstIt) {
  std::vector<SeedTimes> seeds(5);
  const double ratios[] = {1.9, 2.0, 2.1, 2.0, 2.0};
  for (size_t i = 0; i < 5; ++i) seeds[i] = {i, ratios[i], {}, 2e6, 1e6};
  const SpeedPromise promise = promised_speed(seeds);
  EXPECT_NEAR(promise.ratio, 2.0, 0.01);
  EXPECT_EQ(promise.plan_ns, 1e6);
  // By hand: the deviation of the logarithms is 0.0354, t(0.975, 4) is 2.776.
  EXPECT_NEAR(promise.on_another_seed.low, promise.ratio * std::exp(-2.776 * 0.0354 * std::sqrt(1.2)), 0.01);
  EXPECT_NEAR(promise.on_another_seed.high, promise.ratio * std::exp(2.776 * 0.0354 * std::sqrt(1.2)), 0.01);

  // Seeds that happen to agree are not believed beyond what the rounds of each leave open: 5 % either way.
  for (SeedTimes& one : seeds) {
    one.ratio = 2;
    one.interval = {2 / 1.05, 2 * 1.05};
  }
  const double open = std::log(1.05) / 1.95996;
  EXPECT_NEAR(promised_speed(seeds).on_another_seed.high, 2 * std::exp(2.776 * open * std::sqrt(1.2)), 1e-3);

  std::vector<SeedTimes> unseen(20, SeedTimes{9, 2.0, {}, 2e6, 1e6});
  for (size_t i = 0; i < 4; ++i) unseen[i].ratio = 1.2;
  EXPECT_TRUE(prove_speed(promise, unseen).holds) << "promises of five seeds are often as narrow as that";
  for (size_t i = 4; i < 12; ++i) unseen[i].ratio = 3;
  const SpeedProof broken = prove_speed(promise, unseen);
  EXPECT_EQ(broken.within, 8U);
  EXPECT_FALSE(broken.holds);

  std::vector<uint64_t> all = derived_seeds(1, SeedsFor::promise, 50);
  const std::vector<uint64_t> proof = derived_seeds(1, SeedsFor::proof, 50);
  all.insert(all.end(), proof.begin(), proof.end());
  EXPECT_EQ(std::set<uint64_t>(all.begin(), all.end()).size(), 100U);
}

TEST(TuneProof, AnIntervalForOneMoreValueByHand) {
  // Mean 3, deviation 1.5811, t(0.975, 4) 2.7764.
  const Interval interval = prediction_interval({1, 2, 3, 4, 5});
  EXPECT_NEAR(interval.low, 3 - 2.7764 * 1.5811 * std::sqrt(1.2), 1e-3);
  EXPECT_NEAR(interval.high, 3 + 2.7764 * 1.5811 * std::sqrt(1.2), 1e-3);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(prediction_interval({1, 2, kInfinite}).high, kInfinite);
  EXPECT_EQ(prediction_interval({1, 2, kInfinite}).low, -kInfinite);
  EXPECT_EQ(prediction_interval({kInfinite, kInfinite}).low, kInfinite) << "equal pictures on every seed";
  EXPECT_TRUE(lies_within({kInfinite, kInfinite}, kInfinite));
  EXPECT_TRUE(lies_within({0.1, 0.1}, 0.3 / 3)) << "rounding is no broken promise";
  EXPECT_FALSE(lies_within({1, 2}, 2.01));
}

const metrics::Score& score_named(const char* name) {
  for (const metrics::Score* one : metrics::scores())
    if (one->name == name) return *one;
  ADD_FAILURE() << name;
  return *metrics::scores()[0];
}

TEST(TuneProof, AScoreIsPromisedForTheNextSeedAndHeldAgainstIt) {
  const metrics::Score& mae = score_named("mae");
  const SeedScores one = scores_of(mae, 7, {{0, 40, 1}, {1, 20, 2}, {3, 10, 6}});
  EXPECT_EQ(one.seed, 7U);
  EXPECT_EQ(one.figures, 3U);
  EXPECT_EQ(one.mean, 3);
  EXPECT_NEAR(one.tail, 2 + 0.9 * 4, 1e-12);
  ASSERT_EQ(one.by_place.size(), 4U);
  EXPECT_EQ(one.by_place[3], 6);
  EXPECT_TRUE(std::isnan(one.by_place[2])) << "a place without a score";
  std::vector<SeedScores> seeds;
  for (const double mean : {1.9, 2.0, 2.1, 2.0, 2.0}) seeds.push_back({1, 24, mean, 3, {}});
  const ScorePromise promise = promised_score(mae, seeds);
  EXPECT_NEAR(promise.mean, 2, 1e-12);
  EXPECT_NEAR(promise.on_another_seed.low, 2 - 2.7764 * 0.0707 * std::sqrt(1.2), 1e-3);
  // A score that is better than the best is promised by nobody.
  seeds[0].mean = 0;
  seeds[2].mean = 0;
  EXPECT_EQ(promised_score(mae, seeds).on_another_seed.low, metrics::best_value(mae));
  std::vector<SeedScores> unseen(20, SeedScores{2, 24, 2.05, 3, {}});
  EXPECT_TRUE(prove_score(promise, unseen).holds);
  for (size_t i = 0; i < 12; ++i) unseen[i].mean = 4;
  const ScoreProof broken = prove_score(promise, unseen);
  EXPECT_EQ(broken.within, 8U);
  EXPECT_FALSE(broken.holds);
}

// Figures of a seed, of which near ones err more and differ more.
SeedScores seed_of_figures(uint64_t seed) {
  std::vector<UnseenFigure> figures;
  for (size_t p = 0; p < kSeedFigures; ++p) {
    const double place = static_cast<double>(p) / kSeedFigures;
    const double off = normal_quantile(std::max(1e-9, random_unit(seed, p, 5)));
    figures.push_back({p, 40 - 30 * place, 20 - 8 * place + (4 - 3 * place) * off});
  }
  return scores_of(score_named("mae"), seed, figures);
}

TEST(TuneProof, AScoresIntervalIsFromItsFiguresByHand) {
  // Two places, three seeds: variances 1 and 4, of the mean (1 + 4) / 4; 25 / (17 / 2) degrees; t(0.975, 2.941) 3.217.
  std::vector<SeedScores> seeds;
  for (const double off : {-1.0, 0.0, 1.0}) seeds.push_back({1, 2, 15 + 1.5 * off, 20, {10 + off, 20 + 2 * off}});
  const ScorePromise promise = promised_score(score_named("mae"), seeds);
  EXPECT_NEAR(promise.degrees, 25 / 8.5, 1e-12);
  const double half = student_t_quantile(0.975, 25 / 8.5) * std::sqrt(1.25 * 4 / 3);
  EXPECT_NEAR(promise.on_another_seed.low, 15 - half, 1e-9);
  EXPECT_NEAR(promise.on_another_seed.high, 15 + half, 1e-9);
  EXPECT_NEAR(student_t_quantile(0.975, 25 / 8.5), 3.217, 0.005);
}

// As often as it says, and seldom much less often for one promise: that is what the figures are for.
TEST(TuneProof, AScoresIntervalHoldsOnNineteenSeedsOfTwenty) {
  constexpr uint64_t kPromises = 400;
  double variance = 0;  // of a seed's mean
  double centre = 0;
  for (size_t p = 0; p < kSeedFigures; ++p) {
    const double place = static_cast<double>(p) / kSeedFigures;
    centre += (20 - 8 * place) / kSeedFigures;
    variance += (4 - 3 * place) * (4 - 3 * place) / (kSeedFigures * kSeedFigures);
  }
  double sum = 0;
  size_t poor = 0;
  for (uint64_t i = 0; i < kPromises; ++i) {
    std::vector<SeedScores> seeds;
    for (uint64_t k = 0; k < kPromiseSeeds; ++k) seeds.push_back(seed_of_figures(1000 + i * kPromiseSeeds + k));
    const Interval of = promised_score(score_named("mae"), seeds).on_another_seed;
    const double covered =
        normal_cdf((of.high - centre) / std::sqrt(variance)) - normal_cdf((of.low - centre) / std::sqrt(variance));
    sum += covered;
    poor += covered < 0.8;
  }
  EXPECT_NEAR(sum / kPromises, 0.95, 0.01);
  EXPECT_LE(poor, kPromises / 50) << "from the five means alone it is 8 %";
}

CharacterDrawn drawn_of(double ratio, double mean, double tail) {
  CharacterDrawn out;
  out.ratio = ratio;
  out.mean = mean;
  out.tail = tail;
  return out;
}

TEST(TuneOthers, ANewCharacterIsPromisedTheSpreadOfThoseLeftOut) {
  const metrics::Score& mae = score_named("mae");
  const OthersPromise promise = promised_of_others(mae, {drawn_of(1, 1, 2), drawn_of(2, 2, 3), drawn_of(4, 3, 4)});
  EXPECT_NEAR(promise.ratio, 2, 1e-12);
  // Logarithms of base 2: mean 1, deviation 1; t(0.975, 2) is 4.3027.
  const double half = 4.3027 * std::sqrt(4.0 / 3);
  EXPECT_NEAR(std::log2(promise.ratio_of_another.high), 1 + half, 1e-3);
  EXPECT_NEAR(std::log2(promise.ratio_of_another.low), 1 - half, 1e-3);
  EXPECT_NEAR(promise.mean_of_another.high, 2 + half, 1e-3);
  EXPECT_EQ(promise.mean_of_another.low, 0) << "no better than the best";
  EXPECT_TRUE(prove_other(promise, drawn_of(8, 1, 2)).holds());
  EXPECT_FALSE(prove_other(promise, drawn_of(100, 1, 2)).holds());
  EXPECT_FALSE(prove_other(promise, drawn_of(8, 9, 2)).mean_within);
  EXPECT_FALSE(prove_other(promise, drawn_of(8, 1, 9)).tail_within);

  TuneRequest request;
  request.subjects.resize(2);
  EXPECT_EQ(no_promise_of_others(request),
            "two characters were tuned, and what differs between characters is known from 3 on");
  request.subjects.resize(3);
  EXPECT_EQ(no_promise_of_others(request), "");
  request.budget_ns = 1e6;
  EXPECT_NE(no_promise_of_others(request), "");
}

// Characters of one normal distribution: so many are within as was stated, whatever the number that was tuned.
TEST(TuneOthers, CoversAsManyNewCharactersAsItSays) {
  const metrics::Score& score = score_named("mae");
  constexpr uint64_t kTrials = 3000;
  uint64_t draw = 0;
  const auto normal = [&] { return normal_quantile(std::max(1e-9, random_unit(13, draw++, 3))); };
  const auto one = [&] { return drawn_of(std::exp(0.4 * normal()), 20 + normal(), 30 + 2 * normal()); };
  for (const size_t tuned : {3U, 6U}) {
    uint64_t ratio = 0, mean = 0, tail = 0;
    for (uint64_t trial = 0; trial < kTrials; ++trial) {
      std::vector<CharacterDrawn> some;
      for (size_t i = 0; i < tuned; ++i) some.push_back(one());
      const OtherProof proof = prove_other(promised_of_others(score, some), one());
      ratio += proof.ratio_within;
      mean += proof.mean_within;
      tail += proof.tail_within;
    }
    for (const uint64_t within : {ratio, mean, tail}) {
      EXPECT_GE(within, binomial_limits(kTrials, 0.95).low) << tuned;
      EXPECT_LE(within, binomial_limits(kTrials, 0.95).high) << tuned;
    }
  }
}

// Three characters: the rule of every two is sought too, and drawn on the third.
TEST_F(TuneGl, OfThreeCharactersEachIsLeftOutOnce) {
  TuneRequest request = request_of("mae", 255);
  request.subjects.push_back(mannequin_of(2200, {50, 8}));
  EXPECT_TRUE(tune(context_, request).left_out.empty());
  request.subjects.push_back(mannequin_of(5000, {30}));
  const TuneResult result = tune(context_, request);
  ASSERT_EQ(result.left_out.size(), 3U);
  EXPECT_EQ(result.together.table.agents, (std::vector<double>{3, 2, 11}));
  EXPECT_EQ(result.left_out[0].table.agents, (std::vector<double>{2, 0, 1}));
  EXPECT_EQ(result.left_out[2].table.agents, (std::vector<double>{2, 2, 11}));
  for (const TuneAnswer& answer : result.left_out) EXPECT_TRUE(answer.plan);
}

TEST(TuneHysteresis, IsHalfTheIntervalAndNoMoreThanWhatDrawsTakes) {
  EXPECT_NEAR(hysteresis_of({10, 14.4}), 0.2, 1e-12);
  EXPECT_EQ(hysteresis_of({8, 8}), 0);
  TuneAnswer answer;
  answer.plan = SwitchPlan{{0, 1}, 0, 0};
  TuneSwitch one;
  one.change = {0, 1, 1};
  one.height_px = 24;
  one.hysteresis = hysteresis_of({8, 80});
  answer.switches = {one};
  EXPECT_NO_THROW(renderers::parse_spec(tuned_representation(request_of("mae", 1), answer).text()));
  EXPECT_EQ(one.hysteresis, 1);
}

// True promises of five seeds are refused in 2.5 % of proofs at most, and nearly as often.
TEST(TuneProof, RefusesTruePromisesAsSeldomAsItSays) {
  constexpr uint64_t kTrials = 4000;
  uint64_t draw = 0;
  const auto ratio = [&] { return std::exp(0.1 * normal_quantile(std::max(1e-9, random_unit(11, draw++, 3)))); };
  for (const size_t unseen : {5U, 20U}) {
    size_t least = unseen / 3;
    ASSERT_LT(chance_of_so_few(least, unseen, 5, 4), 0.025);
    while (chance_of_so_few(least, unseen, 5, 4) < 0.025) ++least;
    uint64_t refused = 0;
    for (uint64_t trial = 0; trial < kTrials; ++trial) {
      std::vector<SeedTimes> seeds(5);
      for (SeedTimes& one : seeds) one.ratio = ratio();
      const Interval promised = promised_speed(seeds).on_another_seed;
      size_t within = 0;
      for (size_t i = 0; i < unseen; ++i) {
        const double one = ratio();
        within += one >= promised.low && one <= promised.high;
      }
      refused += within < least;
    }
    EXPECT_LE(refused, binomial_limits(kTrials, 0.025).high) << unseen;
    EXPECT_GE(refused, kTrials / 200) << unseen << ": and not for want of ever refusing";
  }
}

// Over many samples of a known distribution the interval's upper end is below its 95th percentile in 2.5 % at most.
TEST(TailInterval, BoundsThePercentileAsOftenAsItSays) {
  constexpr int kTrials = 2000;
  int above = 0;
  int below = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values;
    for (size_t i = 0; i < kTailValues; ++i)
      values.push_back(random_unit(7, static_cast<uint64_t>(trial) * kTailValues + i, 3));
    const Interval interval = tail_interval(values);
    above += interval.low > 0.95;
    below += interval.high < 0.95;
  }
  EXPECT_LE(below, binomial_limits(kTrials, 0.025).high);
  EXPECT_LE(above, binomial_limits(kTrials, 0.025).high);
  EXPECT_GE(below, binomial_limits(kTrials, 0.02).low) << "and is no wider than it needs to be";
  const Interval few = tail_interval({1, 5, 3});
  EXPECT_EQ(few.high, 5) << "the largest stands for what so few do not bound";
}

TEST(TuneViews, NoPictureIsCountedTwice) {
  TuneSubject subject = mannequin_of(500, {});
  const TuneBlocks blocks{.azimuths_deg = {0, 90, 180}, .elevations_deg = {0}, .moments = 12};
  EXPECT_EQ(tune_views(blocks, subject, 1).size(), 36U);
  subject.clip = -1;
  EXPECT_EQ(tune_views(blocks, subject, 1).size(), 3U) << "a bind pose has one moment";
}

TEST(TuneError, InfiniteScoresComeBackInfinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const metrics::Score& psnr = *request_of("psnr", 40).error.score;
  ASSERT_EQ(metrics::best_value(psnr), kInfinity);
  const double equal = badness_of(psnr, kInfinity);
  EXPECT_EQ(value_of_badness(psnr, equal), kInfinity);
  EXPECT_EQ(value_of_badness(psnr, (equal + badness_of(psnr, 40)) / 2), kInfinity) << "a mean with an infinite one";
  EXPECT_EQ(value_of_badness(psnr, badness_of(psnr, 40)), 40);
}

TEST(TunedRepresentation, NestsSwitchesByHeight) {
  TuneRequest request = request_of("mae", 1);
  request.candidates.push_back(renderers::parse_spec("rigid"));
  request.fade = 4;
  TuneAnswer result;
  result.plan = SwitchPlan{{0, 1, 2}, 0, 0};
  result.switches = {{.change = {0, 1, 1}, .height_px = 24},
                     {.change = {1, 2, 2}, .height_px = 10, .hysteresis = 0.25}};
  const renderers::Spec spec = tuned_representation(request, result);
  EXPECT_EQ(spec.text(),
            renderers::parse_spec("hybrid(mesh,hybrid((mesh:triangles=100),rigid,height=10,hysteresis=0.25,fade=4),"
                                  "height=24,fade=4)")
                .text());
}

TEST(TunedRepresentation, EnginesUnitsComeBackAsTheSameHeight) {
  const double fov = 35 * std::numbers::pi / 180;
  const glm::dvec3 bounds(0.8, 1.8, 0.6);
  for (const double height_px : {8.0, 60.0, 300.0}) {
    const double depth = depth_of_height(1.75, height_px, 720, fov);
    const EngineSizes sizes = engine_sizes(bounds, depth, fov, 16.0 / 9);
    const auto height_at = [&](double distance) { return 1.75 * 720 / (distance * 2 * std::tan(fov / 2)); };
    EXPECT_NEAR(height_at(sizes.godot_metres), height_px, 1e-9);
    EXPECT_NEAR(height_at(1.8 / (sizes.unity_height * 2 * std::tan(fov / 2))), height_px, 1e-9);
    const double radius = glm::length(bounds) / 2;
    const double widest = 1 / std::tan(fov / 2);  // P11; P00 is less in a picture wider than tall
    EXPECT_NEAR(height_at(widest * radius / sizes.unreal_size), height_px, 1e-9);
  }
}

// Unity's culling and Godot's, as engine_settings.h states them, written out once more.
TEST(EngineSettings, MeshLodAndPixelThresholdSwitchWhereTheRuleDoes) {
  const double fov = 35 * std::numbers::pi / 180;
  const glm::dvec3 bounds(0.8, 1.8, 0.6);
  const double depths[] = {4, 9, 25};
  const auto sphere = [&](double depth) { return sphere_pixels(bounds, depth, 720, fov); };
  EXPECT_NEAR(sphere(4), std::sqrt(0.64 + 3.24 + 0.36) * 720 / (8 * std::tan(fov / 2)), 1e-9);
  const auto level = [&](const MeshLodCurve& curve, double depth, double threshold) {
    const double height_at = threshold * 2 * std::tan(fov / 2) / 720 * depth;  // of `threshold` pixels, metres
    return std::max(0.0, std::log2(height_at / glm::length(bounds)) * curve.slope + curve.bias);
  };
  const auto one = mesh_lod_curve(std::vector<double>{sphere(4)});
  ASSERT_TRUE(one);
  EXPECT_NEAR(level(*one, 4, 1), 1, 1e-9);
  EXPECT_LT(level(*one, 3.99, 1), 1);
  const auto two = mesh_lod_curve(std::vector<double>{sphere(4), sphere(9)});
  ASSERT_TRUE(two);
  EXPECT_NEAR(level(*two, 4, 1), 1, 1e-9);
  EXPECT_NEAR(level(*two, 9, 1), 2, 1e-9);
  EXPECT_NEAR(mesh_lod_begins(*two, 2), sphere(9), 1e-6);
  EXPECT_NEAR(mesh_lod_level(*two, sphere(9), 2), level(*two, 9, 2), 1e-9);
  const auto three = mesh_lod_curve(std::vector<double>{sphere(4), sphere(9), sphere(25)});
  ASSERT_TRUE(three);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(level(*three, depths[i], 1), static_cast<double>(i + 1), 0.1);
  EXPECT_FALSE(mesh_lod_curve({}));
  EXPECT_FALSE(mesh_lod_curve(std::vector<double>{10, 20})) << "levels begin ever farther away";

  // At the threshold's distance the error spans just so many pixels of the box's nearest point.
  const double threshold = godot_threshold_pixels(0.01, bounds, 9, 720, fov);
  EXPECT_NEAR(threshold * 2 * std::tan(fov / 2) / 720 * (9 - 0.3), 0.01, 1e-12);
  EXPECT_NEAR(godot_lod_distance(0.01, bounds, threshold, 720, fov), 9, 1e-9);
}

// A report with one switch to a mesh of 100 triangles, of which nothing was drawn.
TuneReport made_up_report() {
  TuneReport report;
  report.request = request_of("mae", 10);
  report.run.gl_renderer = "a pencil";
  report.run.software = true;
  report.bounds = {glm::dvec3(0.8, 1.8, 0.6)};
  report.request.cost.fov_y = 0.6;
  report.crowd = 20;
  TuneMeasured measured;
  measured.views = 4;
  measured.refused = {"", ""};
  measured.errors.assign(2, std::vector<TuneError>(3));
  for (size_t b = 0; b < 3; ++b) {
    measured.errors[0][b] = {{0, 0, 0, 0}, 0, 0, {0, 0}, 0, true};
    const double tail = 12 - 2.0 * static_cast<double>(b);
    measured.errors[1][b] = {{tail, 1, 2, 3}, 2, tail, {tail - 1, tail + 1}, tail + 1, tail + 1 <= 10};
  }
  measured.cost_heights_px = {60, 10};
  measured.costs.clock = "cpu";
  measured.costs.agents = {4, 4};
  measured.costs.costs.assign(2, std::vector<AgentCost>(2));
  for (AgentCost& cost : measured.costs.costs[0]) cost = {4000, {3900, 4100}, true, {}};
  for (AgentCost& cost : measured.costs.costs[1]) cost = {1000, {900, 1100}, true, {}};
  measured.table = {
      {{4000, 4000, 4000}, {1000, 1000, 1000}}, {{0, 0, 0}, {2, 2, 2}}, {{1, 1, 1}, {0, 0, 1}}, {1, 2, 10}};
  report.result.subjects = {measured};
  TuneAnswer& answer = report.result.together;
  answer.table = measured.table;
  answer.plan = SwitchPlan{{0, 0, 1}, 22000, 20};
  answer.reference_cost = 52000;
  answer.saving = {2, 2.5};
  TuneSwitch one;
  one.change = {0, 1, 2};
  one.height_px = 10;
  one.certainty = {0.975, Interval{9, 12}};
  one.pop = {3.5, true, 0, 0, 4};
  one.hysteresis = 0.15;
  answer.switches = {one};
  const double height = report.request.subjects[0].character->placement.height;
  report.predicted = {{{}, {0, height / 20}}};  // an error of one pixel at 20 pixels
  return report;
}

TEST(TuneReport, HoldsRulesOfThumbAgainstWhatWasMeasured) {
  const TuneReport report = made_up_report();
  const std::vector<PredictedSwitch> rules = predicted_switches(report, 0, 1, 10);
  ASSERT_EQ(rules.size(), 1U) << "a mesh has no texels";
  EXPECT_STREQ(rules[0].rule, "an error of one pixel");
  EXPECT_NEAR(rules[0].height_px, 20, 1e-9);
  EXPECT_NEAR(rules[0].pixels, 0.5, 1e-9);
  EXPECT_EQ(rules[0].error->tail, 10) << "24 pixels is the height that figures of 20 are drawn by";
  EXPECT_FALSE(rules[0].beyond);
  EXPECT_NE(predicted_text(report, rules[0]).find("11.00 or less, 10 was asked for: NOT enough; 1.00 us"),
            std::string::npos)
      << predicted_text(report, rules[0]);
  EXPECT_NE(times_text(report).find("cpu time of a pencil (a software rasteriser: nothing here says how long"),
            std::string::npos);
  ASSERT_EQ(mesh_switches(report, report.result.together), 1U);
  const auto curve = mesh_lod_in_report(report, 0, report.result.together);
  ASSERT_TRUE(curve);
  EXPECT_NEAR(mesh_lod_begins(*curve, 1),
              glm::length(report.bounds[0]) / report.request.subjects[0].character->placement.height * 10, 1e-6);
  const auto pixels = godot_pixels_in_report(report, 0, report.result.together.switches[0]);
  ASSERT_TRUE(pixels);
  EXPECT_NEAR(*pixels, 0.5, 0.01) << "the box's front is a little nearer than its middle";
}

// What no switch leads to is held beside its rules of thumb, too: with and without a plan.
TEST(TuneReport, HoldsRulesOfThumbBesideWhatWasNotChosen) {
  TuneReport report = made_up_report();
  EXPECT_TRUE(unchosen_candidates(report, 0, report.result.together).empty()) << "the mesh has no rule of thumb";
  report.result.together.switches.clear();
  std::vector<UnchosenCandidate> left = unchosen_candidates(report, 0, report.result.together);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].candidate, 1U);
  EXPECT_EQ(left[0].kept_px, 10) << "11, the bad end of the interval at 24 pixels, is more than 10";
  ASSERT_EQ(left[0].rules.size(), 1U);
  EXPECT_NEAR(left[0].rules[0].height_px, 20, 1e-9);
  EXPECT_NE(unchosen_text(report, 0, left[0]).find("keeps the threshold by itself from 10.0 pixels"),
            std::string::npos);
  const Json out = tune_json(report);
  EXPECT_EQ(out.at("not_chosen").elements().size(), 1U);
  EXPECT_EQ(out.at("characters").elements()[0].at("tail_bounded").dump(), "false");
  EXPECT_NE(tune_page_of(report).find("(not in the rule)"), std::string::npos);
  EXPECT_NE(tune_page_of(report).find("Fewer than 72 views bound no tail"), std::string::npos);
  report.result.together.plan.reset();
  for (TuneError& error : report.result.subjects[0].errors[1]) error.allowed = false;
  left = unchosen_candidates(report, 0, report.result.together);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].kept_px, std::nullopt);
  EXPECT_NE(unchosen_text(report, 0, left[0]).find("does not keep the threshold even at"), std::string::npos);
  EXPECT_EQ(few_views_text(72), "");
}

TEST(TuneReport, SaysOfEveryLensWhetherTheRuleIsKeptAndLiesWithinItsInterval) {
  TuneReport report = made_up_report();
  TuneLensCheck check;
  check.bin = 2;
  check.candidate = 1;
  check.views = 24;
  check.tuned_tail = 8;
  check.holds = true;
  check.tail = 7.5;
  report.lenses = {check, check, check};
  (*report.lenses)[1].tail = 8.5;
  (*report.lenses)[2].skipped = true;
  std::vector<LensSpread> spreads = lens_spreads(report);
  ASSERT_EQ(spreads.size(), 1U);
  EXPECT_EQ(spreads[0].conditions, 2U);
  EXPECT_EQ(spreads[0].skipped, 1U);
  EXPECT_EQ(spreads[0].low, 7.5);
  EXPECT_EQ(spreads[0].high, 8.5);
  EXPECT_TRUE(spreads[0].kept && spreads[0].within);
  // The errors of the neighbours: 10 at 24 pixels, 8 at 10.
  ASSERT_TRUE(spreads[0].height_px);
  const double slope = 2 / std::log(2.4);
  EXPECT_NEAR(spreads[0].height_px->low, 10 * std::exp(-0.5 / slope), 1e-9);
  EXPECT_NEAR(spreads[0].height_px->high, 10 * std::exp(0.5 / slope), 1e-9);
  EXPECT_NE(lens_verdict(spreads).find("holds at every resolution"), std::string::npos);

  (*report.lenses)[1].tail = 9.5;  // beyond the interval, 7 to 9, though few enough views are worse
  spreads = lens_spreads(report);
  EXPECT_TRUE(spreads[0].kept);
  EXPECT_FALSE(spreads[0].within);
  EXPECT_NE(lens_verdict(spreads).find("keeps its promise"), std::string::npos);
  (*report.lenses)[1].holds = false;
  spreads = lens_spreads(report);
  EXPECT_FALSE(spreads[0].kept);
  EXPECT_NE(lens_verdict(spreads).find("does NOT hold"), std::string::npos);
  EXPECT_NE(lens_text(report, spreads[0]).find("the promise is NOT kept"), std::string::npos);
}

TEST(TuneRows, AreTheRuleAndEveryScore) {
  TuneReport report = made_up_report();
  StoreContents rows = tune_rows(report, 7);
  EXPECT_EQ(rows.comparisons.size(), 3U * 4) << "three heights, two directions, two moments; the reference is no row";
  EXPECT_EQ(rows.comparisons[8].height_px, 10);
  EXPECT_EQ(rows.comparisons[8].scores[0].value, 8);
  ASSERT_EQ(rows.tunings.size(), 1U);
  const TuningRow& row = rows.tunings[0];
  EXPECT_EQ(row.run, 7);
  EXPECT_EQ(row.representation, tuned_representation(report.request, report.result.together).text());
  EXPECT_NEAR(row.saving.value(), 52.0 / 22, 1e-9);
  EXPECT_EQ(row.promised, std::nullopt);
  EXPECT_EQ(row.lenses_hold, std::nullopt);
  ASSERT_EQ(row.switches.size(), 1U);
  EXPECT_EQ(row.switches[0].height_px, 10);
  EXPECT_EQ(row.switches[0].low_px, 9);
  EXPECT_TRUE(row.switches[0].decided);
  EXPECT_EQ(row.switches[0].pixels_per_texel, std::nullopt);
  EXPECT_NEAR(row.switches[0].pixels_per_error.value(), 0.5, 1e-9);
  EXPECT_EQ(row.switches[0].pop, 3.5);
  report.result.together.plan.reset();
  report.result.together.switches.clear();
  rows = tune_rows(report);
  EXPECT_EQ(rows.tunings[0].representation, std::nullopt);
  EXPECT_FALSE(rows.tunings[0].reason.empty());
}

TEST(SwitchCost, IsStraightInLogarithmsBetweenHeightsAndConstantBeyond) {
  std::vector<AgentCost> costs(2);
  costs[0].ns = 400;
  costs[1].ns = 100;
  const std::vector<double> at = costs_at({80, 20}, costs, {160, 80, 40, 20, 10});
  EXPECT_EQ(at[0], 400);
  EXPECT_EQ(at[1], 400);
  EXPECT_NEAR(at[2], 200, 1e-9);
  EXPECT_NEAR(at[3], 100, 1e-9);
  EXPECT_EQ(at[4], 100);
}

}  // namespace
}  // namespace crowdbench::bench
