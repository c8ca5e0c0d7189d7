// Based on: Davidson, "On extending the Bradley-Terry model to accommodate ties in paired comparison experiments"
// (1970); Davidson and Beaver (1977) for order; Ford, "Solution of a ranking problem from binary comparisons" (1957)
// for when worths are finite. The likelihood is that of a multinomial logit and concave: Newton's method with step
// halving finds its one maximum, and the curvature is the expected information.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "studies/analysis/dense.h"
#include "studies/analysis/paired_comparison.h"

namespace crowdbench::studies {
namespace {

constexpr double kFarthest = 30;  // a parameter beyond it has no finite estimate

// The unknowns as one vector: log-worths of items 1 and on against item 0, then log_nu, then position.
class Davidson {
 public:
  Davidson(std::span<const Comparison> comparisons, size_t items, bool ties, bool position)
      : comparisons_(comparisons), items_(items), ties_(ties), position_(position) {}

  Eigen::Index count() const { return static_cast<Eigen::Index>(items_ - 1 + (ties_ ? 1 : 0) + (position_ ? 1 : 0)); }
  Eigen::Index nu() const { return static_cast<Eigen::Index>(items_ - 1); }
  Eigen::Index place() const { return nu() + (ties_ ? 1 : 0); }

  double value(const Eigen::VectorXd& v, Eigen::VectorXd* gradient, Eigen::MatrixXd* information) const {
    double sum = 0;
    if (gradient != nullptr) gradient->setZero(count());
    if (information != nullptr) information->setZero(count(), count());
    Outcome outcomes[3];
    for (const Comparison& c : comparisons_) {
      fill(c, outcomes);
      sum += add(c, outcomes, v, gradient, information);
    }
    return sum;
  }

 private:
  // What of the unknowns an outcome's log odds are made of: at most four.
  struct Outcome {
    std::array<std::pair<Eigen::Index, double>, 4> terms;
    size_t used = 0;
    void put(Eigen::Index i, double by) { terms[used++] = {i, by}; }
    double dot(const Eigen::VectorXd& v) const {
      double out = 0;
      for (size_t k = 0; k < used; ++k) out += terms[k].second * v[terms[k].first];
      return out;
    }
  };
  void put_worth(Outcome& o, uint32_t item, double by) const {
    if (item > 0) o.put(static_cast<Eigen::Index>(item) - 1, by);
  }
  void fill(const Comparison& c, Outcome (&out)[3]) const {
    for (Outcome& o : out) o.used = 0;
    put_worth(out[0], c.a, 1);
    put_worth(out[1], c.b, 1);
    if (position_) out[*c.a_is_first ? 0 : 1].put(place(), 1);
    if (!ties_) return;
    put_worth(out[2], c.a, 0.5);
    put_worth(out[2], c.b, 0.5);
    out[2].put(nu(), 1);
  }
  double add(const Comparison& c, const Outcome (&outcomes)[3], const Eigen::VectorXd& v, Eigen::VectorXd* gradient,
             Eigen::MatrixXd* information) const {
    const size_t kinds = ties_ ? 3 : 2;
    const std::array<double, 3> counts = {static_cast<double>(c.a_wins), static_cast<double>(c.b_wins),
                                          ties_ ? static_cast<double>(c.ties) : 0};
    const double n = counts[0] + counts[1] + counts[2];
    std::array<double, 3> odds{};
    double top = -1e300;
    for (size_t k = 0; k < kinds; ++k) top = std::max(top, odds[k] = outcomes[k].dot(v));
    double total = 0;
    for (size_t k = 0; k < kinds; ++k) total += std::exp(odds[k] - top);
    double sum = 0;
    Eigen::VectorXd mean;
    if (information != nullptr) mean = Eigen::VectorXd::Zero(count());
    for (size_t k = 0; k < kinds; ++k) {
      const double p = std::exp(odds[k] - top) / total;
      sum += counts[k] * (odds[k] - top - std::log(total));
      const Outcome& o = outcomes[k];
      for (size_t i = 0; i < o.used; ++i) {
        if (gradient != nullptr) (*gradient)[o.terms[i].first] += (counts[k] - n * p) * o.terms[i].second;
        if (information == nullptr) continue;
        mean[o.terms[i].first] += p * o.terms[i].second;
        for (size_t j = 0; j < o.used; ++j)
          (*information)(o.terms[i].first, o.terms[j].first) += n * p * o.terms[i].second * o.terms[j].second;
      }
    }
    if (information != nullptr) *information -= n * mean * mean.transpose();
    return sum;
  }

  std::span<const Comparison> comparisons_;
  size_t items_;
  bool ties_;
  bool position_;
};

// What is reached from `from` along the relation.
std::vector<bool> reached(const std::vector<std::vector<bool>>& relation, size_t from) {
  std::vector<bool> out(relation.size(), false);
  std::vector<size_t> open = {from};
  out[from] = true;
  while (!open.empty()) {
    const size_t at = open.back();
    open.pop_back();
    for (size_t to = 0; to < relation.size(); ++to)
      if (relation[at][to] && !out[to]) {
        out[to] = true;
        open.push_back(to);
      }
  }
  return out;
}

WorthState state_of(std::span<const Comparison> comparisons, size_t items, bool with_position, Worths& out) {
  std::vector<std::vector<bool>> compared(items, std::vector<bool>(items, false));
  std::vector<std::vector<bool>> beat = compared;
  uint64_t wins = 0;
  uint64_t first_wins = 0;
  uint64_t answers = 0;
  for (const Comparison& c : comparisons) {
    assert(c.a != c.b && c.a < items && c.b < items && (!with_position || c.a_is_first));
    const uint64_t n = c.a_wins + c.ties + c.b_wins;
    answers += n;
    wins += c.a_wins + c.b_wins;
    if (n > 0) compared[c.a][c.b] = compared[c.b][c.a] = true;
    if (c.a_wins + c.ties > 0) beat[c.a][c.b] = true;
    if (c.b_wins + c.ties > 0) beat[c.b][c.a] = true;
    if (with_position) first_wins += *c.a_is_first ? c.a_wins : c.b_wins;
  }
  if (answers == 0 || items < 2) return WorthState::no_data;
  out.groups = connected_groups(compared);
  if (out.groups.size() > 1) return WorthState::disconnected;
  out.groups = comparable_groups(beat);
  if (out.groups.size() > 1) return WorthState::unbeaten;
  if (wins == 0) return WorthState::all_ties;
  return with_position && (first_wins == 0 || first_wins == wins) ? WorthState::one_position : WorthState::fitted;
}

}  // namespace

std::string_view state_text(WorthState state) {
  switch (state) {
    case WorthState::fitted: return "fitted";
    case WorthState::no_data: return "no data";
    case WorthState::disconnected: return "not connected";
    case WorthState::unbeaten: return "unbeaten items";
    case WorthState::all_ties: return "ties alone";
    case WorthState::one_position: break;
  }
  return "one position always wins";
}

std::vector<std::vector<uint32_t>> connected_groups(const std::vector<std::vector<bool>>& compared) {
  std::vector<std::vector<uint32_t>> out;
  std::vector<bool> done(compared.size(), false);
  for (size_t i = 0; i < compared.size(); ++i) {
    if (done[i]) continue;
    const std::vector<bool> group = reached(compared, i);
    out.emplace_back();
    for (size_t j = 0; j < group.size(); ++j)
      if (group[j]) {
        done[j] = true;
        out.back().push_back(static_cast<uint32_t>(j));
      }
  }
  return out;
}

std::vector<std::vector<uint32_t>> comparable_groups(const std::vector<std::vector<bool>>& beat_or_tied) {
  const size_t n = beat_or_tied.size();
  std::vector<std::vector<bool>> reach(n);
  for (size_t i = 0; i < n; ++i) reach[i] = reached(beat_or_tied, i);
  std::vector<std::vector<uint32_t>> out;
  std::vector<bool> done(n, false);
  for (size_t i = 0; i < n; ++i) {
    if (done[i]) continue;
    out.emplace_back();
    for (size_t j = i; j < n; ++j)
      if (reach[i][j] && reach[j][i]) {
        done[j] = true;
        out.back().push_back(static_cast<uint32_t>(j));
      }
  }
  // Who reaches more stands higher: a group that beats another reaches all that it does.
  std::stable_sort(out.begin(), out.end(), [&](const auto& a, const auto& b) {
    return std::count(reach[a[0]].begin(), reach[a[0]].end(), true) >
           std::count(reach[b[0]].begin(), reach[b[0]].end(), true);
  });
  return out;
}

Worths fit_worths(std::span<const Comparison> comparisons, size_t items, bool with_position) {
  Worths out;
  out.state = state_of(comparisons, items, with_position, out);
  if (out.state != WorthState::fitted) return out;
  const bool ties = std::any_of(comparisons.begin(), comparisons.end(), [](const Comparison& c) { return c.ties > 0; });
  const Davidson model(comparisons, items, ties, with_position);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(model.count());
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
  double value = model.value(v, &gradient, &information);
  for (int i = 0; i < 200; ++i) {
    const Eigen::VectorXd step = dense::solve_symmetric(information, gradient);
    const double promised = step.dot(gradient);
    double part = 1;
    double there = model.value(v + step, nullptr, nullptr);
    while (part > 1e-9 && !(there >= value - 1e-12 * std::fabs(value)))
      there = model.value(v + (part /= 2) * step, nullptr, nullptr);
    v += part * step;
    value = model.value(v, &gradient, &information);
    if (v.cwiseAbs().maxCoeff() > kFarthest) {
      out.state = with_position ? WorthState::one_position : WorthState::unbeaten;
      return out;
    }
    if (promised < 1e-18) break;
  }
  const Eigen::MatrixXd covariance = dense::inverse(information);
  // From differences to item 0 to differences to the mean.
  const auto n = static_cast<Eigen::Index>(items);
  Eigen::MatrixXd centre = Eigen::MatrixXd::Constant(n, n - 1, -1.0 / static_cast<double>(items));
  for (Eigen::Index i = 0; i + 1 < n; ++i) centre(i + 1, i) += 1;
  const Eigen::VectorXd worth = dense::product(centre, v.head(n - 1));
  const Eigen::MatrixXd spread =
      dense::product(dense::product(centre, covariance.topLeftCorner(n - 1, n - 1)), centre.transpose());
  const double total = worth.array().exp().sum();
  out.covariance.resize(items, std::vector<double>(items));
  for (Eigen::Index i = 0; i < n; ++i) {
    out.log_worth.push_back(worth[i]);
    out.se.push_back(std::sqrt(spread(i, i)));
    out.worth.push_back(std::exp(worth[i]) / total);
    for (Eigen::Index j = 0; j < n; ++j) out.covariance[static_cast<size_t>(i)][static_cast<size_t>(j)] = spread(i, j);
  }
  if (ties) {
    out.log_nu = v[model.nu()];
    out.log_nu_se = std::sqrt(covariance(model.nu(), model.nu()));
  }
  if (with_position) {
    out.position = v[model.place()];
    out.position_se = std::sqrt(covariance(model.place(), model.place()));
  }
  out.log_likelihood = value;
  return out;
}

Difference difference_of(const Worths& worths, size_t a, size_t b) {
  assert(worths.state == WorthState::fitted);
  const auto& c = worths.covariance;
  return {worths.log_worth[a] - worths.log_worth[b], std::sqrt(std::max(0.0, c[a][a] + c[b][b] - 2 * c[a][b]))};
}

}  // namespace crowdbench::studies
