// Mixed-effects logistic (or probit) regression: answers of several participants, each with a readiness and a
// sensitivity of their own, to several clips, each easier or harder than the others. What a pooled fit takes for
// independent answers, this one does not.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/statistics.h"

namespace crowdbench::studies {

enum class Link { logit, probit };

// How the likelihood is integrated over what is random.
//   laplace        at the conditional mode, with the expected information in the determinant, as lme4's glmer
//   laplace_observed
//                  likewise, with the observed information, as glmmTMB and ordinal; the same for the logit without
//                  guesses
//   quadrature     adaptive Gauss-Hermite with 25 nodes: for participants' intercepts alone. The most exact of the
//                  three, and what different programs agree on
enum class Integration { laplace, laplace_observed, quadrature };

struct MixedRow {
  uint32_t participant = 0;
  uint32_t clip = 0;          // 0 where clips are not random
  std::vector<double> fixed;  // one value a fixed effect; the first is 1
  double slope = 0;           // what the random slope multiplies, where there is one
  uint64_t yes = 0;
  uint64_t of = 0;
  uint64_t halves = 0;  // of `of`, and not of `yes`: answers that count half yes and half no

  double weight_of_yes() const { return static_cast<double>(yes) + static_cast<double>(halves) / 2; }
  double weight_of_no() const { return static_cast<double>(of) - weight_of_yes(); }
};

struct MixedSettings {
  Link link = Link::logit;
  double guess = 0;        // P(yes) = guess + (1 - guess) F(eta), in [0, 1)
  bool slopes = false;     // a random slope by participant beside the random intercept
  bool correlated = true;  // intercept and slope of a participant may be correlated
  bool clips = false;      // random intercepts of clips
  Integration integration = Integration::laplace;
  // Standard errors from the whole curvature; else given the variances: faster, and a little smaller.
  bool full_errors = true;
  // Begin the search anew until that gains nothing; else once, for many fits of simulated data.
  bool thorough = true;
};

enum class MixedState {
  fitted,
  singular,  // fitted, and a variance (or what two leave free) is exactly 0: fewer random effects would do
  no_data,
  all_alike,        // every answer is the same
  one_participant,  // nothing says how participants vary
  separated,        // the answers are divided completely: the estimate would be infinite
  unidentified,     // the fixed effects do not differ from each other in these data
};
std::string_view state_text(MixedState state);

struct MixedEffect {
  double estimate = 0;
  double se = 0;
  double z = 0;
  double p = 1;  // Wald, two-sided
};

struct MixedFit {
  MixedState state = MixedState::no_data;
  std::vector<MixedEffect> fixed;
  std::vector<std::vector<double>> covariance;  // of the fixed effects
  // On the scale of eta.
  double participant_variance = 0;
  std::optional<double> slope_variance, intercept_slope_covariance, clip_variance;
  // Of 0/1 answers, without binomial constants; an answer that is halved has the mean of what yes and no have.
  double log_likelihood = 0;
  uint64_t answers = 0;
  size_t participants = 0, clips = 0;
  // Of each participant's intercept, and its standard deviation given the estimates.
  std::vector<double> modes, mode_sds;
};

// rows: any order; rows of equal participant, clip and fixed effects are put together. All `fixed` of one length, at
// least 1. Quadrature with slopes or clips is a bug and asserts.
MixedFit fit_mixed(std::vector<MixedRow> rows, const MixedSettings& settings);

// The likelihood-ratio test of one fixed effect.
struct LikelihoodRatio {
  double chi_squared = 0;
  double p = 1;
};
// fit: of all fixed effects, fitted or singular. Nothing where the smaller model has no fit.
std::optional<LikelihoodRatio> likelihood_ratio(const std::vector<MixedRow>& rows, const MixedSettings& settings,
                                                const MixedFit& fit, size_t effect);

// P(yes) at given fixed effects: of a participant in the middle of all with a clip in the middle of all, and the
// average over participants and clips. The two differ, the more the participants do.
struct PopulationProbability {
  double typical = 0;
  double average = 0;
};
PopulationProbability population_probability(const MixedFit& fit, const MixedSettings& settings,
                                             const std::vector<double>& fixed);

// Where on the axis of fixed effect 1 the typical participant's P(yes) is `level`, with its interval by Fieller's
// theorem (it may be open, where the slope is not known to differ from 0). The variances of participants and of clips
// are estimates from a few: their parts of the variance are n / (n - 1) of the likelihood's, and the quantile is
// Student's with the degrees of freedom that they leave (Satterthwaite), at most those of the participants: of few the
// variance between them is often estimated as 0, and the interval is then too wide rather than too narrow. For fits
// with an intercept and one slope.
struct MixedThreshold {
  double at = 0;
  std::optional<Interval> interval;
};
std::optional<MixedThreshold> mixed_threshold(const MixedFit& fit, const MixedSettings& settings, double level,
                                              double confidence = 0.95);

// Nodes and weights of Gauss-Hermite quadrature for the weight exp(-x^2 / 2) / sqrt(2 pi): weights sum to 1.
struct Quadrature {
  std::vector<double> nodes, weights;
};
const Quadrature& gauss_hermite_25();

}  // namespace crowdbench::studies
