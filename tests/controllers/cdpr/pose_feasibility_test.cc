#include <tenon/controllers/cdpr/pose_feasibility.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <random>

namespace tenon::pose_feasibility_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Draws {
 public:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3d Direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
  }

 private:
  std::mt19937_64 random_{11};
};

struct Case {
  const char* name;
  int cables;
  PlatformDemand demand;
  double angle;          ///< of a ball, per metre of its radius [rad/m]
  bool unequal = false;  ///< whether each cable has limits of its own
};

class PoseFeasibilityTest : public ::testing::TestWithParam<Case> {};

// Balls of poses all over the frame, with radii down to 1 mm. If the verdict is kHolds, every pose of the
// ball is feasible by the quadratic program of tension_distribution.h; if it is kFails, none is. Small balls
// are undecided only at the boundary.
TEST_P(PoseFeasibilityTest, ProofsHoldAtEveryPoseOfTheBall) {
  const auto [name, num_cables, demand, angle, unequal] = GetParam();
  CdprDescription robot = test::RobotWithCables(num_cables);
  for (int i = 0; unequal && i < num_cables; ++i) {
    robot.cables[i].tension_min = robot.cable.tension_min * (0.5 + 0.3 * (i % 3));
    robot.cables[i].tension_max = robot.cable.tension_max * (0.2 + 0.1 * (i % 4));
  }
  const WrenchBox required = RequiredWrenches(robot, demand);
  PoseFeasibility feasibility(robot, required);
  TensionDistributor distributor(num_cables);
  const auto feasible = [&](const PoseBall& at) {
    const CableMatrix6 W = CalcCableKinematics(robot, at.p_WB, at.R_WB).structure;
    for (int bits = 0; bits < 64; ++bits) {
      Vector6d wrench = required.centre;
      for (int k = 0; k < 6; ++k) wrench[k] += ((bits >> k & 1) != 0 ? 1 : -1) * required.half_width[k];
      if (!distributor.Solve(W, wrench, robot.tension_min(), robot.tension_max(), 1e-7).feasible)
        return false;
      if (required.half_width.isZero()) return true;
    }
    return true;
  };
  Draws draw;
  int holds = 0, fails = 0, undecided_small = 0, small = 0;
  for (int k = 0; k < 500; ++k) {
    PoseBall ball;
    ball.p_WB << draw.Uniform(-3.5, 3.5), draw.Uniform(-4.5, 4.5), draw.Uniform(0, 3.8);
    ball.R_WB = Eigen::AngleAxisd(draw.Uniform(0, 0.3), draw.Direction()).toRotationMatrix();
    ball.distance = std::pow(10, draw.Uniform(-3, -0.3));
    ball.angle = angle * ball.distance;
    const PoseVerdict verdict = feasibility.Over(ball);
    holds += verdict == PoseVerdict::kHolds ? 1 : 0;
    fails += verdict == PoseVerdict::kFails ? 1 : 0;
    if (ball.distance < 0.003) {
      ++small;
      undecided_small += verdict == PoseVerdict::kUndecided ? 1 : 0;
    }
    if (verdict == PoseVerdict::kUndecided) continue;
    for (int i = 0; i < (required.half_width.isZero() ? 20 : 3); ++i) {
      // Mostly on the surface of the ball, where it is most likely to be wrong.
      const double share = i % 4 == 0 ? draw.Uniform(0, 1) : 1;
      PoseBall at = ball;
      at.p_WB += share * ball.distance * draw.Direction();
      at.R_WB = Eigen::AngleAxisd(share * ball.angle, draw.Direction()).toRotationMatrix() * ball.R_WB;
      EXPECT_EQ(feasible(at), verdict == PoseVerdict::kHolds)
          << "ball " << k << " of radius " << ball.distance << " at " << ball.p_WB.transpose();
    }
  }
  EXPECT_GT(holds, 20);
  EXPECT_GT(fails, 30);
  EXPECT_LT(undecided_small, 0.1 * small);
}

INSTANTIATE_TEST_SUITE_P(
    Robots, PoseFeasibilityTest,
    ::testing::Values(Case{"six", 6, {}, 0}, Case{"eight", 8, {}, 0.5},
                      Case{"eight_accelerating", 8, {.load = 3, .acceleration = 1, .torque = 1}, 0.5},
                      Case{"eight_with_limits_of_their_own", 8, {.load = 10}, 0.5, true},
                      Case{"twelve", 12, {.load = 10}, 0.5}),
    [](const auto& info) { return info.param.name; });

// Verdicts on interference against the clearance at poses of the ball.
TEST(PoseFeasibilityClearTest, ProofsHoldAtEveryPoseOfTheBall) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const CableInterference interference(robot);
  constexpr double kDiameter = 0.05;
  Draws draw;
  int holds = 0, fails = 0;
  for (int k = 0; k < 800; ++k) {
    PoseBall ball;
    ball.p_WB << draw.Uniform(-3.5, 3.5), draw.Uniform(-4.5, 4.5), draw.Uniform(0, 3.8);
    ball.R_WB = Eigen::AngleAxisd(draw.Uniform(0, 1.2), draw.Direction()).toRotationMatrix();
    ball.distance = std::pow(10, draw.Uniform(-3, -1));
    ball.angle = ball.distance;
    const PoseVerdict verdict = feasibility.IsClearOver(ball, kDiameter);
    if (verdict == PoseVerdict::kUndecided) continue;
    ++(verdict == PoseVerdict::kHolds ? holds : fails);
    for (int i = 0; i < 10; ++i) {
      const Vector3d p = ball.p_WB + ball.distance * draw.Direction();
      const Matrix3d R = Eigen::AngleAxisd(ball.angle, draw.Direction()).toRotationMatrix() * ball.R_WB;
      const CableClearance at = interference.At(CalcCableKinematics(robot, p, R), R);
      EXPECT_EQ(at.cables >= kDiameter && at.platform >= 0, verdict == PoseVerdict::kHolds) << k;
    }
  }
  EXPECT_GT(holds, 40);
  EXPECT_GT(fails, 40);
}

TEST(PoseFeasibilityTest, DemandIsWeightLoadAccelerationAndForces) {
  const CdprDescription robot = test::EightCableRobot();
  const WrenchBox box = RequiredWrenches(robot, {.load = 5, .acceleration = 2, .force = 7, .torque = 3});
  EXPECT_LT((box.centre - 20 * 9.81 * Vector6d::Unit(2)).norm(), 1e-12);
  EXPECT_LT((box.half_width.head(3) - Vector3d::Constant(47)).norm(), 1e-12);
  EXPECT_LT((box.half_width.tail(3) - Vector3d::Constant(3)).norm(), 1e-12);
  EXPECT_TRUE(Throws<ParameterError>([&] { RequiredWrenches(robot, {.load = -1}); }, "load"));
}

TEST(PoseFeasibilityTest, TreatsPulleysAsPoints) {
  CdprDescription robot = test::RobotWithCables(8);
  const WrenchBox required = RequiredWrenches(robot, {});
  const PoseBall ball{.p_WB = {0.3, -0.4, 1.7}, .distance = 0.05, .angle = 0.05};
  PoseFeasibility points(robot, required);
  robot.winch.pulley_radius = 0.2;
  PoseFeasibility pulleys(robot, required);
  EXPECT_EQ(pulleys.Over(ball), points.Over(ball));
  EXPECT_EQ(pulleys.margins().tension, points.margins().tension);
}

// A cable without length has no margin, and a ball that contains such a place is undecided.
TEST(PoseFeasibilityTest, AtAnAnchor) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const Vector3d at = robot.cables[0].anchor_W - robot.cables[0].attachment_B;
  EXPECT_FALSE(feasibility.At(at, Matrix3d::Identity()).feasible());
  EXPECT_EQ(feasibility.Over({.p_WB = at, .distance = 0.1}), PoseVerdict::kUndecided);
  EXPECT_EQ(feasibility.Over({.p_WB = at + Vector3d(0.05, 0, 0), .distance = 0.1}), PoseVerdict::kUndecided);
  EXPECT_EQ(feasibility.IsClearOver({.p_WB = at, .distance = 0.1}, 0), PoseVerdict::kUndecided);
}

TEST(PoseFeasibilityTest, AllocatesNothingInTheLoop) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  feasibility.At({0, 0, 1.5}, Matrix3d::Identity());
  const AllocationGuard guard;
  EXPECT_EQ(feasibility.Over({.p_WB = {0, 0, 2}, .distance = 0.01}), PoseVerdict::kHolds);
  EXPECT_EQ(feasibility.Over({.p_WB = {3.4, 4.4, 2}, .distance = 0.01}), PoseVerdict::kFails);
  EXPECT_EQ(guard.count(), 0);
}

TEST(PoseFeasibilityTest, RefusesRobotsThatHaveNoSuchWorkspace) {
  CdprDescription robot = test::FourCableRobot();
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(robot, RequiredWrenches(robot, {})); }, "'four'"));
  for (CableDescription& cable : robot.cables) cable.attachment_B.setZero();
  EXPECT_NO_THROW(PoseFeasibility(robot, RequiredWrenches(robot, {})));
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(robot, RequiredWrenches(robot, {.torque = 1})); },
                                     "torque"));
}

TEST(PoseFeasibilityPlanarTest, APlanarRobotIsRefused) {
  const CdprDescription robot = test::PlanarRobot(4);
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(robot, RequiredWrenches(robot, {})); }, "'planar'",
                                     "in a plane"));
}

}  // namespace tenon::pose_feasibility_test
