#include "studies/analysis/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace crowdbench::studies::dense {

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& m) { return m.inverse(); }

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& m, const Eigen::VectorXd& right) {
  return m.ldlt().solve(right);
}

std::optional<Eigen::MatrixXd> cholesky_factor(const Eigen::MatrixXd& m) {
  const Eigen::LLT<Eigen::MatrixXd> factor(m);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.matrixL();
}

std::optional<Eigen::MatrixXd> inverse_of_positive(const Eigen::MatrixXd& m) {
  if (!m.allFinite()) return std::nullopt;
  const Eigen::LLT<Eigen::MatrixXd> factor(m);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(Eigen::MatrixXd::Identity(m.rows(), m.cols()));
}

Eigen::VectorXd solve_factored(const Eigen::MatrixXd& l, const Eigen::VectorXd& right) {
  Eigen::VectorXd x = right;
  l.triangularView<Eigen::Lower>().solveInPlace(x);
  l.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
  return x;
}

Eigen::Index rank(const Eigen::MatrixXd& m) { return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(m).rank(); }

Eigenpairs eigenpairs(const Eigen::MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(m);
  return {solved.eigenvalues(), solved.eigenvectors()};
}

}  // namespace crowdbench::studies::dense
