#pragma once

#include <tenon/systems/framework/types/internal/border.h>

namespace tenon {

// Functions of dense matrices of any size, for set-up code: they allocate. Eigen's decompositions are
// templates; here they are compiled once, which takes as long as compiling several blocks.

/// The eigenvalues of a square matrix, in no particular order.
Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A);

/// The eigenvalues of a symmetric matrix, ascending. Reads the lower triangle.
Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& A);

/// e^A of a square matrix (Higham, SIAM J. Matrix Anal. Appl. 26, 2005).
Eigen::MatrixXd Exponential(const Eigen::MatrixXd& A);

/// A^{-1} b for a regular A, by LU factors with partial pivoting. The result is not finite if A is singular.
Eigen::VectorXd SolveLinear(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// The x of least norm among those that minimise |A x - b|.
struct LeastSquares {
  Eigen::VectorXd x;
  Eigen::Index rank;  ///< of A, with Eigen's default threshold
};
LeastSquares SolveLeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// An x that minimises |A x - b| and has at most rank(A) entries other than zero: a basic solution.
Eigen::VectorXd SolveLeastSquaresBasic(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// A square orthogonal matrix whose first `rank` columns span the range of A.
struct RangeBasis {
  Eigen::MatrixXd Q;
  Eigen::Index rank;
};
/// `threshold` is the largest ratio of a pivot to the first one that counts as zero; 0 chooses Eigen's
/// default.
RangeBasis CalcRangeBasis(const Eigen::MatrixXd& A, double threshold = 0);

}  // namespace tenon
