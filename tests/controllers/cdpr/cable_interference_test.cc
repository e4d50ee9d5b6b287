#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <random>

namespace tenon::cable_interference_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A cube of 0.4 m with a cable at each upper corner.
CdprDescription Cube() {
  CdprDescription robot = test::FourCableRobot();
  robot.cables.clear();
  for (const double x : {1, -1}) {
    for (const double y : {1, -1}) {
      robot.cables.push_back({{3 * x, 3 * y, 4}, {0.2 * x, 0.2 * y, 0.2}});
      robot.cables.push_back({{3 * x, 3 * y, 0}, {0.2 * x, 0.2 * y, -0.2}});
    }
  }
  return robot;
}

CableClearance At(const CdprDescription& robot, const Vector3d& p, const Matrix3d& R = Matrix3d::Identity()) {
  return CableInterference(robot).At(CalcCableKinematics(robot, p, R), R);
}

TEST(CableInterferenceTest, CablesThatCrossAreAsFarApartAsTheirPlanes) {
  CdprDescription robot = Cube();
  robot.cables = {
      {{3, 0, 2}, {-0.2, 0, 0.1}}, {{-3, 0.05, 2}, {0.2, 0.05, 0.1}}, {{0, 3, 2}, {0, 0.2, -0.2}}};
  EXPECT_NEAR(At(robot, {0, 0, 1}).cables, 0.05, 1e-12);
  robot.cables[1].anchor_W = robot.cables[0].anchor_W;  // these two end in one point
  EXPECT_GT(At(robot, {0, 0, 1}).cables, 0.1);
}

// Two cables that leave their pulleys level, one above the other, a pulley's radius above their anchors.
TEST(CableInterferenceTest, CablesLeaveFromTheirPulleys) {
  CdprDescription robot = Cube();
  robot.winch.pulley_radius = 0.2;
  robot.cables = {{{3, 0, 1.8}, {-0.2, 0, 0}}, {{0, 3, 2.1}, {0, -0.2, 0.3}}, {{-3, -3, 0}, {0, 0, -0.4}}};
  EXPECT_NEAR(At(robot, {0, 0, 2}).cables, 0.3, 1e-12);
}

// The sine at a corner of the cube is the largest of the components of the direction along its three normals.
TEST(CableInterferenceTest, SineIsThatOfTheCubesFaces) {
  const CdprDescription robot = Cube();
  const Vector3d p(1.9, -0.7, 2.6);
  const Matrix3d R = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const CableKinematics cables = CalcCableKinematics(robot, p, R);
  double least = 1;
  for (int i = 0; i < 8; ++i) {
    const Vector3d direction = R.transpose() * cables.direction.col(i);
    const Vector3d corner = robot.cables[i].attachment_B / 0.2;
    least = std::min(least, direction.cwiseProduct(corner).maxCoeff());
  }
  EXPECT_NEAR(At(robot, p, R).platform, least, 1e-12);
}

// The bound holds for random displacements and turns, and is sharper than twice the motion.
TEST(CableInterferenceTest, LeastDistanceIsALowerBound) {
  CdprDescription robot = Cube();
  const CableInterference interference(robot);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  constexpr double kDistance = 0.15, kAngle = 0.05;
  double sharpest = -1;
  for (int k = 0; k < 20; ++k) {
    const Vector3d p = Vector3d(0, 0, 2) + 0.8 * direction();
    const Matrix3d R = Eigen::AngleAxisd(0.3, direction()).toRotationMatrix();
    const CableKinematics cables = CalcCableKinematics(robot, p, R);
    const double bound = interference.LeastDistance(cables, kDistance, kAngle),
                 before = interference.At(cables, R).cables;
    EXPECT_LE(bound, before);
    sharpest = std::max(sharpest, bound - (before - 2 * (kDistance + kAngle * 0.2 * std::sqrt(3))));
    for (int i = 0; i < 50; ++i) {
      const Matrix3d turned = Eigen::AngleAxisd(kAngle, direction()).toRotationMatrix() * R;
      const CableKinematics moved = CalcCableKinematics(robot, p + kDistance * direction(), turned);
      EXPECT_GE(interference.At(moved, turned).cables, bound);
    }
  }
  EXPECT_GT(sharpest, 0.1);
}

TEST(CableInterferenceTest, AllocatesNothing) {
  const CdprDescription robot = Cube();
  const CableInterference interference(robot);
  const CableKinematics cables = CalcCableKinematics(robot, {0, 0, 2}, Matrix3d::Identity());
  const AllocationGuard guard;
  const CableClearance clearance = interference.At(cables, Matrix3d::Identity());
  EXPECT_EQ(guard.count(), 0);
  EXPECT_GT(clearance.cables, 0.1);
}

}  // namespace tenon::cable_interference_test
