// Minimisers within bounds, and curvature by differences: NLopt behind two functions, so that its C interface stays in
// one file.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace crowdbench::studies {

using Objective = std::function<double(std::span<const double> x)>;
// Fills `gradient`, as long as x, and returns the value.
using ObjectiveWithGradient = std::function<double(std::span<const double> x, std::span<double> gradient)>;

struct Bounds {
  std::vector<double> low, high;  // as long as x; low <= high; may be infinite
};
struct Minimum {
  std::vector<double> x;
  double value = 0;
};

// A local minimum near `start`, which lies within the bounds, without derivatives: BOBYQA (Powell 2009), begun anew
// from where it ended until that gains less than `gain`. step: the first change of each x, above 0. The objective may
// return +inf or NaN, which counts as very bad.
Minimum minimise(const Objective& objective, std::vector<double> start, const Bounds& bounds,
                 const std::vector<double>& step, double gain = 1e-9);
// The same by Nelder and Mead's simplex in subspaces (Rowan's Subplex): slower, and steady where the objective has
// edges.
Minimum minimise_by_simplex(const Objective& objective, std::vector<double> start, const Bounds& bounds,
                            const std::vector<double>& step);
// A local minimum of a smooth function, by limited-memory BFGS.
Minimum minimise_smooth(const ObjectiveWithGradient& objective, std::vector<double> start);

using Matrix = std::vector<std::vector<double>>;  // row by row

// The matrix of second derivatives at x by central differences of the given steps.
Matrix hessian(const Objective& objective, const std::vector<double>& x, const std::vector<double>& step);
// The inverse of a symmetric matrix; nothing where it is not positive definite.
std::optional<Matrix> inverse_of_positive(const Matrix& matrix);

}  // namespace crowdbench::studies
