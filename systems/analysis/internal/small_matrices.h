#pragma once

#include <Eigen/Cholesky>

namespace tenon::internal {

// Eigen's decompositions of matrices of fixed size. They neither allocate nor depend on the sizes of a
// program. Each of them takes as long to compile as several blocks, so all are compiled once, in
// small_matrices.cc.

template <int rows, int cols = rows>
using SmallMatrix = Eigen::Matrix<double, rows, cols>;

/// A^{-1} by cofactors. Not finite if A is singular.
template <int n>
SmallMatrix<n> Inverse(const SmallMatrix<n>& A);

/// A^{-1} b by LU factors with partial pivoting. Not finite if A is singular.
template <int n>
SmallMatrix<n, 1> SolveLu(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b);

/// A^{-1} b for a symmetric A that may be semidefinite, by factors L D L^T.
template <int n>
SmallMatrix<n, 1> SolveLdlt(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b);

/// A^{-1} b for a symmetric positive definite A. Reads the lower triangle, as the functions below.
template <int n>
SmallMatrix<n, 1> SolveCholesky(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b);

/// Factors L L^T of a symmetric matrix.
template <int n>
class Cholesky {
 public:
  Cholesky() = default;
  explicit Cholesky(const SmallMatrix<n>& A) { Compute(A); }
  void Compute(const SmallMatrix<n>& A);
  /// Whether the matrix is positive definite.
  bool positive() const { return factors_.info() == Eigen::Success; }
  /// A^{-1} b.
  template <int m>
  SmallMatrix<n, m> Solve(const SmallMatrix<n, m>& b) const;
  /// L^{-1} b.
  template <int m>
  SmallMatrix<n, m> SolveLower(const SmallMatrix<n, m>& b) const;
  SmallMatrix<n> Lower() const;

 private:
  Eigen::LLT<SmallMatrix<n>> factors_;
};

/// The eigenvalues of a symmetric matrix, ascending, by iteration.
SmallMatrix<3, 1> SymmetricEigenvalues3(const SmallMatrix<3>& A);
/// Eigenvalues of a symmetric matrix from the roots of the characteristic polynomial: faster and less
/// accurate.
SmallMatrix<3, 1> DirectSymmetricEigenvalues3(const SmallMatrix<3>& A);

/// A symmetric matrix V diag(values) V^T with ascending values.
struct SymmetricEigensystem3 {
  SmallMatrix<3, 1> values;
  SmallMatrix<3> V;
};
SymmetricEigensystem3 CalcSymmetricEigensystem3(const SmallMatrix<3>& A);

/// A = U diag(values) V^T with descending values.
struct SingularValues3 {
  SmallMatrix<3> U, V;
  SmallMatrix<3, 1> values;
  bool valid = false;  ///< A was finite; otherwise the members above have no values
};
SingularValues3 CalcSingularValues3(const SmallMatrix<3>& A);

}  // namespace tenon::internal
