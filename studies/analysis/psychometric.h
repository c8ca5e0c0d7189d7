// The psychometric function: how often people see a difference against how large it is. Fitted by maximum likelihood,
// with intervals that hold the estimate, and a named result where the data have no fit.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/statistics.h"

namespace crowdbench::studies {

// psi(x) = guess + (1 - guess - lapse) F(x):
//   logistic            F = 1 / (1 + exp(-(x - location) / scale))
//   cumulative_gaussian F = Phi((x - location) / scale)
//   weibull             F = 1 - exp(-(x / location)^scale), x >= 0
// falling: 1 - F in place of F: what is seen less often where x is larger (a distance).
enum class Curve { logistic, cumulative_gaussian, weibull };
std::string_view curve_name(Curve kind);
std::optional<Curve> curve_named(std::string_view name);  // "logistic", "cumgauss", "weibull"

struct CurveParameters {
  double location = 0;
  double scale = 1;  // above 0
  double guess = 0.5;
  double lapse = 0;
};
double psi(Curve kind, bool falling, const CurveParameters& p, double x);
// The x where psi is `level`; nothing where psi does not reach it.
std::optional<double> x_at(Curve kind, bool falling, const CurveParameters& p, double level);

struct Level {
  double x = 0;
  uint64_t yes = 0;
  uint64_t of = 0;
};
// Levels of one x put together, by ascending x, those without answers left out.
std::vector<Level> merged_levels(std::span<const Level> levels);

// What is done about a rate that is not the curve's: guess of guesses, lapse of slips.
enum class Rate {
  fixed,      // at the value given
  free,       // fitted in [0, most]
  penalised,  // fitted in [0, most], with the density Beta(1, 10) as a penalty: small unless the data say otherwise
};
struct CurveSettings {
  Curve curve = Curve::logistic;
  bool falling = false;
  Rate guess_rate = Rate::fixed;
  double guess = 0.5;
  double most_guess = 0.5;
  Rate lapse_rate = Rate::penalised;
  double lapse = 0;
  double most_lapse = 0.1;
  double level = 0.75;       // of psi, at which the threshold is
  double confidence = 0.95;  // of the intervals
};

enum class CurveState {
  fitted,
  no_data,      // no answers
  one_level,    // all answers at one level: nothing says how steep
  all_alike,    // every answer is the same: the threshold lies outside of what was shown
  no_slope,     // the curve is flat, or runs the other way: no threshold
  step,         // the curve rises between two levels, or two and the one between them: how steep it is is not known
  not_reached,  // psi does not reach the level within a tenfold range of what was shown
};
std::string_view state_text(CurveState state);

struct CurveFit {
  CurveState state = CurveState::no_data;
  CurveParameters at;
  double negative_log_likelihood = 0;  // with the binomial constants, without the penalty
  double deviance = 0;                 // against the saturated model
  uint64_t answers = 0;
  size_t levels = 0;
  std::optional<double> threshold;  // x_at(level)
  // Standard errors from the observed information; nothing where it is not positive definite.
  std::optional<double> location_se, scale_se;
  // By the likelihood ratio; an end that is nothing is open: the data do not exclude any value that way.
  struct Ends {
    std::optional<double> low, high;
  };
  Ends location_profile, threshold_profile;
};
// levels: any order; x at least 0 for Weibull, else a bug. A step has a threshold with an interval, and no standard
// errors; of other states only what exists is set.
CurveFit fit_curve(std::span<const Level> levels, const CurveSettings& settings);

// Percentile intervals of refits to answers drawn anew: parametric (binomial, from the fitted curve) where `groups` is
// empty; else whole groups (participants) drawn with replacement, which keeps that answers of one are alike. An
// interval that missed the estimate is widened to hold it (`widened`). Percentiles of few groups lie too near: draws of
// n differ by (n - 1) / n of the groups' variance, and a normal distribution's tails are not those of a variance that
// is estimated. Of groups both ends are therefore moved away from the estimate, by
//   stretch = t(n - 1) / z sqrt(n / (n - 1)),  t and z: quantiles of Student's and the normal distribution
struct CurveBootstrap {
  size_t resamples = 0;
  size_t failed = 0;  // refits without a threshold; they count as beyond either end if more than alpha / 2 of all are
  Interval threshold;
  bool widened = false;
  bool open = false;  // so many refits failed that the interval has no honest ends
  // The refits say nothing of the spread: all have one threshold, or more than half are steps, whose threshold is
  // placed between two levels by the optimiser and not by the data. The interval is then none.
  bool alike = false;
  // Fewer groups than kLeastBootstrapGroups: so few differing draws that percentiles are single participants' own fits.
  bool few = false;
  double stretch = 1;

  bool has_interval() const { return !open && !alike && !few; }
};
inline constexpr size_t kLeastBootstrapGroups = 6;
std::optional<CurveBootstrap> bootstrap_threshold(const CurveFit& fit, std::span<const Level> levels,
                                                  std::span<const std::vector<Level>> groups,
                                                  const CurveSettings& settings, uint64_t seed, size_t resamples);

// The interval of a threshold over participants, as of a mean of as many numbers: without each participant in turn
// (Tukey's jackknife), the estimate less or more Student's t with n - 1 degrees of freedom times
//   SE = sqrt((n - 1) / n sum over i of (t_i - t)^2),  t_i: the threshold without i, t: that of all
// (of Weibull's curve, of the logs of thresholds). Where several clips were shown to everybody, the interval is over
// both: V = Vp + Vc - Vt of the variances without a participant, without a clip, and of trials alone (from the
// likelihood's interval; it stands in both of the others), at least the larger of Vp and Vc, with
// V^2 / (Vp^2 / (participants - 1) + Vc^2 / (clips - 1)) degrees of freedom (Satterthwaite).
// tests/studies/recovery_test.cpp says how often it holds the truth.
enum class JackknifeState {
  done,
  too_few,           // fewer than kLeastJackknifeGroups
  one_decides,       // without one of them the rest have no threshold
  one_clip_decides,  // nor without one of the clips
  alike,  // the threshold is the same without any of them, or a step, which the optimiser places: no spread is seen
};
struct CurveJackknife {
  JackknifeState state = JackknifeState::done;
  size_t groups = 0;
  size_t clips = 0;    // that it is over, beside the participants; 0: none, it is for the clips that were shown
  double degrees = 0;  // of freedom, where done
  Interval threshold;  // where done
};
inline constexpr size_t kLeastJackknifeGroups = 3;
// groups: the answers by participant, at least one. clips: the same answers by clip; fewer than kLeastJackknifeGroups
// count for none. Nothing where the fit has no threshold.
std::optional<CurveJackknife> jackknife_threshold(const CurveFit& fit, std::span<const std::vector<Level>> groups,
                                                  std::span<const std::vector<Level>> clips,
                                                  const CurveSettings& settings);

}  // namespace crowdbench::studies
