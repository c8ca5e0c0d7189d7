#include "reports/model/cost_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/counted.h"
#include "core/probability.h"

namespace crowdbench::reports {
namespace {

constexpr size_t kLeastPoints = 4;
constexpr size_t kMostPoints = 400;  // more are taken evenly: figures of few terms are no surer for them
constexpr size_t kMostFolds = 40;    // up to so many points each is left out by itself

// The least squares of relative errors of the terms in `subset`.
struct Solved {
  std::vector<double> ns;  // by term of the subset, each above 0
  double left_out = 0;     // root mean square of the relative errors of each point when it is left out
};

// By elimination with pivots: a becomes its own inverse. false: singular.
bool invert(std::vector<std::vector<double>>& a) {
  const size_t n = a.size();
  for (size_t i = 0; i < n; ++i) {
    a[i].resize(2 * n, 0);
    a[i][n + i] = 1;
  }
  for (size_t i = 0; i < n; ++i) {
    size_t pivot = i;
    for (size_t r = i + 1; r < n; ++r)
      if (std::abs(a[r][i]) > std::abs(a[pivot][i])) pivot = r;
    std::swap(a[i], a[pivot]);
    if (std::abs(a[i][i]) < 1e-10) return false;
    const double by = a[i][i];
    for (double& value : a[i]) value /= by;
    for (size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const double f = a[r][i];
      for (size_t c = i; c < 2 * n; ++c) a[r][c] -= f * a[i][c];
    }
  }
  for (auto& row : a) row.erase(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n));
  return true;
}

// Nothing where a coefficient is not above 0, the terms cannot be told apart, or one point alone decides a term. A
// point's error when left out follows from the fit of all: e / (1 - h), h its leverage.
std::optional<Solved> solve(const std::vector<CostPoint>& points, const std::vector<size_t>& subset) {
  const size_t n = subset.size();
  // Columns are scaled to a greatest entry of 1, so that pixels and agents meet at one size.
  std::vector<double> scale(n, 0);
  for (const CostPoint& point : points)
    for (size_t i = 0; i < n; ++i) scale[i] = std::max(scale[i], *point.counts[subset[i]] / point.time_ns);
  for (const double s : scale)
    if (!(s > 0)) return std::nullopt;
  const auto row_of = [&](const CostPoint& point) {
    std::vector<double> row(n);
    for (size_t i = 0; i < n; ++i) row[i] = *point.counts[subset[i]] / point.time_ns / scale[i];
    return row;
  };
  std::vector<std::vector<double>> inverse(n, std::vector<double>(n, 0));
  std::vector<double> right(n, 0);
  for (const CostPoint& point : points) {
    const std::vector<double> row = row_of(point);
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j) inverse[i][j] += row[i] * row[j];
      right[i] += row[i];
    }
  }
  if (!invert(inverse)) return std::nullopt;
  std::vector<double> scaled(n, 0);
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j) scaled[i] += inverse[i][j] * right[j];
    if (!(scaled[i] > 0)) return std::nullopt;
  }
  Solved out;
  double squares = 0;
  for (const CostPoint& point : points) {
    const std::vector<double> row = row_of(point);
    double predicted = 0;
    double leverage = 0;
    for (size_t i = 0; i < n; ++i) {
      predicted += row[i] * scaled[i];
      for (size_t j = 0; j < n; ++j) leverage += row[i] * inverse[i][j] * row[j];
    }
    if (leverage > 1 - 1e-9) return std::nullopt;
    const double error = (predicted - 1) / (1 - leverage);
    squares += error * error;
  }
  out.left_out = std::sqrt(squares / static_cast<double>(points.size()));
  for (size_t i = 0; i < n; ++i) out.ns.push_back(scaled[i] / scale[i]);
  return out;
}

// The first `allowed` terms that every point counts.
std::vector<size_t> counted_terms(const std::vector<CostPoint>& points, size_t allowed) {
  std::vector<size_t> out;
  for (size_t t = 0; t < allowed; ++t)
    if (std::all_of(points.begin(), points.end(), [&](const CostPoint& point) { return point.counts[t].has_value(); }))
      out.push_back(t);
  return out;
}

std::vector<CostPoint> thinned(std::vector<CostPoint> points) {
  if (points.size() <= kMostPoints) return points;
  std::vector<CostPoint> out;
  for (size_t i = 0; i < kMostPoints; ++i) out.push_back(points[i * points.size() / kMostPoints]);
  return out;
}

// By the angles under which the others are seen: where they leave half a turn or more open, one of them or a line
// between two of them has to be where the point is.
bool is_between(const CostPoint& point, const std::vector<CostPoint>& others) {
  const auto place = [](const CostPoint& one) {
    return std::pair(std::log(std::max<double>(1, one.agents)), one.occupancy);
  };
  const auto [x, y] = place(point);
  std::vector<double> angles;
  for (const CostPoint& other : others) {
    if ((other.occupancy > 0) != (point.occupancy > 0)) continue;
    const auto [a, b] = place(other);
    if (a == x && b == y) return true;
    angles.push_back(std::atan2(b - y, a - x));
  }
  if (angles.size() < 2) return false;
  std::sort(angles.begin(), angles.end());
  double open = angles.front() + 2 * std::numbers::pi - angles.back();
  for (size_t i = 1; i < angles.size(); ++i) open = std::max(open, angles[i] - angles[i - 1]);
  return open <= std::numbers::pi + 1e-9;
}

std::optional<double> as_double(const std::optional<uint64_t>& value) {
  return value ? std::optional(static_cast<double>(*value)) : std::nullopt;
}

}  // namespace

const char* cost_term_name(CostTerm term) {
  static constexpr const char* kNames[] = {"frame",      "agents",    "covered_px",      "fine_px",
                                           "touched_px", "fragments", "vertices_shaded", "primitives"};
  return kNames[static_cast<size_t>(term)];
}

std::string cost_term_text(CostTerm term) {
  static constexpr const char* kTexts[] = {
      "a frame",         "an agent",
      "a covered pixel", "a covered pixel times ln(figures that would fill the picture)",
      "a touched pixel", "a fragment",
      "a vertex",        "a primitive"};
  return kTexts[static_cast<size_t>(term)];
}

double fine_pixels(double picture_px, double agents, double covered_px) {
  if (!(agents > 0 && covered_px > 0)) return 0;
  return covered_px * std::log(std::max(1.0, picture_px * agents / covered_px));
}

std::vector<CostPoint> cost_points(const Scene& scene, const std::string& representation) {
  std::vector<CostPoint> out;
  for (const MeasurementRow* row : scene.rows) {
    if (row->key.representation != representation || !is_timed(*row)) continue;
    const std::optional<TimeSummary>& time = time_of(*row, scene.run->headline);
    if (!time || !(time->median > 0)) continue;
    std::optional<double> fine;
    if (row->reference_px)
      fine = fine_pixels(static_cast<double>(row->key.width) * row->key.height, row->key.agents,
                         static_cast<double>(*row->reference_px));
    out.push_back(
        {row->key.agents,
         row->key.requested_occupancy,
         time->median,
         {1.0, static_cast<double>(row->key.agents), as_double(row->reference_px), fine, as_double(row->touched_px),
          as_double(row->fragments), as_double(row->vertices_shaded), as_double(row->primitives)}});
  }
  std::sort(out.begin(), out.end(), [](const CostPoint& a, const CostPoint& b) {
    return std::pair(a.agents, a.occupancy) < std::pair(b.agents, b.occupancy);
  });
  return out;
}

std::optional<CostFit> fit_cost(const std::vector<CostPoint>& points, size_t allowed) {
  if (points.size() < kLeastPoints) return std::nullopt;
  const std::vector<size_t> counted = counted_terms(points, allowed);
  std::vector<size_t> best;
  std::optional<Solved> solved;
  for (uint32_t mask = 1; mask < (1U << counted.size()); ++mask) {
    const auto size = static_cast<size_t>(std::popcount(mask));
    if (2 * size > points.size()) continue;  // two points a coefficient at least
    std::vector<size_t> subset;
    for (size_t t = 0; t < counted.size(); ++t)
      if (mask & (1U << t)) subset.push_back(counted[t]);
    const std::optional<Solved> one = solve(points, subset);
    // Errors that rounding alone makes are equal.
    if (!one || (solved && one->left_out > solved->left_out * (1 - 1e-6) - 1e-12)) {
      if (!one || subset.size() >= best.size() || one->left_out > solved->left_out * (1 + 1e-6) + 1e-12) continue;
    }
    solved = one;
    best = subset;
  }
  if (!solved) return std::nullopt;
  CostFit fit;
  fit.held_out = solved->left_out;
  for (size_t i = 0; i < best.size(); ++i) fit.terms.push_back({static_cast<CostTerm>(best[i]), solved->ns[i]});
  return fit;
}

double predicted_ns(const CostFit& fit, const CostPoint& point) {
  double sum = 0;
  for (const CostCoefficient& term : fit.terms)
    sum += term.ns * point.counts[static_cast<size_t>(term.term)].value_or(0);
  return sum;
}

CostModel cost_model(const Scene& scene, const std::string& representation, size_t allowed) {
  CostModel model;
  model.representation = representation;
  const std::vector<CostPoint> points = thinned(cost_points(scene, representation));
  // One more than a fit needs, so that each can be left out.
  if (points.size() <= kLeastPoints) {
    model.absent = "it was timed at " + counted(points.size(), "point", "points") + ", a model takes " +
                   std::to_string(kLeastPoints + 1) + " at least";
    return model;
  }
  const auto fit = fit_cost(points, allowed);
  const size_t folds = std::min(points.size(), kMostFolds);
  for (size_t fold = 0; fit && fold < folds; ++fold) {
    std::vector<CostPoint> others;
    for (size_t p = 0; p < points.size(); ++p)
      if (p % folds != fold) others.push_back(points[p]);
    const auto without = fit_cost(others, allowed);
    for (size_t p = fold; without && p < points.size(); p += folds) {
      model.held_out.push_back({points[p], predicted_ns(*without, points[p]), is_between(points[p], others)});
      if (std::abs(model.held_out.back().predicted_ns / points[p].time_ns - 1) <= 0.15) ++model.within_15;
    }
  }
  if (!fit || model.held_out.size() < points.size()) {
    model.held_out.clear();
    model.within_15 = 0;
    model.absent = "its points do not tell any of the terms apart";
    return model;
  }
  model.fit = *fit;
  const auto n = static_cast<double>(points.size());
  double squares = 0;
  double squares_between = 0;
  for (const CostPrediction& one : model.held_out) {
    const double error = one.predicted_ns / one.point.time_ns - 1;
    squares += error * error;
    if (!one.between) continue;
    ++model.between;
    model.between_within_15 += std::abs(error) <= 0.15 ? 1 : 0;
    squares_between += error * error;
  }
  model.error = std::sqrt(squares / n);
  if (model.between > 0) model.between_error = std::sqrt(squares_between / static_cast<double>(model.between));
  const auto k = static_cast<double>(model.within_15);
  model.within_share = {k > 0 ? beta_quantile(0.025, k, n - k + 1) : 0, k < n ? beta_quantile(0.975, k + 1, n - k) : 1};
  return model;
}

}  // namespace crowdbench::reports
