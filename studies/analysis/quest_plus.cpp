// Based on: Watson, "QUEST+: A general multidimensional Bayesian adaptive psychometric method" (2017).
#include "studies/analysis/quest_plus.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/probability.h"

namespace crowdbench::studies {
namespace {

double xlogx(double x) { return x > 0 ? x * std::log(x) : 0; }

double curve_at(QuestFunction function, double x, double threshold, double slope) {
  if (function == QuestFunction::normal) return normal_cdf((x - threshold) / slope);
  if (function == QuestFunction::logistic) return 1 / (1 + std::exp(-(x - threshold) / slope));
  const double scale = function == QuestFunction::weibull_db ? 20 : 1;
  return -std::expm1(-std::pow(10, slope * (x - threshold) / scale));
}

}  // namespace

QuestPlus::QuestPlus(const QuestSettings& s)
    : grid_{s.threshold, s.slope, s.guess, s.lapse}, stimuli_(s.stimuli.size()) {
  points_ = 1;
  for (const std::vector<double>& values : grid_) points_ *= values.size();
  assert(points_ > 0 && stimuli_ > 0);
  posterior_.assign(points_, 1.0 / static_cast<double>(points_));
  for (const double x : s.stimuli)
    for (size_t i = 0; i < points_; ++i) {
      const auto value = [&](size_t parameter) { return grid_[parameter][index_of(i, parameter)]; };
      const double rising = curve_at(s.function, x, value(0), value(1));
      const double p = value(2) + (1 - value(2) - value(3)) * (s.falling ? 1 - rising : rising);
      yes_.push_back(p);
      yes_log_.push_back(xlogx(p));
      no_log_.push_back(xlogx(1 - p));
    }
}

size_t QuestPlus::index_of(size_t point, size_t parameter) const {
  for (size_t last = grid_.size() - 1; last > parameter; --last) point /= grid_[last].size();
  return point % grid_[parameter].size();
}

std::vector<double> QuestPlus::expected_entropies() const {
  std::vector<double> logs(points_);  // p log p of the posterior, over p
  for (size_t i = 0; i < points_; ++i) logs[i] = posterior_[i] > 0 ? std::log(posterior_[i]) : 0;
  std::vector<double> out;
  for (size_t s = 0; s < stimuli_; ++s) {
    // p(answer) times the entropy of the posterior after it, summed over both, is made of these sums.
    double yes = 0;
    double sum = 0;
    for (size_t i = 0; i < points_; ++i) {
      const size_t at = s * points_ + i;
      yes += posterior_[i] * yes_[at];
      sum += posterior_[i] * (logs[i] + yes_log_[at] + no_log_[at]);
    }
    out.push_back(xlogx(yes) + xlogx(1 - yes) - sum);
  }
  return out;
}

QuestPlus::Choice QuestPlus::next() const {
  const std::vector<double> entropies = expected_entropies();
  const auto best = std::min_element(entropies.begin(), entropies.end());
  return {static_cast<size_t>(best - entropies.begin()), *best};
}

template <typename Likelihood>
void QuestPlus::update(const Likelihood& of_yes, bool yes) {
  std::vector<double> after(points_);
  double total = 0;
  for (size_t i = 0; i < points_; ++i) {
    const double p = of_yes(i);
    total += after[i] = posterior_[i] * (yes ? p : 1 - p);
  }
  if (!(total > 0)) return;
  for (size_t i = 0; i < points_; ++i) posterior_[i] = after[i] / total;
}

void QuestPlus::answer(size_t stimulus, bool yes) {
  update([&](size_t point) { return psi(stimulus, point); }, yes);
}

void QuestPlus::answer_to_nothing(bool yes) {
  update([&](size_t point) { return grid_[2][index_of(point, 2)]; }, yes);
}

QuestPlus::Parameters QuestPlus::mean() const {
  Parameters out{};
  for (size_t i = 0; i < points_; ++i)
    for (size_t p = 0; p < grid_.size(); ++p) out[p] += posterior_[i] * grid_[p][index_of(i, p)];
  return out;
}

QuestPlus::Parameters QuestPlus::sd() const {
  const Parameters middle = mean();
  Parameters out{};
  for (size_t i = 0; i < points_; ++i)
    for (size_t p = 0; p < grid_.size(); ++p) {
      const double d = grid_[p][index_of(i, p)] - middle[p];
      out[p] += posterior_[i] * d * d;
    }
  for (double& variance : out) variance = std::sqrt(variance);
  return out;
}

QuestPlus::Parameters QuestPlus::mode() const {
  const auto at = static_cast<size_t>(std::max_element(posterior_.begin(), posterior_.end()) - posterior_.begin());
  Parameters out{};
  for (size_t p = 0; p < grid_.size(); ++p) out[p] = grid_[p][index_of(at, p)];
  return out;
}

std::vector<double> QuestPlus::marginal(size_t parameter) const {
  std::vector<double> out(grid_[parameter].size(), 0);
  for (size_t i = 0; i < points_; ++i) out[index_of(i, parameter)] += posterior_[i];
  return out;
}

double QuestPlus::entropy() const {
  double sum = 0;
  for (const double p : posterior_) sum -= xlogx(p);
  return sum;
}

}  // namespace crowdbench::studies
