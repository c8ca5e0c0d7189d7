#include "studies/analysis/optimise.h"

#include <nlopt.h>

#include <Eigen/Core>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>

#include "studies/analysis/dense.h"

namespace crowdbench::studies {
namespace {

// What stands for "very bad": larger than any deviance, small enough that quadratic models of it stay finite.
constexpr double kVeryBad = 1e15;

double tamed(double value) { return std::isfinite(value) && value < kVeryBad ? value : kVeryBad; }

struct Destroy {
  void operator()(nlopt_opt_s* optimiser) const { nlopt_destroy(optimiser); }
};
using Optimiser = std::unique_ptr<nlopt_opt_s, Destroy>;

double call(unsigned n, const double* x, double* /*gradient*/, void* data) {
  return tamed((*static_cast<const Objective*>(data))({x, n}));
}

double call_with_gradient(unsigned n, const double* x, double* gradient, void* data) {
  std::vector<double> unused;
  if (gradient == nullptr) unused.resize(n);
  return tamed((*static_cast<const ObjectiveWithGradient*>(data))(
      {x, n}, gradient != nullptr ? std::span<double>(gradient, n) : std::span<double>(unused)));
}

Optimiser optimiser_of(nlopt_algorithm algorithm, const Objective& objective, size_t n, const Bounds& bounds,
                       const std::vector<double>& step) {
  Optimiser out(nlopt_create(algorithm, static_cast<unsigned>(n)));
  // NLopt's C interface takes the data of a call as a pointer to what may change.
  nlopt_set_min_objective(out.get(), call, const_cast<Objective*>(&objective));
  nlopt_set_lower_bounds(out.get(), bounds.low.data());
  nlopt_set_upper_bounds(out.get(), bounds.high.data());
  nlopt_set_initial_step(out.get(), step.data());
  return out;
}

}  // namespace

Minimum minimise(const Objective& objective, std::vector<double> start, const Bounds& bounds,
                 const std::vector<double>& step, double gain) {
  // BOBYQA wants two unknowns or more.
  if (start.size() < 2) return minimise_by_simplex(objective, std::move(start), bounds, step);
  Minimum best{start, tamed(objective(start))};
  std::vector<double> first = step;
  for (int again = 0; again < 20; ++again) {
    const Optimiser optimiser = optimiser_of(NLOPT_LN_BOBYQA, objective, start.size(), bounds, first);
    nlopt_set_xtol_rel(optimiser.get(), 1e-8);
    nlopt_set_maxeval(optimiser.get(), 5000);
    Minimum found = best;
    nlopt_optimize(optimiser.get(), found.x.data(), &found.value);  // where it ends for rounding, the best is in found
    const double gained = best.value - found.value;
    if (gained > 0) best = found;
    if (!(gained > gain)) break;
    for (double& s : first) s *= 0.2;
  }
  return best;
}

Minimum minimise_by_simplex(const Objective& objective, std::vector<double> start, const Bounds& bounds,
                            const std::vector<double>& step) {
  const Optimiser optimiser = optimiser_of(NLOPT_LN_SBPLX, objective, start.size(), bounds, step);
  nlopt_set_xtol_rel(optimiser.get(), 1e-9);
  nlopt_set_ftol_abs(optimiser.get(), 1e-12);
  nlopt_set_maxeval(optimiser.get(), 4000);
  Minimum best{start, tamed(objective(start))};
  Minimum found = best;
  nlopt_optimize(optimiser.get(), found.x.data(), &found.value);
  return found.value < best.value ? found : best;
}

Minimum minimise_smooth(const ObjectiveWithGradient& objective, std::vector<double> start) {
  Minimum best{std::move(start), std::numeric_limits<double>::infinity()};
  const Optimiser optimiser(nlopt_create(NLOPT_LD_LBFGS, static_cast<unsigned>(best.x.size())));
  nlopt_set_min_objective(optimiser.get(), call_with_gradient, const_cast<ObjectiveWithGradient*>(&objective));
  nlopt_set_xtol_rel(optimiser.get(), 1e-11);
  nlopt_set_maxeval(optimiser.get(), 5000);
  nlopt_optimize(optimiser.get(), best.x.data(), &best.value);
  return best;
}

Matrix hessian(const Objective& objective, const std::vector<double>& x, const std::vector<double>& step) {
  assert(step.size() == x.size());
  const size_t n = x.size();
  const double middle = objective(x);
  const auto at = [&](size_t i, double di, size_t j, double dj) {
    std::vector<double> moved = x;
    moved[i] += di;
    moved[j] += dj;
    return objective(moved);
  };
  Matrix out(n, std::vector<double>(n));
  for (size_t i = 0; i < n; ++i) {
    const double hi = step[i];
    out[i][i] = (at(i, hi, i, 0) - 2 * middle + at(i, -hi, i, 0)) / (hi * hi);
    for (size_t j = 0; j < i; ++j) {
      const double hj = step[j];
      out[i][j] = out[j][i] =
          (at(i, hi, j, hj) - at(i, hi, j, -hj) - at(i, -hi, j, hj) + at(i, -hi, j, -hj)) / (4 * hi * hj);
    }
  }
  return out;
}

std::optional<Matrix> inverse_of_positive(const Matrix& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size());
  Eigen::MatrixXd m(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) m(i, j) = matrix[static_cast<size_t>(i)][static_cast<size_t>(j)];
  const std::optional<Eigen::MatrixXd> inverse = dense::inverse_of_positive(m);
  if (!inverse || !inverse->allFinite() || inverse->diagonal().minCoeff() <= 0) return std::nullopt;
  Matrix out = matrix;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) out[static_cast<size_t>(i)][static_cast<size_t>(j)] = (*inverse)(i, j);
  return out;
}

}  // namespace crowdbench::studies
