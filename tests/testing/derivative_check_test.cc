#include <tenon/systems/framework/types/signal.h>
#include <tenon/tests/testing/derivative_check.h>
#include <tenon/tests/testing/matchers.h>

#include <gmock/gmock.h>

#include <limits>

namespace tenon::derivative_check_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Polar coordinates to a place, and its height on a paraboloid.
Vec<3> Place(const Vec<2>& q) {
  return {q[0] * std::cos(q[1]), q[0] * std::sin(q[1]), q[0] * q[0]};
}
Eigen::Matrix<double, 3, 2> PlaceJacobian(const Vec<2>& q) {
  Eigen::Matrix<double, 3, 2> jacobian;
  jacobian << std::cos(q[1]), -q[0] * std::sin(q[1]),  //
      std::sin(q[1]), q[0] * std::cos(q[1]),           //
      2 * q[0], 0;
  return jacobian;
}

TEST(DerivativeCheckTest, FindsTheJacobian) {
  const Vec<2> q(1.5, 0.4);
  EXPECT_THAT(NumericalJacobian(Place, q), IsNear(PlaceJacobian(q), 1e-9));
}

TEST(DerivativeCheckTest, AcceptsTheRightOne) {
  for (const Vec<2>& q : {Vec<2>(1.5, 0.4), Vec<2>(0, 0), Vec<2>(300, -2)}) {
    EXPECT_TRUE(IsJacobian(PlaceJacobian(q), Place, q, 1e-8));
  }
}

TEST(DerivativeCheckTest, TakesVectorsOfAnySize) {
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Random(4, 5);
  const auto product = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return matrix * x; };
  EXPECT_TRUE(IsJacobian(matrix, product, Eigen::VectorXd::Random(5).eval(), 1e-9));
}

TEST(DerivativeCheckTest, RefusesAWrongElement) {
  const Vec<2> q(1.5, 0.4);
  Eigen::Matrix<double, 3, 2> wrong = PlaceJacobian(q);
  wrong(2, 0) += 1e-3;
  const auto result = IsJacobian(wrong, Place, q, 1e-6);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), AllOf(HasSubstr("(2, 0)"), HasSubstr(" 3.001 "), HasSubstr(" 3")));
}

TEST(DerivativeCheckTest, RefusesAnotherShape) {
  const Vec<2> q(1.5, 0.4);
  const auto result = IsJacobian(PlaceJacobian(q).transpose(), Place, q, 1e-6);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), AllOf(HasSubstr("2 x 3"), HasSubstr("3 x 2")));
}

TEST(DerivativeCheckTest, RefusesNan) {
  const Vec<2> q(1.5, 0.4);
  Eigen::Matrix<double, 3, 2> wrong = PlaceJacobian(q);
  wrong(1, 1) = std::numeric_limits<double>::quiet_NaN();
  const auto result = IsJacobian(wrong, Place, q, 1e9);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("element (1, 1) is nan"));
}

}  // namespace tenon::derivative_check_test
