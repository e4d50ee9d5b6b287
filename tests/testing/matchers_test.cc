#include <tenon/systems/framework/types/signal.h>
#include <tenon/tests/testing/matchers.h>

#include <gtest/gtest-spi.h>

#include <limits>

namespace tenon::matchers_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
              AllOf(HasSubstr("element (5, 0)"), Not(HasSubstr("element (6, 0)")), HasSubstr("and 14 more")));
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

}  // namespace tenon::matchers_test
