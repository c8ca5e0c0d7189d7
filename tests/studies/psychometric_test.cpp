// Psychometric functions: by hand, against maximum likelihood by other programs, and where there is no threshold.
#include "studies/analysis/psychometric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "studies/analysis/optimise.h"
#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;

std::vector<Level> levels_of(const Expected& data) {
  std::vector<Level> out;
  for (const Expected& d : data)
    out.push_back({d.at("x").get<double>(), d.at("k").get<uint64_t>(), d.at("n").get<uint64_t>()});
  return out;
}

// Near within a fraction; both finite.
void expect_part(std::optional<double> got, const Expected& expected, double part, const char* what) {
  if (expected.is_null()) return;
  ASSERT_TRUE(got) << what;
  EXPECT_NEAR(*got / expected.get<double>(), 1, part) << what;
}

// Of a logistic curve without slips, by the derivatives on paper: the observed information of location and scale,
// inverted.
std::pair<double, double> standard_errors_by_hand(const std::vector<Level>& levels, const CurveParameters& p) {
  double ll = 0;
  double ls = 0;
  double ss = 0;
  for (const Level& level : levels) {
    const double z = (level.x - p.location) / p.scale;
    const double f = 1 / (1 + std::exp(-z));
    const double y = p.guess + (1 - p.guess) * f;
    const double slope = (1 - p.guess) * f * (1 - f);
    const double bend = slope * (1 - 2 * f);
    const auto yes = static_cast<double>(level.yes);
    const auto no = static_cast<double>(level.of - level.yes);
    const double first = (yes / y - no / (1 - y)) * slope;
    const double second =
        yes * (bend / y - slope * slope / (y * y)) - no * (bend / (1 - y) + slope * slope / ((1 - y) * (1 - y)));
    const double s2 = p.scale * p.scale;
    ll -= second / s2;
    ls -= second * z / s2 + first / s2;
    ss -= second * z * z / s2 + first * 2 * z / s2;
  }
  const double determinant = ll * ss - ls * ls;
  return {std::sqrt(ss / determinant), std::sqrt(ll / determinant)};
}

void expect_fit(const CurveFit& fit, const Expected& e, double x_range) {
  // Never above the reference by more than the tolerance; below is welcome.
  EXPECT_LT(fit.negative_log_likelihood, e.at("neg_log_lik").get<double>() + 1e-4);
  EXPECT_LT(fit.deviance, e.at("deviance").get<double>() + 2e-4);
  // A step has no place: only the likelihood can be compared.
  const bool step = e.at("profile_ci95_location")[0].is_null() && e.at("profile_ci95_location")[1].is_null();
  if (!e.at("agree").get<bool>() || step) return;
  EXPECT_NEAR(fit.negative_log_likelihood, e.at("neg_log_lik").get<double>(), 1e-4);
  expect_part(fit.at.location, e.at("location"), 1e-3, "location");
  expect_part(fit.at.scale, e.at("scale"), 1e-3, "scale");
  expect_part(fit.threshold, e.at("x_at_p75"), 1e-3, "x at 75 %");
  const Expected& profile = e.at("profile_ci95_location");
  for (const auto& [got, i] : {std::pair(fit.location_profile.low, 0U), std::pair(fit.location_profile.high, 1U)}) {
    if (profile[i].is_null()) continue;
    ASSERT_TRUE(got);
    // Of the value, or of the range of levels where the value is next to 0.
    EXPECT_NEAR(*got, profile[i].get<double>(), 5e-3 * std::max(std::fabs(profile[i].get<double>()), x_range)) << i;
  }
  ASSERT_TRUE(fit.threshold_profile.low.value_or(-1e9) <= *fit.threshold);
  ASSERT_TRUE(fit.threshold_profile.high.value_or(1e9) >= *fit.threshold);
}

// The file holds a lapse rate that was fitted for known; ours does not, and is never the smaller.
void expect_errors(const CurveFit& fit, const std::vector<Level>& levels, CurveSettings settings, const Expected& e) {
  if (fit.state != CurveState::fitted || !e.at("agree").get<bool>()) return;
  if (settings.lapse_rate == Rate::free) {
    settings.lapse_rate = Rate::fixed;
    settings.lapse = fit.at.lapse;
    const CurveFit held = fit_curve(levels, settings);
    if (fit.location_se && held.location_se) {
      EXPECT_GE(*fit.location_se, *held.location_se * (1 - 1e-3));
    }
    return expect_errors(held, levels, settings, e);
  }
  if (settings.curve == Curve::logistic && fit.at.lapse == 0) {
    const auto [location, scale] = standard_errors_by_hand(levels, fit.at);
    EXPECT_NEAR(fit.location_se.value() / location, 1, 1e-3);
    EXPECT_NEAR(fit.scale_se.value() / scale, 1, 1e-3);
  }
  expect_part(fit.location_se, e.at("se_location_obs_info"), 1e-2, "standard error of the location");
  // By differences too coarse for a scale of 8e-4: 1.4 % from the exact information, by which it was judged above.
  const bool coarse = settings.curve == Curve::logistic && fit.at.lapse == 0 && fit.at.scale < 1e-3;
  if (!coarse) expect_part(fit.scale_se, e.at("se_scale_obs_info"), 1e-2, "standard error of the scale");
}

TEST(Psychometric, MaximumLikelihoodIsThatOfOtherPrograms) {
  const Expected& expected = test::studies_expected();
  size_t fits = 0;
  for (const auto& [name, c] : expected.at("psychometric").items()) {
    const std::vector<Level> levels = levels_of(c.at("data"));
    for (const Expected& e : c.at("ml_fits")) {
      SCOPED_TRACE(name + ", " + e.at("model").get<std::string>() + ", lapse " + e.at("lambda_mode").dump());
      CurveSettings settings{.curve = curve_named(e.at("model").get<std::string>()).value(),
                             .guess = c.at("gamma").get<double>(),
                             .lapse_rate = Rate::fixed};
      if (e.at("lambda_mode") == "free")
        settings.lapse_rate = Rate::free;
      else
        settings.lapse = e.at("lambda_mode").get<double>();
      const CurveFit fit = fit_curve(levels, settings);
      expect_fit(fit, e, levels.back().x - levels.front().x);
      expect_errors(fit, levels, settings, e);
      ++fits;
    }
  }
  EXPECT_GE(fits, 18U);
}

TEST(Psychometric, CurvesByHand) {
  const CurveParameters p{.location = 2, .scale = 0.5, .guess = 0.5, .lapse = 0.1};
  EXPECT_NEAR(psi(Curve::logistic, false, p, 2), 0.5 + 0.4 * 0.5, 1e-15);
  EXPECT_NEAR(psi(Curve::cumulative_gaussian, false, p, 2.5), 0.5 + 0.4 * 0.8413447460685429, 1e-12);
  EXPECT_NEAR(psi(Curve::weibull, false, p, 2), 0.5 + 0.4 * (1 - std::exp(-1)), 1e-12);
  EXPECT_NEAR(psi(Curve::logistic, true, p, 100), 0.5, 1e-12);
  for (const Curve kind : {Curve::logistic, Curve::cumulative_gaussian, Curve::weibull})
    for (const bool falling : {false, true}) {
      const auto x = x_at(kind, falling, p, 0.75);
      ASSERT_TRUE(x);
      EXPECT_NEAR(psi(kind, falling, p, *x), 0.75, 1e-12);
      EXPECT_FALSE(x_at(kind, falling, p, 0.95));
      EXPECT_FALSE(x_at(kind, falling, p, 0.4));
    }
}

// The mirror image of data has the mirror image of the fit.
TEST(Psychometric, FallingIsRisingFromTheOtherSide) {
  const std::vector<Level> rising = {{-3, 11, 20}, {-2, 10, 20}, {-1, 14, 20}, {0, 17, 20}, {1, 20, 20}};
  std::vector<Level> falling = rising;
  for (Level& level : falling) level.x = -level.x;
  CurveSettings settings;
  const CurveFit up = fit_curve(rising, settings);
  settings.falling = true;
  const CurveFit down = fit_curve(falling, settings);
  ASSERT_EQ(up.state, CurveState::fitted);
  ASSERT_EQ(down.state, CurveState::fitted);
  EXPECT_NEAR(*up.threshold, -*down.threshold, 1e-5);
  EXPECT_NEAR(up.negative_log_likelihood, down.negative_log_likelihood, 1e-8);
  ASSERT_TRUE(up.threshold_profile.high && down.threshold_profile.low);
  EXPECT_NEAR(*up.threshold_profile.high, -*down.threshold_profile.low, 1e-3);
}

TEST(Psychometric, SaysWhatHasNoThreshold) {
  const CurveSettings settings;
  const auto state = [&](std::vector<Level> levels) { return fit_curve(levels, settings).state; };
  EXPECT_EQ(state({}), CurveState::no_data);
  EXPECT_EQ(state({{1, 0, 0}}), CurveState::no_data);
  EXPECT_EQ(state({{1, 7, 10}, {1, 9, 10}}), CurveState::one_level);
  EXPECT_EQ(state({{1, 10, 10}, {2, 10, 10}}), CurveState::all_alike);
  EXPECT_EQ(state({{1, 0, 10}, {2, 0, 10}}), CurveState::all_alike);
  // Better where it should be worse.
  EXPECT_NE(state({{1, 19, 20}, {2, 15, 20}, {3, 10, 20}}), CurveState::fitted);
  EXPECT_EQ(state({{1, 10, 20}, {2, 10, 20}, {3, 20, 20}, {4, 20, 20}}), CurveState::step);
  EXPECT_EQ(state_text(CurveState::step), "a step between two levels");
}

TEST(Psychometric, BootstrapHoldsTheEstimateAndIsWiderByParticipants) {
  // Ten participants, half of whom see it two steps earlier than the others.
  std::vector<std::vector<Level>> people;
  std::vector<Level> all;
  for (size_t p = 0; p < 10; ++p) {
    people.emplace_back();
    for (int x = 0; x < 7; ++x) {
      const double chance = 0.5 + 0.5 / (1 + std::exp(-(x - (p % 2 == 0 ? 2.0 : 4.0)) / 0.6));
      uint64_t yes = 0;
      for (uint64_t t = 0; t < 12; ++t) yes += random_unit(5, p * 1000 + static_cast<uint64_t>(x), t) < chance ? 1 : 0;
      people.back().push_back({static_cast<double>(x), yes, 12});
      all.push_back(people.back().back());
    }
  }
  const CurveSettings settings;
  const CurveFit fit = fit_curve(all, settings);
  ASSERT_EQ(fit.state, CurveState::fitted);
  const auto trials = bootstrap_threshold(fit, all, {}, settings, 1, 200);
  const auto participants = bootstrap_threshold(fit, all, people, settings, 1, 200);
  ASSERT_TRUE(trials && participants);
  for (const CurveBootstrap& b : {*trials, *participants}) {
    EXPECT_LE(b.threshold.low, *fit.threshold);
    EXPECT_GE(b.threshold.high, *fit.threshold);
    EXPECT_EQ(b.resamples, 200U);
    EXPECT_FALSE(b.open);
  }
  EXPECT_GT(participants->threshold.high - participants->threshold.low,
            1.3 * (trials->threshold.high - trials->threshold.low));
  const auto again = bootstrap_threshold(fit, all, people, settings, 1, 200);
  EXPECT_EQ(again->threshold.low, participants->threshold.low) << "one seed, one interval";
}

// Shares of yes of three people at three levels, whose thresholds differ.
std::vector<std::vector<Level>> three_people() {
  return {{{1, 2, 20}, {2, 12, 20}, {3, 19, 20}},
          {{1, 1, 20}, {2, 8, 20}, {3, 17, 20}},
          {{1, 5, 20}, {2, 15, 20}, {3, 20, 20}}};
}
std::vector<Level> levels_without(const std::vector<std::vector<Level>>& people, size_t left_out) {
  std::vector<Level> out;
  for (size_t i = 0; i < people.size(); ++i)
    if (i != left_out) out.insert(out.end(), people[i].begin(), people[i].end());
  return merged_levels(out);
}

TEST(Psychometric, JackknifeIsTheFormula) {
  const auto people = three_people();
  for (const Curve kind : {Curve::logistic, Curve::weibull}) {
    CurveSettings settings;
    settings.curve = kind;
    settings.guess = 0;
    settings.level = 0.5;
    const auto on_axis = [&](double x) { return kind == Curve::weibull ? std::log(x) : x; };
    const CurveFit fit = fit_curve(levels_without(people, 9), settings);
    const auto got = jackknife_threshold(fit, people, {}, settings);
    ASSERT_TRUE(got);
    ASSERT_EQ(got->state, JackknifeState::done);
    double squares = 0;
    for (size_t i = 0; i < 3; ++i) {
      const double off =
          on_axis(fit_curve(levels_without(people, i), settings).threshold.value()) - on_axis(*fit.threshold);
      squares += off * off;
    }
    const double half = 4.302653 * std::sqrt(2.0 / 3 * squares);  // t of 2 degrees of freedom at .975
    EXPECT_NEAR(on_axis(got->threshold.high) - on_axis(*fit.threshold), half, 1e-3 * half);
    EXPECT_NEAR(on_axis(*fit.threshold) - on_axis(got->threshold.low), half, 1e-3 * half);
  }
}

// The variance of an estimate over groups, by refits that the test makes itself.
double variance_without_each(const std::vector<std::vector<Level>>& groups, double threshold,
                             const CurveSettings& settings) {
  double squares = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    const double off = fit_curve(levels_without(groups, i), settings).threshold.value() - threshold;
    squares += off * off;
  }
  return (static_cast<double>(groups.size()) - 1) / static_cast<double>(groups.size()) * squares;
}

TEST(Psychometric, JackknifeOverParticipantsAndClipsIsTheFormula) {
  CurveSettings settings;
  settings.guess = 0;
  settings.level = 0.5;
  const auto people = three_people();
  const CurveFit fit = fit_curve(levels_without(people, 9), settings);
  // The same answers by four clips: an easy one, a hard one, and two that halve the rest.
  std::vector<std::vector<Level>> clips(4);
  for (const Level& level : levels_without(people, 9)) {
    uint64_t yes = level.yes;
    uint64_t of = level.of;
    for (size_t i = 0; i < 4; ++i) {
      const uint64_t part = of / (4 - i);
      const uint64_t seen = i == 0   ? std::min(yes, part)
                            : i == 1 ? (yes + part > of ? yes + part - of : 0)
                                     : std::min(part, std::max(yes / (4 - i), yes + part > of ? yes + part - of : 0));
      clips[i].push_back({level.x, seen, part});
      yes -= seen;
      of -= part;
    }
    ASSERT_EQ(yes + of, 0U);
  }
  const auto got = jackknife_threshold(fit, people, clips, settings);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->state, JackknifeState::done);
  EXPECT_EQ(got->clips, 4U);
  const double vp = variance_without_each(people, *fit.threshold, settings);
  const double vc = variance_without_each(clips, *fit.threshold, settings);
  const double se = (*fit.threshold_profile.high - *fit.threshold_profile.low) / 2 / 1.959964;
  const double v = std::max({vp, vc, vp + vc - se * se});
  const double degrees = v * v / (vp * vp / 2 + vc * vc / 3);
  EXPECT_NEAR(got->degrees, degrees, 1e-2 * degrees);
  const double half = student_t_quantile(0.975, degrees) * std::sqrt(v);
  EXPECT_NEAR(got->threshold.high - *fit.threshold, half, 1e-2 * half);
  EXPECT_NEAR(*fit.threshold - got->threshold.low, half, 1e-2 * half);
  EXPECT_GT(vc, 2 * se * se) << "these clips differ";
}

TEST(Psychometric, JackknifeSaysWhyThereIsNone) {
  CurveSettings settings;
  settings.guess = 0;
  settings.level = 0.5;
  auto people = three_people();
  std::vector<std::vector<Level>> clips;
  const auto state = [&] {
    return jackknife_threshold(fit_curve(levels_without(people, 9), settings), people, clips, settings).value().state;
  };
  EXPECT_EQ(state(), JackknifeState::done);
  clips = {levels_without(people, 9), {{1, 20, 20}, {2, 20, 20}, {3, 20, 20}}, {{1, 0, 20}, {2, 0, 20}, {3, 0, 20}}};
  EXPECT_EQ(state(), JackknifeState::one_clip_decides);
  clips.pop_back();
  EXPECT_EQ(state(), JackknifeState::done) << "two clips say nothing of clips";
  clips.clear();
  people[1] = people[2] = people[0];
  EXPECT_EQ(state(), JackknifeState::alike);
  people = {people[0], {{1, 20, 20}, {2, 20, 20}, {3, 20, 20}}, {{1, 0, 20}, {2, 0, 20}, {3, 0, 20}}};
  people[0] = {{1, 0, 80}, {2, 40, 80}, {3, 80, 80}};
  EXPECT_EQ(state(), JackknifeState::one_decides) << "the other two answer alike at all levels";
  people.pop_back();
  EXPECT_EQ(state(), JackknifeState::too_few);
  EXPECT_FALSE(jackknife_threshold(CurveFit(), people, {}, settings)) << "no threshold, no interval";
}

// ---- what fits are found by

constexpr double kOpen = std::numeric_limits<double>::infinity();

// (x - 1)^2 + 4 (y + 2)^2 + 3.
double bowl(std::span<const double> x) { return (x[0] - 1) * (x[0] - 1) + 4 * (x[1] + 2) * (x[1] + 2) + 3; }

TEST(Optimise, ABowlsLowestPointAndTheNearestOneWithinBounds) {
  for (const bool simplex : {false, true}) {
    SCOPED_TRACE(simplex);
    const auto lowest = [&](const Objective& objective, const Bounds& bounds) {
      return simplex ? minimise_by_simplex(objective, {3, 3}, bounds, {0.5, 0.5})
                     : minimise(objective, {3, 3}, bounds, {0.5, 0.5});
    };
    const Minimum open = lowest(bowl, {{-kOpen, -kOpen}, {kOpen, kOpen}});
    EXPECT_NEAR(open.x[0], 1, 1e-4);
    EXPECT_NEAR(open.x[1], -2, 1e-4);
    EXPECT_NEAR(open.value, 3, 1e-8);
    // y may not fall below 1: 4 * 3^2 more.
    const Minimum bound = lowest(bowl, {{-kOpen, 1}, {kOpen, kOpen}});
    EXPECT_NEAR(bound.x[1], 1, 1e-6);
    EXPECT_NEAR(bound.value, 39, 1e-6);
    // What is not a number counts as very bad, and is left again.
    const Minimum hole = lowest([](std::span<const double> x) { return x[0] > 3.25 ? std::nan("") : bowl(x); },
                                {{-kOpen, -kOpen}, {kOpen, kOpen}});
    EXPECT_NEAR(hole.value, 3, 1e-6);
  }
}

TEST(Optimise, OneUnknownAndASmoothFunctionOfItsGradient) {
  const Minimum one = minimise([](std::span<const double> x) { return std::abs(x[0] - 0.25); }, {1}, {{0}, {1}}, {0.1});
  EXPECT_NEAR(one.x[0], 0.25, 1e-6);
  const Minimum smooth = minimise_smooth(
      [](std::span<const double> x, std::span<double> gradient) {
        gradient[0] = 2 * (x[0] - 1);
        gradient[1] = 8 * (x[1] + 2);
        return bowl(x);
      },
      {30, 40});
  EXPECT_NEAR(smooth.x[0], 1, 1e-8);
  EXPECT_NEAR(smooth.x[1], -2, 1e-8);
}

TEST(Optimise, CurvatureOfAQuadraticAndItsInverse) {
  // x^2 + 3 x y + 5 y^2 has the second derivatives 2, 3, 10: central differences of a quadratic are exact.
  const Matrix curved =
      hessian([](std::span<const double> x) { return x[0] * x[0] + 3 * x[0] * x[1] + 5 * x[1] * x[1]; }, {0.5, -0.25},
              {0.125, 0.25});
  EXPECT_EQ(curved, (Matrix{{2, 3}, {3, 10}}));
  const std::optional<Matrix> inverse = inverse_of_positive(curved);  // of determinant 11
  ASSERT_TRUE(inverse.has_value());
  EXPECT_NEAR((*inverse)[0][0], 10.0 / 11, 1e-14);
  EXPECT_NEAR((*inverse)[0][1], -3.0 / 11, 1e-14);
  EXPECT_NEAR((*inverse)[1][1], 2.0 / 11, 1e-14);
  EXPECT_FALSE(inverse_of_positive({{1, 2}, {2, 1}}).has_value()) << "a saddle";
  EXPECT_FALSE(inverse_of_positive(Matrix{std::vector<double>{0}}).has_value());
  EXPECT_FALSE(inverse_of_positive(Matrix{std::vector<double>{std::nan("")}}).has_value());
}

// The likelihood of a flat curve is within 3.84 / 2 of the best one's: no threshold is excluded, wherever it lies.
TEST(Psychometric, AnEndThatTheProfileNeverReachesIsOpen) {
  const std::vector<Level> few = {{40, 2, 2}, {80, 2, 2}, {160, 1, 2}, {320, 1, 2}};
  CurveSettings settings;
  settings.falling = true;
  for (const Curve curve : {Curve::logistic, Curve::cumulative_gaussian, Curve::weibull}) {
    settings.curve = curve;
    const CurveFit fit = fit_curve(few, settings);
    ASSERT_TRUE(fit.threshold) << curve_name(curve);
    EXPECT_FALSE(fit.threshold_profile.low) << curve_name(curve) << *fit.threshold_profile.low;
    EXPECT_FALSE(fit.threshold_profile.high) << curve_name(curve) << *fit.threshold_profile.high;
  }
  // Many answers of the same shares do exclude values.
  std::vector<Level> many = few;
  for (Level& level : many) {
    level.yes *= 40;
    level.of *= 40;
  }
  settings.curve = Curve::logistic;
  const CurveFit sure = fit_curve(many, settings);
  ASSERT_TRUE(sure.threshold_profile.low && sure.threshold_profile.high);
  EXPECT_LT(*sure.threshold_profile.high - *sure.threshold_profile.low, 280);
}

}  // namespace
}  // namespace crowdbench::studies
