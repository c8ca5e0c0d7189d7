// What the fits ask of dense matrices of doubles. Eigen's decompositions and products are instantiated in dense.cpp
// alone: they take a compiler longer than all else in a source that uses them.
#pragma once
#include <Eigen/Core>
#include <optional>

namespace crowdbench::studies::dense {

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// By LU with partial pivoting; m is square. Entries that are not finite where m is singular.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& m);

// m is symmetric in the next three.
//
// x with m x = right, by L D L' with pivoting: of least harm where m is singular.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& m, const Eigen::VectorXd& right);
// L of m = L L', its upper triangle zero; nothing where m is not positive definite.
std::optional<Eigen::MatrixXd> cholesky_factor(const Eigen::MatrixXd& m);
// Nothing where m is not finite or not positive definite.
std::optional<Eigen::MatrixXd> inverse_of_positive(const Eigen::MatrixXd& m);

// x with l l' x = right, for a factor as cholesky_factor gives it.
Eigen::VectorXd solve_factored(const Eigen::MatrixXd& l, const Eigen::VectorXd& right);

// By QR with column pivoting, at Eigen's threshold.
Eigen::Index rank(const Eigen::MatrixXd& m);

// Of a symmetric matrix, ascending; vectors(.., i) is the unit eigenvector of values[i].
struct Eigenpairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
Eigenpairs eigenpairs(const Eigen::MatrixXd& m);

}  // namespace crowdbench::studies::dense
