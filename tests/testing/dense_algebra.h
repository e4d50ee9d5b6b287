#pragma once

#include <Eigen/Core>

// Eigen's decompositions for tests, compiled once for matrices of any size. Each instance in a test would
// take seconds to compile.

namespace tenon::test {

/// The inverse of a regular matrix, by LU with partial pivoting.
Eigen::MatrixXd Inverse(const Eigen::MatrixXd& A);

/// X of A X = B, A square and regular, by LU with partial pivoting.
Eigen::MatrixXd Solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A);

/// Modes of a symmetric matrix A = V diag(eigenvalues) V', the eigenvalues in ascending order.
struct SymmetricModes {
  explicit SymmetricModes(const Eigen::MatrixXd& A);

  Eigen::VectorXd eigenvalues;
  Eigen::MatrixXd eigenvectors;  ///< V
};

}  // namespace tenon::test
