#include <tenon/systems/analysis/matrix_functions.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <unsupported/Eigen/MatrixFunctions>

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
