// Based on: Bradley and Terry, "Rank analysis of incomplete block designs" (1952); Lindley, "On a measure of the
// information provided by an experiment" (1956); the mode and curvature in place of the posterior, as Laplace's method.
// studies/page/adaptive.js computes the same, step by step.
#include "studies/analysis/active_pairs.h"

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "studies/analysis/dense.h"

namespace crowdbench::studies {
namespace {

constexpr int kMostSteps = 100;
constexpr double kLongestStep = 1;  // of Newton's, in logits: far from the mode the curvature misleads
constexpr double kReached = 1e-12;
// The integral over a standard normal number, by the trapezoid rule, which is all but exact for what decays so fast.
constexpr int kNodes = 41;
constexpr double kFarthestNode = 5;

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

// Of a yes or no, in nats.
double entropy(double p) { return p > 0 && p < 1 ? -p * std::log(p) - (1 - p) * std::log1p(-p) : 0; }

}  // namespace

PairBelief pair_belief(std::span<const PairAnswer> answers, size_t items) {
  const auto n = static_cast<Eigen::Index>(items);
  const double precision = 1 / (kWorthSd * kWorthSd);
  Eigen::VectorXd worth = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd covariance;
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::VectorXd gradient = -precision * worth;
    Eigen::MatrixXd information = precision * Eigen::MatrixXd::Identity(n, n);
    for (const PairAnswer& answer : answers) {
      assert(answer.a != answer.b && answer.a < items && answer.b < items);
      const auto a = static_cast<Eigen::Index>(answer.a);
      const auto b = static_cast<Eigen::Index>(answer.b);
      const double p = logistic(worth[a] - worth[b]);
      gradient[a] += answer.a_won - p;
      gradient[b] -= answer.a_won - p;
      const double weight = p * (1 - p);
      information(a, a) += weight;
      information(b, b) += weight;
      information(a, b) -= weight;
      information(b, a) -= weight;
    }
    covariance = dense::inverse(information);
    Eigen::VectorXd move = dense::product(covariance, gradient);
    const double longest = move.cwiseAbs().maxCoeff();
    if (longest > kLongestStep) move *= kLongestStep / longest;
    if (longest < kReached) break;
    worth += move;
  }
  PairBelief out;
  for (Eigen::Index i = 0; i < n; ++i) {
    out.mean.push_back(worth[i]);
    out.covariance.emplace_back();
    for (Eigen::Index j = 0; j < n; ++j) out.covariance.back().push_back(covariance(i, j));
  }
  return out;
}

double expected_information(const PairBelief& belief, size_t a, size_t b) {
  const auto& c = belief.covariance;
  const double mean = belief.mean[a] - belief.mean[b];
  const double sd = std::sqrt(std::max(0.0, c[a][a] + c[b][b] - 2 * c[a][b]));
  double total = 0;
  double yes = 0;
  double known = 0;  // what of the answer's entropy stays where the worths are known
  for (int k = 0; k < kNodes; ++k) {
    const double z = kFarthestNode * (2.0 * k / (kNodes - 1) - 1);
    const double weight = std::exp(-z * z / 2);
    const double p = logistic(mean + sd * z);
    total += weight;
    yes += weight * p;
    known += weight * entropy(p);
  }
  return entropy(yes / total) - known / total;
}

}  // namespace crowdbench::studies
