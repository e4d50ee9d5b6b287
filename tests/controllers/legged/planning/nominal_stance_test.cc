#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <gtest/gtest.h>

#include <limits>

namespace tenon::nominal_stance_test {
namespace {

using test::DogBot;

/// DogBot with another range of the front left knee.
QuadrupedDescription WithKneeRange(double lower, double upper) {
  QuadrupedDescription robot = DogBot();
  JointDescription& knee = robot.legs[kFrontLeft].joints[2];
  knee.lower = lower;
  knee.upper = upper;
  return robot;
}

/// Distance from hip to foot of the front left leg with the knee at this angle.
double Extension(const QuadrupedDescription& robot, double knee) {
  Vec<12> q = robot.stance;
  q[2] = knee;
  return (robot.FootPosition(kFrontLeft, q) - robot.HipPosition(kFrontLeft, q)).norm();
}

TEST(NominalStance, AKneeThatCanStraightenExtendsTheWholeLeg) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double end : {0.5, 3.0, kInfinity}) {
    const QuadrupedDescription robot = WithKneeRange(-end, end);
    EXPECT_EQ(robot.LongestExtension(kFrontLeft), robot.LegLength(kFrontLeft)) << end;
    EXPECT_DOUBLE_EQ(NominalStance(robot).longest[kFrontLeft], 0.95 * robot.LegLength(kFrontLeft));
  }
}

// The longest extension is that at the end of the range which is closer to a straight knee, also if the range
// is given a turn away.
TEST(NominalStance, TheRangeOfTheKneeLimitsTheReach) {
  for (const double turn : {0.0, 6.283185307179586}) {
    for (const bool backward : {true, false}) {
      const QuadrupedDescription robot =
          backward ? WithKneeRange(-2.5 + turn, -0.9 + turn) : WithKneeRange(0.9 + turn, 2.5 + turn);
      const double longest = robot.LongestExtension(kFrontLeft);
      EXPECT_NEAR(longest, Extension(robot, backward ? -0.9 : 0.9), 1e-12);
      EXPECT_GT(longest, Extension(robot, backward ? -1.0 : 1.0));
      EXPECT_LT(NominalStance(robot).longest[kFrontLeft], longest);
      EXPECT_LT(NominalStance(robot).reach[kFrontLeft], NominalStance(DogBot()).reach[kFrontLeft]);
    }
  }
}

}  // namespace
}  // namespace tenon::nominal_stance_test
