#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::matrix_functions_test {

/// Turns by `angle` [rad] per unit of time.
Eigen::MatrixXd Turn(double angle) {
  Eigen::MatrixXd A(2, 2);
  A << 0, -angle, angle, 0;
  return A;
}

TEST(MatrixFunctions, EigenvaluesOfATurnAreImaginary) {
  const Eigen::VectorXcd values = Eigenvalues(Turn(0.3));
  EXPECT_NEAR(std::abs(values[0].imag()), 0.3, 1e-15);
  EXPECT_EQ(values[0], std::conj(values[1]));
}

TEST(MatrixFunctions, SymmetricEigenvaluesAscend) {
  Eigen::MatrixXd A(2, 2);
  A << 2, 1, 1, 2;
  EXPECT_THAT(SymmetricEigenvalues(A), IsNear(Eigen::Vector2d(1, 3), 1e-14));
}

TEST(MatrixFunctions, ExponentialOfATurnIsARotation) {
  Eigen::MatrixXd expected(2, 2);
  expected << std::cos(0.3), -std::sin(0.3), std::sin(0.3), std::cos(0.3);
  EXPECT_THAT(Exponential(Turn(0.3)), IsNear(expected, 1e-15));
}

TEST(MatrixFunctions, SolveLinearInvertsATurn) {
  EXPECT_THAT(SolveLinear(Turn(2), Eigen::Vector2d(1, 4)), IsNear(Eigen::Vector2d(2, -0.5), 1e-15));
}

// x + 2 y = 5: the least norm is along (1, 2), and a basic solution uses the larger coefficient only.
TEST(MatrixFunctions, LeastSquaresOfOneEquationForTwoUnknowns) {
  const Eigen::MatrixXd A = Eigen::RowVector2d(1, 2);
  const Eigen::VectorXd b = Eigen::VectorXd::Constant(1, 5);
  const LeastSquares least = SolveLeastSquares(A, b);
  EXPECT_EQ(least.rank, 1);
  EXPECT_THAT(least.x, IsNear(Eigen::Vector2d(1, 2), 1e-14));
  EXPECT_THAT(SolveLeastSquaresBasic(A, b), IsNear(Eigen::Vector2d(0, 2.5), 1e-14));
}

TEST(MatrixFunctions, RangeBasisSpansTheColumnsUpToTheThreshold) {
  Eigen::MatrixXd A(3, 2);
  A << 1, 1, 1, 1, 0, 1e-6;
  const RangeBasis exact = CalcRangeBasis(A), coarse = CalcRangeBasis(A, 1e-3);
  EXPECT_EQ(exact.rank, 2);
  EXPECT_EQ(coarse.rank, 1);
  const Eigen::MatrixXd range = exact.Q.leftCols(2);
  EXPECT_THAT(range * range.transpose() * A, IsNear(A, 1e-15));
}

}  // namespace tenon::matrix_functions_test
