// Based on: Bates, Maechler, Bolker and Walker, "Fitting linear mixed-effects models using lme4" (2015) and its
// vignette on generalised models for the scaling by spherical random effects and the two kinds of information; Pinheiro
// and Bates, "Approximations to the log-likelihood function in the nonlinear mixed-effects model" (1995) for adaptive
// quadrature.
#include "studies/analysis/mixed_likelihood.h"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "core/probability.h"
#include "studies/analysis/dense.h"

namespace crowdbench::studies {

const Quadrature& gauss_hermite_25() {
  // Golub and Welsch 1969: nodes are the eigenvalues of the recurrence's matrix, weights the squares of the first
  // components of its eigenvectors.
  static const Quadrature rule = [] {
    constexpr int n = 25;
    Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
    for (int i = 1; i < n; ++i) jacobi(i, i - 1) = jacobi(i - 1, i) = std::sqrt(static_cast<double>(i));
    const dense::Eigenpairs solved = dense::eigenpairs(jacobi);
    Quadrature out;
    for (int i = 0; i < n; ++i) {
      out.nodes.push_back(solved.values[i]);
      out.weights.push_back(solved.vectors(0, i) * solved.vectors(0, i));
    }
    return out;
  }();
  return rule;
}

namespace mixed {

Local local_at(Link link, double guess, double eta) {
  Local out;
  if (link == Link::logit) {
    const double f = logistic_cdf(eta);
    out.no = -log_one_plus_exp(eta);
    out.yes = out.no + eta;
    out.yes_1 = logistic_cdf(-eta);
    out.no_1 = -f;
    out.yes_2 = out.no_2 = -f * out.yes_1;
  } else {
    const double log_density = -eta * eta / 2 - std::log(2 * std::numbers::pi) / 2;
    out.yes = log_normal_cdf(eta);
    out.no = log_normal_cdf(-eta);
    out.yes_1 = std::exp(log_density - out.yes);
    out.no_1 = -std::exp(log_density - out.no);
    out.yes_2 = -out.yes_1 * (out.yes_1 + eta);
    out.no_2 = out.no_1 * (-out.no_1 - eta);
  }
  if (guess == 0) return out;
  // Guessing adds to "yes" alone: P(no) is scaled, which its derivatives do not see.
  const double f = std::exp(out.yes);
  const double p = guess + (1 - guess) * f;
  const double first = (1 - guess) * f * out.yes_1 / p;
  out.yes_2 = (1 - guess) * f * (out.yes_2 + out.yes_1 * out.yes_1) / p - first * first;
  out.yes_1 = first;
  out.yes = std::log(p);
  out.no += std::log1p(-guess);
  return out;
}

Likelihood::Likelihood(std::vector<MixedRow> rows, const MixedSettings& settings) : settings_(settings) {
  assert(!rows.empty());
  const auto key = [&](const MixedRow& r) { return std::tie(r.participant, r.clip, r.slope, r.fixed); };
  if (!settings.clips)
    for (MixedRow& row : rows) row.clip = 0;
  std::sort(rows.begin(), rows.end(), [&](const MixedRow& a, const MixedRow& b) { return key(a) < key(b); });
  for (MixedRow& row : rows) {
    if (row.of == 0) continue;
    clips_ = std::max(clips_, static_cast<size_t>(row.clip) + 1);
    if (!cells_.empty() && key(cells_.back()) == key(row)) {
      cells_.back().yes += row.yes;
      cells_.back().of += row.of;
      cells_.back().halves += row.halves;
    } else {
      cells_.push_back(std::move(row));
    }
  }
  for (size_t i = 0; i < cells_.size(); ++i)
    if (i == 0 || cells_[i].participant != cells_[i - 1].participant) participant_begin_.push_back(i);
  participant_begin_.push_back(cells_.size());
  fixed_part_.resize(cells_.size());
  mode_ = zero();
}

Likelihood::Random Likelihood::zero() const {
  return {std::vector<Pair>(participants(), Pair::Zero()), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(clips()))};
}

// What participant's u multiply in this cell. The second is idle where there is no slope.
Likelihood::Pair Likelihood::loading(size_t cell, const Scales& s) const {
  const double x = settings_.slopes ? cells_[cell].slope : 0;
  return {s.intercept + s.cross * x, s.slope * x};
}

double Likelihood::joint(const Scales& scales, const Random& u) const {
  double sum = -u.clip.squaredNorm() / 2;
  for (size_t p = 0; p < participants(); ++p) {
    sum -= u.participant[p].squaredNorm() / 2;
    for (size_t i = participant_begin_[p]; i < participant_begin_[p + 1]; ++i) {
      double e = fixed_part_[i] + loading(i, scales).dot(u.participant[p]);
      if (settings_.clips) e += scales.clip * u.clip[cells_[i].clip];
      const Local local = local_at(settings_.link, settings_.guess, e);
      if (const double yes = cells_[i].weight_of_yes(); yes > 0) sum += yes * local.yes;
      if (const double no = cells_[i].weight_of_no(); no > 0) sum += no * local.no;
    }
  }
  return sum;
}

// Gradient and curvature of minus joint(), the first with the sign of an ascent.
Likelihood::Curvature Likelihood::curvature(const Scales& scales, const Random& u, Weights weights,
                                            Random& gradient) const {
  Curvature c;
  const auto n_clips = static_cast<Eigen::Index>(clips());
  c.block.assign(participants(), Eigen::Matrix2d::Identity());
  c.join.assign(participants(), Eigen::Matrix2Xd::Zero(2, n_clips));
  c.schur = Eigen::MatrixXd::Identity(n_clips, n_clips);
  gradient = u;
  for (Pair& g : gradient.participant) g = -g;
  gradient.clip = -gradient.clip;
  for (size_t p = 0; p < participants(); ++p) {
    for (size_t i = participant_begin_[p]; i < participant_begin_[p + 1]; ++i) {
      const Pair z = loading(i, scales);
      double e = fixed_part_[i] + z.dot(u.participant[p]);
      if (settings_.clips) e += scales.clip * u.clip[cells_[i].clip];
      const Local local = local_at(settings_.link, settings_.guess, e);
      const double yes = cells_[i].weight_of_yes();
      const double no = cells_[i].weight_of_no();
      const double slope = yes * local.yes_1 + no * local.no_1;
      const double w = weights == Weights::expected ? -(yes + no) * local.yes_1 * local.no_1
                                                    : -(yes * local.yes_2 + no * local.no_2);
      gradient.participant[p] += slope * z;
      c.block[p] += w * z * z.transpose();
      if (!settings_.clips) continue;
      const auto k = static_cast<Eigen::Index>(cells_[i].clip);
      gradient.clip[k] += slope * scales.clip;
      c.join[p].col(k) += w * scales.clip * z;
      c.schur(k, k) += w * scales.clip * scales.clip;
    }
  }
  return c;
}

// Eliminates the participants. False where the curvature is not positive definite.
bool Likelihood::factor(Curvature& c) {
  c.inverse.resize(c.block.size());
  c.log_determinant = 0;
  for (size_t p = 0; p < c.block.size(); ++p) {
    const double determinant = c.block[p].determinant();
    if (!(determinant > 0 && c.block[p](0, 0) > 0)) return false;
    c.log_determinant += std::log(determinant);
    c.inverse[p] = c.block[p].inverse();
    if (c.schur.size() == 0) continue;
    const Eigen::Matrix2Xd explained = c.inverse[p] * c.join[p];
    c.schur -= c.join[p].transpose().lazyProduct(explained);
  }
  if (c.schur.size() == 0) return true;
  std::optional<Eigen::MatrixXd> factored = dense::cholesky_factor(c.schur);
  if (!factored) return false;
  c.schur = std::move(*factored);
  c.log_determinant += 2 * c.schur.diagonal().array().log().sum();
  return true;
}

Likelihood::Random Likelihood::solve(const Curvature& c, const Random& right) {
  Random out = right;
  for (size_t p = 0; p < c.block.size(); ++p) {
    out.participant[p] = c.inverse[p] * right.participant[p];
    if (c.schur.size() > 0) out.clip.noalias() -= c.join[p].transpose() * out.participant[p];
  }
  if (c.schur.size() == 0) return out;
  out.clip = dense::solve_factored(c.schur, out.clip);
  for (size_t p = 0; p < c.block.size(); ++p) out.participant[p] -= c.inverse[p] * (c.join[p] * out.clip);
  return out;
}

double Likelihood::dot(const Random& a, const Random& b) {
  double sum = a.clip.dot(b.clip);
  for (size_t p = 0; p < a.participant.size(); ++p) sum += a.participant[p].dot(b.participant[p]);
  return sum;
}

void Likelihood::find_mode(const Scales& scales) {
  // The observed information converges faster, and is positive wherever nobody guesses.
  const Weights weights = settings_.guess == 0 ? Weights::observed : Weights::expected;
  double value = joint(scales, mode_);
  if (const Random origin = zero(); joint(scales, origin) > value) {
    mode_ = origin;
    value = joint(scales, mode_);
  }
  for (int i = 0; i < 100; ++i) {
    Random gradient;
    Curvature c = curvature(scales, mode_, weights, gradient);
    if (!factor(c)) return;
    const Random step = solve(c, gradient);
    const double promised = dot(gradient, step);
    double part = 1;
    for (int halving = 0; halving < 40; ++halving, part /= 2) {
      Random moved = mode_;
      for (size_t p = 0; p < moved.participant.size(); ++p) moved.participant[p] += part * step.participant[p];
      moved.clip += part * step.clip;
      const double there = joint(scales, moved);
      // Near the top the gain is below the rounding of the sum, and the determinant still sees where the mode is.
      if (there >= value - 1e-10 * (1 + std::fabs(value))) {
        mode_ = std::move(moved);
        value = there;
        break;
      }
    }
    if (!(promised > 1e-18)) return;
  }
}

double Likelihood::by_quadrature(const Scales& scales, const Curvature& c) const {
  const Quadrature& rule = gauss_hermite_25();
  double sum = 0;
  std::vector<double> terms(rule.nodes.size());
  for (size_t p = 0; p < participants(); ++p) {
    const double width = std::sqrt(c.inverse[p](0, 0));
    for (size_t k = 0; k < terms.size(); ++k) {
      const double z = rule.nodes[k];
      const double u = mode_.participant[p][0] + width * z;
      terms[k] = std::log(rule.weights[k]) + (z * z - u * u) / 2;
      for (size_t i = participant_begin_[p]; i < participant_begin_[p + 1]; ++i) {
        const Local local = local_at(settings_.link, settings_.guess, fixed_part_[i] + scales.intercept * u);
        terms[k] += cells_[i].weight_of_yes() * local.yes + cells_[i].weight_of_no() * local.no;
      }
    }
    const double top = *std::max_element(terms.begin(), terms.end());
    double total = 0;
    for (const double term : terms) total += std::exp(term - top);
    sum += std::log(width) + top + std::log(total);
  }
  return sum;
}

double Likelihood::at(const Scales& scales, const Eigen::VectorXd& beta) {
  set_fixed(beta);
  find_mode(scales);
  // Quadrature needs only a width that is about right, and the observed information of guessers may be negative.
  const bool observed = settings_.integration == Integration::laplace_observed ||
                        (settings_.integration == Integration::quadrature && settings_.guess == 0);
  const Weights weights = observed ? Weights::observed : Weights::expected;
  Random gradient;
  Curvature c = curvature(scales, mode_, weights, gradient);
  if (!factor(c)) return -std::numeric_limits<double>::infinity();
  if (settings_.integration == Integration::quadrature) return by_quadrature(scales, c);
  return joint(scales, mode_) - c.log_determinant / 2;
}

void Likelihood::set_fixed(const Eigen::VectorXd& beta) {
  for (size_t i = 0; i < cells_.size(); ++i)
    fixed_part_[i] = Eigen::Map<const Eigen::VectorXd>(cells_[i].fixed.data(), beta.size()).dot(beta);
}

Eigen::MatrixXd Likelihood::fixed_information(const Scales& scales, const Eigen::VectorXd& beta) {
  set_fixed(beta);
  find_mode(scales);
  Random unused;
  Curvature c = curvature(scales, mode_, Weights::expected, unused);
  if (!factor(c)) return Eigen::MatrixXd::Zero(beta.size(), beta.size());
  // X' W X less what the random part explains of it: H_bb - H_bu H_uu^-1 H_ub.
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(beta.size(), beta.size());
  std::vector<Random> cross(static_cast<size_t>(beta.size()), zero());
  for (size_t p = 0; p < participants(); ++p)
    for (size_t i = participant_begin_[p]; i < participant_begin_[p + 1]; ++i) {
      const Pair z = loading(i, scales);
      double e = fixed_part_[i] + z.dot(mode_.participant[p]);
      if (settings_.clips) e += scales.clip * mode_.clip[cells_[i].clip];
      const Local local = local_at(settings_.link, settings_.guess, e);
      const double w = -static_cast<double>(cells_[i].of) * local.yes_1 * local.no_1;
      const Eigen::Map<const Eigen::VectorXd> x(cells_[i].fixed.data(), beta.size());
      out += w * x * x.transpose();
      for (size_t k = 0; k < cross.size(); ++k) {
        cross[k].participant[p] += w * cells_[i].fixed[k] * z;
        if (settings_.clips) cross[k].clip[cells_[i].clip] += w * cells_[i].fixed[k] * scales.clip;
      }
    }
  for (size_t k = 0; k < cross.size(); ++k) {
    const Random solved = solve(c, cross[k]);
    for (size_t j = 0; j < cross.size(); ++j)
      out(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) -= dot(cross[j], solved);
  }
  return out;
}

std::vector<Likelihood::Mode> Likelihood::modes(const Scales& scales, const Eigen::VectorXd& beta, double slope_at) {
  set_fixed(beta);
  find_mode(scales);
  Random unused;
  Curvature c = curvature(scales, mode_, Weights::expected, unused);
  std::vector<Mode> out(participants());
  if (!factor(c)) return out;
  const Pair load(scales.intercept + slope_at * scales.cross, slope_at * scales.slope);
  for (size_t p = 0; p < participants(); ++p) {
    Random right = zero();
    right.participant[p] = load;
    out[p] = {load.dot(mode_.participant[p]), std::sqrt(std::max(0.0, load.dot(solve(c, right).participant[p])))};
  }
  return out;
}

}  // namespace mixed
}  // namespace crowdbench::studies
