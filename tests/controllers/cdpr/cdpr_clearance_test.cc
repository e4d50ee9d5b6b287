#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/derivative_check.h>

namespace tenon::cdpr_clearance_test {

/// A post and a bar beside four cables, whose platform is longer than wide.
CdprDescription RobotBesideObstacles() {
  CdprDescription robot = test::FourCableRobot();
  for (CableDescription& cable : robot.cables) cable.attachment_B.x() *= 4. / 3;  // to 0.1 m
  robot.obstacles = {{{0.5, 0, 0}, {0.5, 0, 3}, 0.05}, {{-1, -0.5, 2.3}, {-0.6, 1, 2.6}, 0}};
  return robot;
}

CdprClearance Keep(const CdprDescription& robot, double between_cables) {
  return {robot, 0.1, between_cables, CalcCableKinematics(robot, {0, 0, 2}, Eigen::Matrix3d::Identity())};
}

// Seen from above: the platform at (0.1, 0) m points to the post with a corner, the first cable passes it as
// a line does a point, and the first two cables diverge from their attachments, 0.15 m apart.
TEST(CdprClearance, IsTheDistance) {
  const CdprDescription robot = RobotBesideObstacles();
  std::vector<double> found;
  Keep(robot, 0.07)
      .ForEach(
          {0.1, 0, 2}, RotationFromEuler({0, 0, std::atan(1)}),
          [&](int i) { return robot.cables[i].anchor_W; },
          [&](int, int, const PoseDistance& distance) { found.push_back(distance.value); });
  ASSERT_EQ(found.size(), 2 * 5 + 6);
  const double s = std::sqrt(0.5);
  EXPECT_NEAR(found[0], std::hypot(0.4 - 0.175 * s, 0.025 * s) - 0.05, 1e-9);
  const Eigen::Vector2d end(0.1 + 0.025 * s, 0.175 * s), along = Eigen::Vector2d(3.5, 4.5) - end,
                                                         post = Eigen::Vector2d(0.5, 0) - end;
  EXPECT_NEAR(found[1], std::abs(along.x() * post.y() - along.y() * post.x()) / along.norm() - 0.05, 1e-9);
  EXPECT_NEAR(found[10], 0.15, 1e-12);
  EXPECT_EQ(Keep(robot, 0.18).size(), 10 + 4) << "the first two and the last two are nearer at the start";
  CdprDescription joined = robot;
  joined.cables[1].attachment_B = robot.cables[0].attachment_B;
  EXPECT_EQ(Keep(joined, 0.07).size(), 10 + 5) << "cables with a common end keep no distance";
}

// A single multiplier of 1 and a small penalty make the stage cost nearly minus one of the distances. A
// payload puts the common CoM beside that of the platform, which turns so far that cables cross.
TEST(CdprClearance, TheStageCostHasTheGradientOfEachDistance) {
  RandomStream random(5);
  const CdprDescription robot = RobotBesideObstacles();
  CdprTrackingProblem<4> problem(robot, 1, Keep(robot, 0.07));
  problem.com_B = {0.1, -0.05, 0.2};
  problem.lagrangian.penalty = 0.01;
  for (int i = 0; i < 4 * problem.clearance.size(); ++i) {
    problem.multipliers[0] = CableVector::Unit(problem.clearance.size(), i / 4);
    CentroidalState x, gx = CentroidalState::Zero();
    for (double& number : x) number = random.Uniform(-0.5, 0.5);
    x.tail<4>() += Eigen::Vector4d(2, 0, 0, 3);
    Eigen::Vector4d u = Eigen::Vector4d::Zero(), gu = u;
    Eigen::Matrix<double, 12, 12> Hxx = Eigen::Matrix<double, 12, 12>::Zero();
    Eigen::Matrix4d Huu = Eigen::Matrix4d::Zero();
    problem.AddStageCost(0, x, u, 1, gx, gu, Hxx, Huu);
    const auto cost = [&](const CentroidalState& at) { return Vec<1>(problem.StageCost(0, at, u)); };
    EXPECT_TRUE(IsJacobian(gx.transpose(), cost, x, 1e-6)) << i;
    EXPECT_GT(gx.norm(), 1e-2) << i;
  }
}

}  // namespace tenon::cdpr_clearance_test
