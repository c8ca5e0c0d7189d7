#include "core/change_points.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "core/probability.h"

namespace crowdbench {
namespace {

struct Stretch {
  size_t from = 0, to = 0;  // [from, to)
};
struct Candidate {
  size_t index = 0;
  double divergence = 0;
};

struct Moments {
  double mean = 0;
  double variance = 0;  // divided by n: see the header
};
Moments moments_of(std::span<const double> values) {
  Moments out;
  const auto n = static_cast<double>(values.size());
  // From the first value on, so that equal values have exactly no variance.
  double above_first = 0;
  for (const double value : values) above_first += value - values.front();
  out.mean = values.front() + above_first / n;
  for (const double value : values) out.variance += (value - out.mean) * (value - out.mean) / n;
  return out;
}

double ratio_change(double a, double b) { return b == 0 ? 0 : std::abs(a / b - 1); }

ChangePoint judged(std::span<const double> values, const Stretch& around, size_t index) {
  const std::span<const double> before = values.subspan(around.from, index - around.from);
  const std::span<const double> after = values.subspan(index, around.to - index);
  const Moments a = moments_of(before);
  const Moments b = moments_of(after);
  ChangePoint point;
  point.index = index;
  point.mean_before = a.mean;
  point.mean_after = b.mean;
  point.magnitude = std::max(ratio_change(b.mean, a.mean), ratio_change(a.mean, b.mean));
  const auto n = static_cast<double>(before.size());
  const auto m = static_cast<double>(after.size());
  if (n + m <= 2) return point;
  const double pooled = ((n - 1) * a.variance + (m - 1) * b.variance) / (n + m - 2);
  const double difference = b.mean - a.mean;
  if (pooled > 0)
    point.p = student_t_two_sided(difference / std::sqrt(pooled * (1 / n + 1 / m)), n + m - 2);
  else if (difference != 0)
    point.p = 0;
  return point;
}

// The split of the largest divergence of z[from..t) and z[t..k), for every t and every k up to the stretch's end; the
// first of equals, by t and then by k.
std::optional<Candidate> best_split(std::span<const double> values, const Stretch& stretch) {
  const size_t size = stretch.to - stretch.from;
  if (size < 2) return std::nullopt;
  const std::span<const double> z = values.subspan(stretch.from, size);
  std::optional<Candidate> best;
  double inside_left = 0;  // sum of distances of the pairs in z[0..t)
  for (size_t t = 1; t < size; ++t) {
    for (size_t i = 0; i + 1 < t; ++i) inside_left += std::abs(z[i] - z[t - 1]);
    double across = 0;
    double inside_right = 0;
    for (size_t k = t + 1; k <= size; ++k) {
      for (size_t i = 0; i < t; ++i) across += std::abs(z[i] - z[k - 1]);
      for (size_t i = t; i + 1 < k; ++i) inside_right += std::abs(z[i] - z[k - 1]);
      const auto n = static_cast<double>(t);
      const auto m = static_cast<double>(k - t);
      double q = 2 / (n + m) * across;
      if (t > 1) q -= 2 * m / ((n + m) * (n - 1)) * inside_left;
      if (k > t + 1) q -= 2 * n / ((n + m) * (m - 1)) * inside_right;
      if (!best || q > best->divergence) best = Candidate{stretch.from + t, q};
    }
  }
  return best;
}

// Splits until the best split left is not significant. By ascending index.
std::vector<size_t> detect(std::span<const double> values, double level) {
  std::vector<Stretch> stretches = {{0, values.size()}};
  std::vector<std::optional<Candidate>> bests = {best_split(values, stretches.front())};
  std::vector<size_t> found;
  while (true) {
    size_t chosen = bests.size();
    for (size_t i = 0; i < bests.size(); ++i)
      if (bests[i] && (chosen == bests.size() || bests[i]->divergence > bests[chosen]->divergence)) chosen = i;
    if (chosen == bests.size()) break;
    const size_t index = bests[chosen]->index;
    if (judged(values, stretches[chosen], index).p > level) break;
    found.push_back(index);
    const auto place = static_cast<ptrdiff_t>(chosen);
    const Stretch right{index, stretches[chosen].to};
    stretches[chosen].to = index;
    bests[chosen] = best_split(values, stretches[chosen]);
    bests.insert(bests.begin() + place + 1, best_split(values, right));
    stretches.insert(stretches.begin() + place + 1, right);
  }
  std::sort(found.begin(), found.end());
  return found;
}

double first_pass_level(double max_p) { return max_p < 0.05 ? 10 * max_p : max_p < 0.5 ? 2 * max_p : max_p; }

// The stretch between the neighbours of points[i].
Stretch around(const std::vector<ChangePoint>& points, size_t i, size_t size) {
  return {i == 0 ? 0 : points[i - 1].index, i + 1 == points.size() ? size : points[i + 1].index};
}

}  // namespace

std::vector<ChangePoint> weak_change_points(std::span<const double> values, const ChangePointOptions& options) {
  assert(options.window >= 2);
  std::vector<size_t> found;
  for (size_t start = 0; start < values.size();) {
    const size_t end = std::min(values.size(), start + options.window);
    size_t last = 0;
    for (const size_t index : detect(values.subspan(start, end - start), first_pass_level(options.max_p))) {
      last = start + index;
      if (std::find(found.begin(), found.end(), last) == found.end()) found.push_back(last);
    }
    start = std::max(last, start + options.window / 2);
  }
  std::sort(found.begin(), found.end());
  std::vector<ChangePoint> points(found.size());
  for (size_t i = 0; i < found.size(); ++i) points[i].index = found[i];
  for (size_t i = 0; i < points.size(); ++i)
    points[i] = judged(values, around(points, i, values.size()), points[i].index);
  return points;
}

std::vector<ChangePoint> change_points(std::span<const double> values, const ChangePointOptions& options) {
  std::vector<ChangePoint> points = weak_change_points(values, options);
  while (!points.empty()) {
    auto weakest =
        std::max_element(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.p < b.p; });
    if (weakest->p < options.max_p) {
      weakest = std::min_element(points.begin(), points.end(),
                                 [](const auto& a, const auto& b) { return a.magnitude < b.magnitude; });
      if (weakest->magnitude > options.min_magnitude) break;
    }
    const auto gap = static_cast<size_t>(weakest - points.begin());
    points.erase(weakest);
    for (const size_t i : {gap - 1, gap})  // gap - 1 wraps round where there is none before
      if (i < points.size()) points[i] = judged(values, around(points, i, values.size()), points[i].index);
  }
  return points;
}

}  // namespace crowdbench
