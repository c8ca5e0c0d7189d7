// Mixed-effects regression: against lme4, glmmTMB, ordinal and a dense second implementation, and where there is no
// estimate.
#include "studies/analysis/mixed_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/probability.h"
#include "studies/analysis/simulated.h"
#include "tests/studies/ground_truth.h"

namespace crowdbench::studies {
namespace {

using Expected = nlohmann::json;

std::vector<MixedRow> rows_of(const Expected& data) {
  std::vector<MixedRow> out;
  for (size_t i = 0; i < data.at("y").size(); ++i) {
    const double x = data.at("x")[i].get<double>();
    out.push_back({.participant = data.at("observer")[i].get<uint32_t>() - 1,
                   .clip = data.contains("clip") ? data.at("clip")[i].get<uint32_t>() - 1 : 0,
                   .fixed = {1, x},
                   .slope = x,
                   .yes = data.at("y")[i].get<uint64_t>(),
                   .of = 1});
  }
  return out;
}

MixedSettings settings_of(const Expected& fit) {
  const auto model = fit.at("model").get<std::string>();
  MixedSettings out;
  out.link = fit.at("link") == "probit" ? Link::probit : Link::logit;
  out.slopes = model.find("x|observer") != std::string::npos;
  out.correlated = model.find("(1 + x|observer)") != std::string::npos;
  out.clips = model.find("(1|clip)") != std::string::npos;
  return out;
}

void expect_variance(double got, double expected, const char* what) {
  EXPECT_NEAR(got, expected, std::max(1e-4, 5e-3 * expected)) << what;
}

// Tolerances are the file's own: "glmm ..." of its `tolerances`.
void expect_fit(const MixedFit& fit, const std::vector<double>& fixed, const std::vector<double>& se, double loglik) {
  ASSERT_TRUE(fit.state == MixedState::fitted || fit.state == MixedState::singular) << state_text(fit.state);
  EXPECT_NEAR(fit.log_likelihood, loglik, 1e-3);
  for (size_t i = 0; i < fixed.size(); ++i) {
    EXPECT_NEAR(fit.fixed[i].estimate, fixed[i], 2e-3) << i;
    EXPECT_NEAR(fit.fixed[i].se / se[i], 1, 1e-2) << i;
  }
}

void expect_random(const MixedFit& fit, const Expected& random) {
  for (const Expected& r : random) {
    const auto value = r.at("vcov").get<double>();
    if (r.contains("var2") && r.at("var2").is_string())
      EXPECT_NEAR(fit.intercept_slope_covariance.value(), value, 2e-3);
    else if (r.at("group") == "clip")
      expect_variance(fit.clip_variance.value(), value, "clip");
    else if (r.at("var1") == "x")
      expect_variance(fit.slope_variance.value(), value, "slope");
    else
      expect_variance(fit.participant_variance, value, "participant");
  }
}

void expect_glmer(const std::vector<MixedRow>& rows, MixedSettings settings, const Expected& of) {
  settings.integration = Integration::laplace;
  const MixedFit fit = fit_mixed(rows, settings);
  const Expected& glmer = of.at("glmer_laplace");
  expect_fit(fit, glmer.at("fixed"), glmer.at("se"), glmer.at("loglik"));
  expect_random(fit, glmer.at("random"));
  EXPECT_EQ(fit.state == MixedState::singular, glmer.at("singular").get<bool>());
  if (glmer.contains("lrt_x") && !settings.slopes) {
    const auto ratio = likelihood_ratio(rows, settings, fit, 1);
    ASSERT_TRUE(ratio);
    EXPECT_NEAR(ratio->chi_squared, glmer.at("lrt_x").at("chi2").get<double>(), 5e-3);
  }
  if (!of.contains("conditional_modes_laplace")) return;
  const Expected& modes = of.at("conditional_modes_laplace");
  for (size_t i = 0; i < modes.at("mode").size(); ++i) {
    const size_t participant = std::stoul(modes.at("observer")[i].get<std::string>()) - 1;
    EXPECT_NEAR(fit.modes[participant], modes.at("mode")[i].get<double>(), 2e-3);
    EXPECT_NEAR(fit.mode_sds[participant] / modes.at("sd")[i].get<double>(), 1, 1e-2);
  }
}

void expect_observed(const std::vector<MixedRow>& rows, MixedSettings settings, const Expected& of) {
  settings.integration = Integration::laplace_observed;
  const MixedFit fit = fit_mixed(rows, settings);
  const Expected& tmb = of.at("second_glmmTMB");
  expect_fit(fit, tmb.at("fixed"), tmb.at("se"), tmb.at("loglik"));
  if (!settings.slopes)
    expect_variance(fit.participant_variance, tmb.at("random")[0].at("cov")[0].get<double>(), "TMB");
}

void expect_quadrature(const std::vector<MixedRow>& rows, MixedSettings settings, const Expected& of) {
  settings.integration = Integration::quadrature;
  const MixedFit fit = fit_mixed(rows, settings);
  const Expected& agq = of.at("glmer_agq25");
  expect_fit(fit, agq.at("fixed"), agq.at("se"), agq.at("loglik"));
  expect_random(fit, agq.at("random"));
  if (!of.contains("population_probability")) return;
  for (const Expected& p : of.at("population_probability")) {
    const PopulationProbability got = population_probability(fit, settings, {1, p.at("x").get<double>()});
    EXPECT_NEAR(got.typical, p.at("at_u0").get<double>(), 5e-4);
    EXPECT_NEAR(got.average, p.at("marginal").get<double>(), 5e-4);
  }
}

TEST(MixedModel, IsThatOfLme4AndOthers) {
  const Expected& expected = test::statistics_expected();
  size_t fits = 0;
  for (const auto& [name, set] : expected.at("glmm").items()) {
    if (!set.contains("fits")) continue;
    const std::vector<MixedRow> rows = rows_of(set.at("data"));
    for (const Expected& of : set.at("fits")) {
      SCOPED_TRACE(name + ": " + of.at("model").get<std::string>() + ", " + of.at("link").get<std::string>());
      const MixedSettings settings = settings_of(of);
      expect_glmer(rows, settings, of);
      expect_observed(rows, settings, of);
      if (!settings.slopes && !settings.clips) expect_quadrature(rows, settings, of);
      ++fits;
    }
  }
  EXPECT_GE(fits, 4U);
}

TEST(MixedModel, TakesCountsAndContrasts) {
  const Expected& expected = test::statistics_expected();
  if (!expected.at("glmm").contains("cbpp")) GTEST_SKIP() << "needs the shared ground-truth folder";
  const Expected& cbpp = expected.at("glmm").at("cbpp");
  std::vector<MixedRow> rows;
  for (size_t i = 0; i < cbpp.at("data").at("herd").size(); ++i) {
    MixedRow row{.participant = cbpp.at("data").at("herd")[i].get<uint32_t>() - 1,
                 .fixed = {1, 0, 0, 0},
                 .yes = cbpp.at("data").at("incidence")[i].get<uint64_t>(),
                 .of = cbpp.at("data").at("size")[i].get<uint64_t>()};
    if (const auto period = cbpp.at("data").at("period")[i].get<size_t>(); period > 1) row.fixed[period - 1] = 1;
    rows.push_back(row);
  }
  const double constant = cbpp.at("sum_log_choose").get<double>();
  for (const auto& [integration, name, loglik] :
       {std::tuple(Integration::laplace, "glmer_laplace", "laplace_at_glmer_nagq1"),
        std::tuple(Integration::quadrature, "glmer_agq25", "agq25_at_glmer_nagq25")}) {
    SCOPED_TRACE(name);
    expect_fit(fit_mixed(rows, {.integration = integration}), cbpp.at(name).at("fixed"), cbpp.at(name).at("se"),
               cbpp.at("own_loglik_with_binomial_constants").at(loglik).get<double>() - constant);
  }
}

// The names of what has no estimate.
TEST(MixedModel, SaysWhatHasNoEstimate) {
  const auto rows = [](auto yes) {
    std::vector<MixedRow> out;
    for (uint32_t p = 0; p < 12; ++p)
      for (int x = -3; x <= 3; ++x)
        out.push_back({.participant = p, .fixed = {1, static_cast<double>(x)}, .yes = yes(p, x) ? 1U : 0U, .of = 1});
    return out;
  };
  EXPECT_EQ(fit_mixed({}, {}).state, MixedState::no_data);
  EXPECT_EQ(fit_mixed(rows([](uint32_t, int) { return true; }), {}).state, MixedState::all_alike);
  EXPECT_EQ(fit_mixed(rows([](uint32_t, int x) { return x > 0; }), {}).state, MixedState::separated);
  // One level has both answers: still no end to the slope.
  EXPECT_EQ(fit_mixed(rows([](uint32_t p, int x) { return x > 0 || (x == 0 && p % 2 == 0); }), {}).state,
            MixedState::separated);
  // With guesses a step is not parted by any direction, and has no estimate all the same.
  EXPECT_EQ(
      fit_mixed(rows([](uint32_t p, int x) { return x > 0 || (x + static_cast<int>(p)) % 2 == 0; }), {.guess = 0.5})
          .state,
      MixedState::separated);
  std::vector<MixedRow> alone = rows([](uint32_t p, int x) { return (x + 3 + static_cast<int>(p)) % 3 == 0; });
  std::erase_if(alone, [](const MixedRow& r) { return r.participant != 0; });
  EXPECT_EQ(fit_mixed(alone, {}).state, MixedState::one_participant);
  std::vector<MixedRow> same = rows([](uint32_t p, int x) { return (x + 3 + static_cast<int>(p)) % 3 == 0; });
  for (MixedRow& r : same) r.fixed[1] = 2;
  EXPECT_EQ(fit_mixed(same, {}).state, MixedState::unidentified);
}

// A variable that is the same everywhere, at a value whose mean is not exact.
TEST(MixedModel, AConstantLevelIsNoEffect) {
  std::vector<MixedRow> rows;
  for (uint32_t p = 0; p < 7; ++p)
    for (int t = 0; t < 3; ++t)
      rows.push_back({.participant = p, .fixed = {1, 160.1}, .yes = (p + t) % 3 ? 1U : 0U, .of = 1});
  EXPECT_EQ(fit_mixed(rows, {}).state, MixedState::unidentified);
}

TEST(MixedModel, ThresholdIsWhereTheTypicalParticipantIs) {
  // b0 + b1 t = logit(.75) by hand.
  MixedFit fit;
  fit.state = MixedState::fitted;
  fit.fixed = {{.estimate = -1}, {.estimate = 2}};
  const auto at = mixed_threshold(fit, {}, 0.75);
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->at, (std::log(3) + 1) / 2, 1e-12);
  EXPECT_FALSE(at->interval);
  fit.covariance = {{0.01, 0}, {0, 0.01}};
  const auto bounded = mixed_threshold(fit, {}, 0.75);
  ASSERT_TRUE(bounded && bounded->interval);
  EXPECT_LT(bounded->interval->low, at->at);
  EXPECT_GT(bounded->interval->high, at->at);
  fit.covariance = {{0.01, 0}, {0, 2}};  // the slope may be 0
  EXPECT_FALSE(mixed_threshold(fit, {}, 0.75)->interval);
}

// The variance of nine participants, all that is uncertain, is an estimate with eight degrees of freedom: 0.18 / 8 in
// place of the likelihood's 0.18 / 9, and Student's 2.306 in place of 1.96.
TEST(MixedModel, ThresholdsOfFewParticipantsAreWider) {
  MixedFit fit;
  fit.state = MixedState::fitted;
  fit.fixed = {{.estimate = -1}, {.estimate = 2}};
  fit.covariance = {{0.02, 0}, {0, 0}};
  const auto half_width = [&] {
    const MixedThreshold found = mixed_threshold(fit, {}, 0.75).value();
    EXPECT_NEAR(found.interval.value().low + found.interval->high, 2 * found.at, 1e-12);
    return found.interval->high - found.at;
  };
  EXPECT_NEAR(half_width(), 1.959964 * std::sqrt(0.02) / 2, 1e-6) << "nothing random";
  fit.participants = 9;
  EXPECT_NEAR(half_width(), 2.306004 * std::sqrt(0.02) / 2, 1e-6) << "nine alike are nine all the same";
  fit.participant_variance = 0.18;
  EXPECT_NEAR(half_width(), 2.306004 * std::sqrt(0.18 / 8) / 2, 1e-6);
  // Half of the variance each: (0.1 / 8 + 0.3 / 2)^2 over the squares by their degrees.
  fit.covariance = {{0.2, 0}, {0, 0}};
  fit.participant_variance = 0.9;
  fit.clip_variance = 0.3;
  fit.clips = 3;
  const double people = 0.1 * 9 / 8;
  const double clips = 0.1 * 3 / 2;
  const double degrees = (people + clips) * (people + clips) / (people * people / 8 + clips * clips / 2);
  EXPECT_NEAR(half_width(), student_t_quantile(0.975, degrees) * std::sqrt(people + clips) / 2, 1e-9);
  // Of many it is what it was.
  fit.participants = fit.clips = 100000;
  EXPECT_NEAR(half_width(), 1.959964 * std::sqrt(0.2) / 2, 1e-4);
}

// Thresholds and slopes that differ: the model whose slope may be correlated with the intercept holds the one whose
// slope may not, and never fits worse. lme4's glmer with the link of a forced choice says -299.6619 of seed 41.
TEST(MixedModel, IsNeverBelowTheModelThatItHolds) {
  const SimulatedObservers truth{
      .threshold = 10, .slope = 0.45, .threshold_sd = 1.5, .slope_log_sd = 0.4, .guess = 0.5};
  const SimulatedDesign design{.participants = 20, .levels = {4, 8, 12, 16, 20}, .clips = 1, .repeats = 8};
  for (const uint64_t seed : {41U, 42U}) {
    SCOPED_TRACE(seed);
    std::vector<MixedRow> rows;
    for (const Answer& a : simulate_answers(truth, design, seed).rows)
      rows.push_back({.participant = *a.participant, .fixed = {1, *a.level}, .slope = *a.level, .yes = a.yes, .of = 1});
    const auto fit = [&](bool slopes, bool correlated) {
      return fit_mixed(rows, {.guess = 0.5, .slopes = slopes, .correlated = correlated, .full_errors = false});
    };
    const MixedFit all = fit(true, true);
    const MixedFit apart = fit(true, false);
    EXPECT_GE(all.log_likelihood, apart.log_likelihood - 1e-6);
    EXPECT_GE(apart.log_likelihood, fit(false, false).log_likelihood - 1e-6);
    if (seed == 41) EXPECT_NEAR(all.log_likelihood, -299.6619, 2e-3);
    // Where levels begin is nobody's concern: the same answers about another zero are the same model.
    for (MixedRow& row : rows) row.slope = row.fixed[1] -= 12;
    const MixedFit moved = fit(true, true);
    EXPECT_NEAR(moved.log_likelihood, all.log_likelihood, 1e-4);
    EXPECT_NEAR(moved.slope_variance.value() / all.slope_variance.value(), 1, 0.02);
  }
}

TEST(MixedModel, QuadratureIsExactForPolynomials) {
  double sum = 0;
  double second = 0;
  double eighth = 0;
  for (size_t k = 0; k < 25; ++k) {
    const double x = gauss_hermite_25().nodes[k];
    sum += gauss_hermite_25().weights[k];
    second += gauss_hermite_25().weights[k] * x * x;
    eighth += gauss_hermite_25().weights[k] * std::pow(x, 8);
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_NEAR(second, 1, 1e-12);
  EXPECT_NEAR(eighth, 105, 1e-9);  // 7 * 5 * 3
}

}  // namespace
}  // namespace crowdbench::studies
