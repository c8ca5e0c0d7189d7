// Based on: Perez-Ortiz and Mantiuk, "A practical guide and software for analysing pairwise comparison experiments"
// (2017): the scale, the likelihood that counts every pair from both sides, the hair of a penalty that sets the mean to
// 0, and the prior of "gaussian". Differs: items that were not joined by comparisons are refused, not joined by made-up
// wins.
#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/probability.h"
#include "core/random.h"
#include "studies/analysis/dense.h"
#include "studies/analysis/optimise.h"
#include "studies/analysis/paired_comparison.h"

namespace crowdbench::studies {
namespace {

constexpr double kSigma = 1.4826;     // 1 / z(.75), rounded as pwcmp has it
constexpr double kMeanWeight = 0.01;  // of mean(q)^2
constexpr double kPriorFloor = 0.1;
constexpr uint64_t kDrawPurpose = 0x6a6f64;

// i against j, once from either side.
struct Ordered {
  size_t i = 0;
  size_t j = 0;
  double k = 0;  // times that i was chosen
  double n = 0;
};

std::vector<Ordered> ordered_pairs(const Wins& wins) {
  std::vector<Ordered> out;
  for (size_t i = 0; i < wins.size(); ++i)
    for (size_t j = 0; j < wins.size(); ++j)
      if (i != j && wins[i][j] + wins[j][i] > 0) out.push_back({i, j, wins[i][j], wins[i][j] + wins[j][i]});
  return out;
}

// log Phi(z), and its slope.
struct LogPhi {
  double value = 0;
  double slope = 0;
};
LogPhi log_phi(double z) {
  const double value = log_normal_cdf(z);
  return {value, std::exp(-z * z / 2 - std::log(2 * std::numbers::pi) / 2 - value)};
}

// Minus the log of the prior, and what it adds to the slopes dz by pair: for every pair a, .1 and the chance that its
// difference is the one behind the answers to each pair b, were all pairs' differences equally likely.
double prior_term(const std::vector<Ordered>& pairs, const std::vector<double>& z, std::vector<double>& dz) {
  const size_t m = pairs.size();
  Eigen::MatrixXd chance(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(m));  // (a, b)
  Eigen::MatrixXd slope = chance;
  std::vector<LogPhi> up(m);
  std::vector<LogPhi> down(m);
  for (size_t a = 0; a < m; ++a) {
    up[a] = log_phi(z[a]);
    down[a] = log_phi(-z[a]);
  }
  for (size_t b = 0; b < m; ++b) {
    const double n = pairs[b].n;
    double k = pairs[b].k;
    if (k == 0)
      k = 1;
    else if (k == n)
      k = n - 1;
    const auto column = static_cast<Eigen::Index>(b);
    for (size_t a = 0; a < m; ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      chance(row, column) = k * up[a].value + (n - k) * down[a].value;
      slope(row, column) = k * up[a].slope - (n - k) * down[a].slope;
    }
    chance.col(column).array() -= chance.col(column).maxCoeff();
    chance.col(column) = chance.col(column).array().exp();
    chance.col(column) /= chance.col(column).sum();
  }
  const Eigen::VectorXd sums = chance.rowwise().sum().array() + kPriorFloor;
  const Eigen::VectorXd weight = sums.cwiseInverse();
  const Eigen::RowVectorXd mean = dense::product(weight.transpose(), chance);  // by b
  for (size_t a = 0; a < m; ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    for (Eigen::Index b = 0; b < chance.cols(); ++b) dz[a] -= slope(row, b) * chance(row, b) * (weight[row] - mean[b]);
  }
  return -sums.array().log().sum();
}

// The doubled likelihood with the hair of a penalty, and the prior if there is one.
double objective_of(const std::vector<Ordered>& pairs, JodPrior prior, std::span<const double> q,
                    std::span<double> gradient) {
  const auto items = static_cast<double>(q.size());
  double sum = 0;
  std::vector<double> z(pairs.size());
  std::vector<double> dz(pairs.size(), 0);
  for (size_t a = 0; a < pairs.size(); ++a) {
    z[a] = (q[pairs[a].i] - q[pairs[a].j]) / kSigma;
    const LogPhi up = log_phi(z[a]);
    const LogPhi down = log_phi(-z[a]);
    sum -= pairs[a].k * up.value + (pairs[a].n - pairs[a].k) * down.value;
    dz[a] -= pairs[a].k * up.slope - (pairs[a].n - pairs[a].k) * down.slope;
  }
  if (prior == JodPrior::gaussian) sum += prior_term(pairs, z, dz);
  double mean = 0;
  for (const double each : q) mean += each / items;
  std::fill(gradient.begin(), gradient.end(), 2 * kMeanWeight * mean / items);
  for (size_t a = 0; a < pairs.size(); ++a) {
    gradient[pairs[a].i] += dz[a] / kSigma;
    gradient[pairs[a].j] -= dz[a] / kSigma;
  }
  return sum + kMeanWeight * mean * mean;
}

// Standard errors of q_i - q_0 by the expected information.
std::vector<double> errors_of(const std::vector<Ordered>& pairs, const std::vector<double>& q) {
  const auto n = static_cast<Eigen::Index>(q.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (const Ordered& p : pairs) {
    if (p.i > p.j) continue;  // once a pair
    const double z = (q[p.i] - q[p.j]) / kSigma;
    const double density = normal_density(z) / kSigma;
    const double w = p.n * density * density / (normal_cdf(z) * normal_cdf(-z));
    const auto i = static_cast<Eigen::Index>(p.i);
    const auto j = static_cast<Eigen::Index>(p.j);
    information(i, i) += w;
    information(j, j) += w;
    information(i, j) -= w;
    information(j, i) -= w;
  }
  const Eigen::MatrixXd covariance = dense::inverse(information.bottomRightCorner(n - 1, n - 1));
  std::vector<double> out = {0};
  for (Eigen::Index i = 0; i + 1 < n; ++i) out.push_back(std::sqrt(covariance(i, i)));
  return out;
}

WorthState state_of(const Wins& wins, JodPrior prior) {
  const size_t n = wins.size();
  std::vector<std::vector<bool>> compared(n, std::vector<bool>(n, false));
  std::vector<std::vector<bool>> beat = compared;
  bool any = false;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      compared[i][j] = wins[i][j] + wins[j][i] > 0;
      beat[i][j] = wins[i][j] > 0;
      any = any || beat[i][j];
    }
  if (!any || n < 2) return WorthState::no_data;
  if (connected_groups(compared).size() > 1) return WorthState::disconnected;
  if (prior == JodPrior::none && comparable_groups(beat).size() > 1) return WorthState::unbeaten;
  return WorthState::fitted;
}

}  // namespace

Jod fit_jod(const Wins& wins, JodPrior prior) {
  Jod out;
  out.state = state_of(wins, prior);
  if (out.state != WorthState::fitted) return out;
  const std::vector<Ordered> pairs = ordered_pairs(wins);
  const Minimum best = minimise_smooth(
      [&](std::span<const double> q, std::span<double> gradient) { return objective_of(pairs, prior, q, gradient); },
      std::vector<double>(wins.size(), 0));
  out.q = best.x;
  double mean = 0;
  for (const double q : out.q) mean += q / static_cast<double>(out.q.size());
  for (double& q : out.q) q -= mean;
  for (const Ordered& p : pairs) {
    const double z = (out.q[p.i] - out.q[p.j]) / kSigma;
    if (p.i < p.j) out.negative_log_likelihood -= p.k * log_normal_cdf(z) + (p.n - p.k) * log_normal_cdf(-z);
  }
  if (prior == JodPrior::none) out.se = errors_of(pairs, out.q);
  return out;
}

std::vector<std::vector<size_t>> bootstrap_draws(size_t observers, size_t n, uint64_t seed) {
  std::vector<std::vector<size_t>> out(n, std::vector<size_t>(observers));
  for (size_t r = 0; r < n; ++r)
    for (size_t i = 0; i < observers; ++i) out[r][i] = random_below(mix64(seed + kDrawPurpose), r, i, observers);
  return out;
}

JodIntervals bootstrap_jod(std::span<const Wins> observers, std::span<const std::vector<size_t>> draws, JodPrior prior,
                           double confidence) {
  assert(!observers.empty());
  const size_t items = observers[0].size();
  const auto sum_of = [&](const auto& indices) {
    Wins sum(items, std::vector<double>(items, 0));
    for (const size_t o : indices)
      for (size_t i = 0; i < items; ++i)
        for (size_t j = 0; j < items; ++j) sum[i][j] += observers[o][i][j];
    return sum;
  };
  std::vector<size_t> each(observers.size());
  for (size_t i = 0; i < each.size(); ++i) each[i] = i;
  const Jod whole = fit_jod(sum_of(each), prior);
  JodIntervals out;
  std::vector<std::vector<double>> values(items);
  for (const std::vector<size_t>& draw : draws) {
    const Jod fit = fit_jod(sum_of(draw), prior);
    if (fit.state != WorthState::fitted) {
      ++out.failed;
      continue;
    }
    for (size_t i = 0; i < items; ++i) values[i].push_back(fit.q[i]);
  }
  if (whole.state != WorthState::fitted || values[0].empty()) return out;
  const double tail = (1 - confidence) / 2;
  for (size_t i = 0; i < items; ++i) {
    out.q.push_back(
        {std::min(whole.q[i], quantile(values[i], tail)), std::max(whole.q[i], quantile(values[i], 1 - tail))});
  }
  return out;
}

}  // namespace crowdbench::studies
