#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace tenon::test {

Eigen::MatrixXd Inverse(const Eigen::MatrixXd& A) {
  return A.inverse();
}

Eigen::MatrixXd Solve(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.partialPivLu().solve(B);
}

Eigen::VectorXcd Eigenvalues(const Eigen::MatrixXd& A) {
  return A.eigenvalues();
}

SymmetricModes::SymmetricModes(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  eigenvalues = solver.eigenvalues();
  eigenvectors = solver.eigenvectors();
}

}  // namespace tenon::test
