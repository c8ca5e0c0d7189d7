// The likelihood of a mixed model at given parameters, for mixed_model.cpp alone: what is random is integrated over by
// Laplace's approximation or by quadrature.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "studies/analysis/mixed_model.h"

namespace crowdbench::studies::mixed {

// One answer's log-likelihood as a function of eta, and its first two derivatives.
struct Local {
  double yes = 0, yes_1 = 0, yes_2 = 0;
  double no = 0, no_1 = 0, no_2 = 0;
};
Local local_at(Link link, double guess, double eta);

// The standard deviations of what is random, on the scale of eta, as factors of independent standard normal values u:
// of a participant intercept = `intercept` u0, slope = `cross` u0 + `slope` u1; of a clip `clip` v.
struct Scales {
  double intercept = 0, cross = 0, slope = 0, clip = 0;
};

class Likelihood {
 public:
  // rows: as fit_mixed takes them, with at least one.
  Likelihood(std::vector<MixedRow> rows, const MixedSettings& settings);

  size_t participants() const { return participant_begin_.size() - 1; }
  size_t clips() const { return settings_.clips ? clips_ : 0; }
  size_t effects() const { return cells_.front().fixed.size(); }
  const std::vector<MixedRow>& cells() const { return cells_; }
  const MixedSettings& settings() const { return settings_; }

  // The log-likelihood. Remembers the mode, from which the next call begins.
  double at(const Scales& scales, const Eigen::VectorXd& beta);

  // At the mode of the last call: the curvature of the fixed effects with the scales held, and every participant's
  // intercept, where what the slope multiplies is `slope_at`, with its conditional standard deviation.
  Eigen::MatrixXd fixed_information(const Scales& scales, const Eigen::VectorXd& beta);
  struct Mode {
    double intercept = 0;
    double sd = 0;
  };
  std::vector<Mode> modes(const Scales& scales, const Eigen::VectorXd& beta, double slope_at);

 private:
  using Pair = Eigen::Vector2d;
  // What is random, or a right side or solution of its equations.
  struct Random {
    std::vector<Pair> participant;
    Eigen::VectorXd clip;
  };
  // I + Lambda' Z' W Z Lambda: blocks by participant, a diagonal by clip, and what joins them; and the Cholesky factor
  // of what is left of the clips when the participants are eliminated.
  struct Curvature {
    std::vector<Eigen::Matrix2d> block, inverse;
    std::vector<Eigen::Matrix2Xd> join;
    Eigen::MatrixXd schur;  // lower triangular
    double log_determinant = 0;
  };
  enum class Weights { expected, observed };

  Random zero() const;
  void set_fixed(const Eigen::VectorXd& beta);
  Pair loading(size_t cell, const Scales& scales) const;
  double joint(const Scales& scales, const Random& u) const;
  Curvature curvature(const Scales& scales, const Random& u, Weights weights, Random& gradient) const;
  static bool factor(Curvature& c);
  static Random solve(const Curvature& c, const Random& right);
  static double dot(const Random& a, const Random& b);
  void find_mode(const Scales& scales);
  double by_quadrature(const Scales& scales, const Curvature& c) const;

  MixedSettings settings_;
  std::vector<MixedRow> cells_;  // by participant
  std::vector<size_t> participant_begin_;
  size_t clips_ = 0;
  std::vector<double> fixed_part_;  // X beta
  Random mode_;
};

}  // namespace crowdbench::studies::mixed
