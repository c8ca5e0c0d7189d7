// What psychometric.cpp, its intervals and its bootstrap share: the likelihood of a curve as a function of a vector,
// and the fit without intervals.
#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "core/probability.h"
#include "studies/analysis/optimise.h"
#include "studies/analysis/psychometric.h"

namespace crowdbench::studies::curve {

// Of the range of levels: a spread of thresholds that is no wider is the optimiser's.
inline constexpr double kAlike = 1e-6;

// F without guesses and slips.
double base(Curve curve, const CurveParameters& p, double x);
// What F must be where psi is `level`.
double base_level(bool falling, const CurveParameters& p, double level);
// The location of which F is f at x.
double location_for(Curve curve, double scale, double x, double f);

// What is fitted, as a vector: where the curve is, the log of its scale, then the rates that are not fixed. Weibull:
// the log of where.
class Problem {
 public:
  // levels: merged, at least two. settings must outlive it.
  Problem(std::vector<Level> levels, const CurveSettings& settings);

  bool is_weibull() const { return settings_.curve == Curve::weibull; }
  const CurveSettings& settings() const { return settings_; }
  const std::vector<Level>& levels() const { return levels_; }
  double spread() const { return levels_.back().x - levels_.front().x; }
  CurveParameters parameters(std::span<const double> v) const;
  std::vector<double> vector_of(const CurveParameters& p) const;

  double likelihood(const CurveParameters& p) const;  // minus its log, without constants
  double penalised(const CurveParameters& p) const;
  double constant() const { return constant_; }
  double saturated() const { return saturated_; }

  Bounds bounds() const;
  std::vector<double> steps() const;
  // At every level and between them, of one steepness: the scale over the range of levels.
  std::vector<std::vector<double>> starts(double steepness) const;

 private:
  size_t unknowns() const;
  double smallest_positive() const;

  std::vector<Level> levels_;
  const CurveSettings& settings_;
  double constant_ = 0;
  double saturated_ = 0;
};

// Of merged levels: whether they can have a fit.
CurveState state_of_data(std::span<const Level> levels);
// The fit without standard errors and profiles. hint: of like data, in place of most of the search; or nothing.
CurveFit fit_point(const Problem& problem, const std::optional<CurveParameters>& hint);

}  // namespace crowdbench::studies::curve
