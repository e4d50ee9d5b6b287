#include <tenon/systems/analysis/lqr.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::riccati_test {
namespace {

// p = q + a^2 p - a^2 p^2 b^2 / (r + b^2 p) is a quadratic equation for p.
TEST(DiscreteRiccati, ScalarInClosedForm) {
  const double a = 1.3, b = 0.4, q = 2, r = 0.7;
  const double half = (r * (1 - a * a) - q * b * b) / (2 * b * b);
  const double p = -half + std::sqrt(half * half + q * r / (b * b));
  const auto one = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
  EXPECT_THAT(SolveDiscreteRiccati(one(a), one(b), one(q), one(r)), IsNear(one(p), 1e-12));
}

TEST(DiscreteRiccati, SolvesTheEquationAndStabilises) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Identity();
  A.topRightCorner<2, 2>() << 0.1, 0.02, 0, 0.1;
  A(2, 0) = 0.3;  // unstable
  Eigen::Matrix<double, 4, 2> B;
  B << 0.005, 0, 0, 0.005, 0.1, 0, 0.02, 0.1;
  const Eigen::Matrix4d Q = Eigen::Vector4d(10, 5, 1, 0).asDiagonal();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.1, 0.2).asDiagonal();
  const Eigen::Matrix4d P = SolveDiscreteRiccati(A, B, Q, R);
  const Eigen::Matrix<double, 2, 4> K = test::Solve(R + B.transpose() * P * B, B.transpose() * P * A);
  const Eigen::Matrix4d residual = Q + A.transpose() * P * A - A.transpose() * P * B * K - P;
  EXPECT_LT(residual.norm(), 1e-10 * P.norm());
  EXPECT_LT(test::Eigenvalues(A - B * K).cwiseAbs().maxCoeff(), 1);
}

TEST(DiscreteRiccati, RefusesUnstabilisableSystems) {
  const Eigen::Matrix2d A = Eigen::Vector2d(1.2, 0.5).asDiagonal();
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        SolveDiscreteRiccati(A, Eigen::Vector2d(0, 1), Eigen::Matrix2d::Identity(),
                             Eigen::MatrixXd::Identity(1, 1));
      },
      "stabilising"));
}

}  // namespace
}  // namespace tenon::riccati_test
