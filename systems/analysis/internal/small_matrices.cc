#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <unsupported/Eigen/MatrixFunctions>

namespace tenon::internal {

template <int n>
SmallMatrix<n> Inverse(const SmallMatrix<n>& A) {
  return A.inverse();
}

template <int n>
SmallMatrix<n, 1> SolveLu(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b) {
  return A.partialPivLu().solve(b);
}

template <int n>
SmallMatrix<n, 1> SolveLdlt(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b) {
  return A.ldlt().solve(b);
}

template <int n>
SmallMatrix<n, 1> SolveCholesky(const SmallMatrix<n>& A, const SmallMatrix<n, 1>& b) {
  return A.llt().solve(b);
}

template <int n>
void Cholesky<n>::Compute(const SmallMatrix<n>& A) {
  factors_.compute(A);
}

template <int n>
template <int m>
SmallMatrix<n, m> Cholesky<n>::Solve(const SmallMatrix<n, m>& b) const {
  return factors_.solve(b);
}

template <int n>
template <int m>
SmallMatrix<n, m> Cholesky<n>::SolveLower(const SmallMatrix<n, m>& b) const {
  return factors_.matrixL().solve(b);
}

template <int n>
SmallMatrix<n> Cholesky<n>::Lower() const {
  return factors_.matrixL();
}

SmallMatrix<3, 1> SymmetricEigenvalues3(const SmallMatrix<3>& A) {
  return Eigen::SelfAdjointEigenSolver<SmallMatrix<3>>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SmallMatrix<3, 1> DirectSymmetricEigenvalues3(const SmallMatrix<3>& A) {
  Eigen::SelfAdjointEigenSolver<SmallMatrix<3>> solver;
  return solver.computeDirect(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigensystem3 CalcSymmetricEigensystem3(const SmallMatrix<3>& A) {
  const Eigen::SelfAdjointEigenSolver<SmallMatrix<3>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SingularValues3 CalcSingularValues3(const SmallMatrix<3>& A) {
  const Eigen::JacobiSVD<SmallMatrix<3>> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.info() != Eigen::Success) return {};
  return {svd.matrixU(), svd.matrixV(), svd.singularValues(), true};
}

// The sizes in use.
template SmallMatrix<2> Inverse(const SmallMatrix<2>&);
template SmallMatrix<3> Inverse(const SmallMatrix<3>&);
template SmallMatrix<3, 1> SolveLu(const SmallMatrix<3>&, const SmallMatrix<3, 1>&);
template SmallMatrix<12, 1> SolveLu(const SmallMatrix<12>&, const SmallMatrix<12, 1>&);
template SmallMatrix<3, 1> SolveLdlt(const SmallMatrix<3>&, const SmallMatrix<3, 1>&);
template SmallMatrix<6, 1> SolveLdlt(const SmallMatrix<6>&, const SmallMatrix<6, 1>&);
template SmallMatrix<12, 1> SolveLdlt(const SmallMatrix<12>&, const SmallMatrix<12, 1>&);
template SmallMatrix<3, 1> SolveCholesky(const SmallMatrix<3>&, const SmallMatrix<3, 1>&);
template SmallMatrix<6, 1> SolveCholesky(const SmallMatrix<6>&, const SmallMatrix<6, 1>&);
template SmallMatrix<12, 1> SolveCholesky(const SmallMatrix<12>&, const SmallMatrix<12, 1>&);
template class Cholesky<3>;
template class Cholesky<6>;
template class Cholesky<18>;
template SmallMatrix<3, 1> Cholesky<3>::Solve(const SmallMatrix<3, 1>&) const;
template SmallMatrix<3> Cholesky<3>::Solve(const SmallMatrix<3>&) const;
template SmallMatrix<3, 27> Cholesky<3>::SolveLower(const SmallMatrix<3, 27>&) const;
template SmallMatrix<6, 1> Cholesky<6>::Solve(const SmallMatrix<6, 1>&) const;
template SmallMatrix<6> Cholesky<6>::Solve(const SmallMatrix<6>&) const;
template SmallMatrix<6, 9> Cholesky<6>::Solve(const SmallMatrix<6, 9>&) const;
template SmallMatrix<6, 12> Cholesky<6>::Solve(const SmallMatrix<6, 12>&) const;
template SmallMatrix<18, 1> Cholesky<18>::Solve(const SmallMatrix<18, 1>&) const;
template SmallMatrix<18, 12> Cholesky<18>::Solve(const SmallMatrix<18, 12>&) const;

}  // namespace tenon::internal

namespace tenon {

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(A, /*computeEigenvectors=*/false).eigenvalues();
}

Eigen::VectorXd SymmetricEigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::MatrixXd Exponential(const Eigen::MatrixXd& A) {
  return A.exp();
}

Eigen::VectorXd SolveLinear(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.partialPivLu().solve(b);
}

LeastSquares SolveLeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors(A);
  return {factors.solve(b), factors.rank()};
}

Eigen::VectorXd SolveLeastSquaresBasic(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.colPivHouseholderQr().solve(b);
}

RangeBasis CalcRangeBasis(const Eigen::MatrixXd& A, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(A);
  if (threshold > 0) factors.setThreshold(threshold);
  return {factors.householderQ(), factors.rank()};
}

}  // namespace tenon
