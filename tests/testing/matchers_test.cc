#include <tenon/systems/framework/types/signal.h>
#include <tenon/tests/testing/derivative_check.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>

#include <gtest/gtest-spi.h>

namespace tenon::matchers_test {

using ::testing::AllOf, ::testing::EndsWith, ::testing::HasSubstr, ::testing::Not;

template <class T, class Matcher>
std::string Explanation(const T& value, const Matcher& matcher) {
  ::testing::StringMatchResultListener listener;
  EXPECT_FALSE(::testing::ExplainMatchResult(matcher, value, &listener));
  return listener.str();
}

TEST(IsNearTest, AcceptsWithinTolerance) {
  EXPECT_THAT(Vec<2>(1, 2.001), IsNear(Vec<2>(1, 2), 0.01));
  EXPECT_THAT(Eigen::VectorXd::Zero(3), IsNear(Vec<3>(0, 0, 0), 0));
  EXPECT_THAT(Eigen::Matrix2d::Identity() * 2,
              IsNear(Eigen::Matrix2d(Eigen::Vector2d(2, 2).asDiagonal()), 1e-15));
}

TEST(IsNearTest, RefusesBeyondTolerance) {
  EXPECT_THAT(Vec<2>(1, 2.02), Not(IsNear(Vec<2>(1, 2), 0.01)));
  EXPECT_THAT(Vec<2>(1, 1.98), Not(IsNear(Vec<2>(1, 2), 0.01)));
}

TEST(IsNearTest, NamesTheWrongElements) {
  Eigen::Matrix2d expected, actual;
  expected << 1, 2, 3, 4;
  actual << 1, 2, 3.5, 5;
  EXPECT_EQ(
      Explanation(actual, IsNear(expected, 0.1)),
      "whose element (1, 0) is 3.5 instead of 3, off by 0.5; element (1, 1) is 5 instead of 4, off by 1");
}

TEST(IsNearTest, CutsLongListsShort) {
  EXPECT_THAT(Explanation(Eigen::VectorXd::Ones(20), IsNear(Eigen::VectorXd::Zero(20), 0.1)),
              AllOf(HasSubstrs("element (5, 0)", "and 14 more"), Not(HasSubstr("element (6, 0)"))));
}

TEST(IsNearTest, RefusesAnotherShape) {
  EXPECT_EQ(Explanation(Vec<3>(1, 2, 3), IsNear(Vec<2>(1, 2), 10)), "which is 3 x 1 instead of 2 x 1");
  EXPECT_EQ(Explanation(Eigen::RowVector2d(1, 2), IsNear(Vec<2>(1, 2), 10)),
            "which is 1 x 2 instead of 2 x 1");
}

TEST(IsNearTest, NanIsNearNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Vec<2>(1, nan), Not(IsNear(Vec<2>(1, 2), 1e9)));
  EXPECT_THAT(Vec<2>(1, 2), Not(IsNear(Vec<2>(1, nan), 1e9)));
  EXPECT_THAT(Vec<2>(1, nan), Not(IsNear(Vec<2>(1, nan), 1e9)));
}

TEST(IsNearTest, InfinityIsNearItselfOnly) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(Vec<2>(1, infinity), IsNear(Vec<2>(1, infinity), 0));
  EXPECT_THAT(Vec<2>(1, infinity), Not(IsNear(Vec<2>(1, -infinity), 1e9)));
  EXPECT_THAT(Vec<2>(1, infinity), Not(IsNear(Vec<2>(1, 5), 1e9)));
}

TEST(IsNearTest, FailsTheTestReadably) {
  EXPECT_NONFATAL_FAILURE(EXPECT_THAT(Vec<2>(1, 3), IsNear(Vec<2>(1, 2), 0.5)), "is within 0.5 of [1; 2]");
  EXPECT_NONFATAL_FAILURE(EXPECT_THAT(Vec<2>(1, 3), IsNear(Vec<2>(1, 2), 0.5)),
                          "whose element (1, 0) is 3 instead of 2, off by 1");
}

TEST(ThrowsTest, AcceptsTypeAndParts) {
  EXPECT_TRUE(Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }));
  EXPECT_TRUE(
      Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }, "positive", "mass"));
  EXPECT_TRUE(Throws<Error>([] { throw ParameterError("mass must be positive"); }, std::string("must")));
}

TEST(ThrowsTest, RefusesAMissingPart) {
  const auto result = Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }, "mass",
                                             "finite", "small");
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("'finite', 'small'"));
  EXPECT_THAT(result.message(), EndsWith(": mass must be positive"));
}

TEST(ThrowsTest, RefusesAnotherType) {
  const auto result = Throws<ParameterError>([] { throw BuildError("a loop"); }, "loop");
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), EndsWith(": a loop"));
  EXPECT_FALSE(Throws<ParameterError>([] { throw Error("mass"); }, "mass")) << "a base is not enough";
}

TEST(ThrowsTest, RefusesWhatIsNoException) {
  const auto result = Throws<Error>([] { throw 1; });
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("std::exception"));
}

TEST(ThrowsTest, RefusesSilence) {
  const auto result = Throws<Error>([] {});
  EXPECT_FALSE(result);
  EXPECT_STREQ(result.message(), "nothing is thrown");
}

TEST(ThrowsTest, FailsTheTestWithTheActualText) {
  EXPECT_NONFATAL_FAILURE(EXPECT_TRUE(Throws<Error>([] { throw Error("actual text"); }, "expected text")),
                          "it reads: actual text");
}

TEST(HasSubstrsTest, WantsAllParts) {
  EXPECT_THAT("kp of 'pd'", HasSubstrs("'pd'", std::string("kp")));
  EXPECT_THAT("kp of 'pd'", Not(HasSubstrs("kp", "kd")));
}

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
  for (const Vec<2>& q : {Vec<2>(1.5, 0.4), Vec<2>(0, 0), Vec<2>(300, -2)})
    EXPECT_TRUE(IsJacobian(PlaceJacobian(q), Place, q, 1e-8));
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
  EXPECT_THAT(result.message(), HasSubstrs("(2, 0)", " 3.001 ", " 3"));
}

TEST(DerivativeCheckTest, RefusesAnotherShape) {
  const Vec<2> q(1.5, 0.4);
  const auto result = IsJacobian(PlaceJacobian(q).transpose(), Place, q, 1e-6);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstrs("2 x 3", "3 x 2"));
}

TEST(DerivativeCheckTest, RefusesNan) {
  const Vec<2> q(1.5, 0.4);
  Eigen::Matrix<double, 3, 2> wrong = PlaceJacobian(q);
  wrong(1, 1) = std::numeric_limits<double>::quiet_NaN();
  const auto result = IsJacobian(wrong, Place, q, 1e9);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("element (1, 1) is nan"));
}

}  // namespace tenon::matchers_test
