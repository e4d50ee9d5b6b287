#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Dense>

#include <string>
#include <vector>

namespace tenon::inverse_geometrico_static_test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kInfinity = INFINITY;

CableKinematics Cables(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  return CalcCableKinematics(robot, equilibrium.p_WB, equilibrium.R_WB);
}

double RelativeResidual(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  const Vector6d gravity = GravityWrench(robot);
  return (Cables(robot, equilibrium).structure * equilibrium.tension + gravity).norm() / gravity.norm();
}

std::string Refusal(const CdprDescription& robot, const Vector3d& p_WB, const StaticsOptions& options = {}) {
  try {
    SolveInverseGeometricoStatic(robot, p_WB, options);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

// The member of the family of four cables that has a given yaw: six equations for roll, pitch and the
// tensions, by Newton's method from `x` = (roll, pitch, u). False if it does not converge.
bool SolveAtYaw(const CdprDescription& robot, const Vector3d& p_WB, double yaw, Vector6d* x) {
  for (int i = 0; i < 30; ++i) {
    const Vector3d euler((*x)[0], (*x)[1], yaw);
    const CableVector u = x->tail<4>();
    const CableKinematics cables = CalcCableKinematics(robot, p_WB, RotationFromEuler(euler));
    const Vector6d residual = cables.structure * u + GravityWrench(robot);
    if (residual.norm() < 1e-10) return true;
    Matrix6d jacobian;
    const Matrix3d turn = EulerRateMatrix(euler);
    jacobian.leftCols<2>() = CalcWrenchJacobian(cables, u).rightCols<3>() * turn.leftCols<2>();
    jacobian.rightCols<4>() = cables.structure;
    *x -= test::Solve(jacobian, residual);
  }
  return false;
}

// The least stiffness from the energy itself: moves the platform by a small x along the motions that are
// left, puts the lengths back by moving across them, and takes second differences of the height.
double LockedStiffnessByDifferences(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  const CableKinematics cables = Cables(robot, equilibrium);
  const MatrixXd N = MatrixXd(cables.structure.transpose()).fullPivLu().kernel();
  const auto height = [&](const VectorXd& along) {
    Vector6d x = N * along;
    for (int i = 0; i < 10; ++i) {
      const Vector3d rotation = x.tail<3>();
      const Matrix3d turn =
          Eigen::AngleAxisd(rotation.norm(), rotation.norm() > 0 ? rotation.normalized() : Vector3d::UnitX())
              .toRotationMatrix();
      const CableKinematics moved =
          CalcCableKinematics(robot, equilibrium.p_WB + x.head<3>(), turn * equilibrium.R_WB);
      const VectorXd stretch = moved.length - equilibrium.length;
      x += MatrixXd(cables.structure) * test::Solve(cables.structure.transpose() * cables.structure, stretch);
    }
    return x[2];
  };
  const int k = static_cast<int>(N.cols());
  constexpr double kStep = 1e-3;
  MatrixXd stiffness(k, k);
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j < k; ++j) {
      const VectorXd a = kStep * VectorXd::Unit(k, i), b = kStep * VectorXd::Unit(k, j);
      stiffness(i, j) = robot.mass * 9.81 * (height(a + b) - height(a - b) - height(b - a) + height(-a - b)) /
                        (4 * kStep * kStep);
    }
  }
  Matrix6d mass = robot.mass * Matrix6d::Identity();
  mass.bottomRightCorner<3, 3>() = equilibrium.R_WB * robot.inertia_B * equilibrium.R_WB.transpose();
  const MatrixXd projected = N.transpose() * mass * N;
  return robot.mass * test::Eigenvalues(test::Solve(projected, stiffness)).real().minCoeff();
}

const std::vector<Vector3d> kPositions = {{0, 0, 2},     {0.5, 0, 2}, {1, -0.7, 1.5}, {-2, 1.5, 2.5},
                                          {2.5, -3, 1},  {0, 3.5, 2}, {3.25, 1.5, 2}, {-1.2, -0.4, 0.8},
                                          {0.3, 0.2, 3}, {-3, 3, 1.2}};

TEST(InverseGeometricoStatic, CentreHasTheClosedForm) {
  const CdprDescription robot = test::FourCableRobot();
  const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {0, 0, 2});
  const Vector3d span(3.5 - 0.075, 4.5 - 0.075, 4 - 2 - 0.093);
  EXPECT_LT(found.euler.norm(), 1e-10);
  EXPECT_LT((found.length.array() - span.norm()).abs().maxCoeff(), 1e-10);
  EXPECT_LT((found.tension.array() - 15 * 9.81 * span.norm() / (4 * span.z())).abs().maxCoeff(), 1e-8);
  EXPECT_GT(found.stiffness_min, 0);
}

TEST(InverseGeometricoStatic, IsInBalanceToRounding) {
  const CdprDescription robot = test::FourCableRobot();
  for (const Vector3d& p : kPositions) {
    const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
    SCOPED_TRACE(p.transpose());
    EXPECT_LT(RelativeResidual(robot, found), 1e-12);
    EXPECT_GE(found.tension.minCoeff(), 0);
    EXPECT_LE(found.tension.maxCoeff(), 800);
    EXPECT_EQ(found.p_WB, p);
    EXPECT_LT((found.R_WB - RotationFromEuler(found.euler)).norm(), 1e-15);
    EXPECT_LT((found.length - Cables(robot, found).length).norm(), 1e-15);
  }
}

TEST(InverseGeometricoStatic, MirroredPositionsHaveMirroredAttitudes) {
  const CdprDescription robot = test::FourCableRobot();
  const StaticEquilibrium a = SolveInverseGeometricoStatic(robot, {1.2, 0.8, 2});
  const StaticEquilibrium b = SolveInverseGeometricoStatic(robot, {1.2, -0.8, 2});
  EXPECT_LT((a.euler - Vector3d(-b.euler[0], b.euler[1], -b.euler[2])).norm(), 1e-9);
  EXPECT_NEAR(a.tension[0], b.tension[1], 1e-7);
}

// Sweeps the one free parameter of the family, as yaw in steps of 0.1 deg: no stable member within the bounds
// has a smaller norm, and the best of the sweep is next to the solution.
TEST(InverseGeometricoStatic, IsTheLeastNormOfTheFamily) {
  const CdprDescription robot = test::FourCableRobot();
  constexpr double kDegree = 0.017453292519943295;
  for (const Vector3d& p : kPositions) {
    SCOPED_TRACE(p.transpose());
    const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
    double least = kInfinity;
    int members = 0;
    for (const double direction : {1, -1}) {
      Vector6d x;
      x << found.euler.head<2>(), found.tension;
      for (int step = 0; step <= 300; ++step) {
        const double yaw = found.euler[2] + direction * step * 0.1 * kDegree;
        if (!SolveAtYaw(robot, p, yaw, &x)) break;
        const CableVector tension = x.tail<4>();
        const Matrix3d R_WB = RotationFromEuler({x[0], x[1], yaw});
        const CableKinematics cables = CalcCableKinematics(robot, p, R_WB);
        if (tension.minCoeff() < -1e-9 || tension.maxCoeff() > 800) continue;
        if (!(CalcLockedStiffness(robot, cables, R_WB, tension) > 0)) continue;
        least = std::min(least, tension.norm());
        ++members;
      }
    }
    EXPECT_GT(members, 3);
    EXPECT_LE(found.tension.norm(), least + 1e-9);
    EXPECT_GE(found.tension.norm(), least - 1e-2);
  }
}

TEST(InverseGeometricoStatic, StiffnessIsThatOfTheEnergyWithTheLengthsLocked) {
  for (const CdprDescription& robot : {test::FourCableRobot(), test::FiveCableRobot()}) {
    for (const Vector3d& p : {Vector3d(0, 0, 2), Vector3d(0.5, 0, 2), Vector3d(-1.5, 2, 1.5)}) {
      const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
      EXPECT_NEAR(found.stiffness_min / LockedStiffnessByDifferences(robot, found), 1, 1e-3);
    }
  }
}

TEST(InverseGeometricoStatic, WarmStartStaysOnTheBranch) {
  const CdprDescription robot = test::FourCableRobot();
  StaticsOptions options;
  for (int i = 0; i <= 20; ++i) {
    const Vector3d p(0.1 * i, 0.15 * i, 2);
    const StaticEquilibrium cold = SolveInverseGeometricoStatic(robot, p);
    const StaticEquilibrium warm = SolveInverseGeometricoStatic(robot, p, options);
    EXPECT_LT((warm.euler - cold.euler).norm(), 1e-9);
    EXPECT_LT((warm.tension - cold.tension).norm(), 1e-7);
    options.warm_start = warm;
  }
}

TEST(InverseGeometricoStatic, HeavierRobotHasTheSameAttitude) {
  CdprDescription robot = test::FourCableRobot();
  const StaticEquilibrium light = SolveInverseGeometricoStatic(robot, {0.5, 0.5, 2});
  robot.mass *= 1.2;
  const StaticEquilibrium heavy = SolveInverseGeometricoStatic(robot, {0.5, 0.5, 2});
  EXPECT_LT((light.euler - heavy.euler).norm(), 1e-9);
  EXPECT_LT((1.2 * light.tension - heavy.tension).norm(), 1e-7);
}

TEST(InverseGeometricoStatic, FifthCableLowersTheNorm) {
  const CdprDescription four = test::FourCableRobot(), five = test::FiveCableRobot();
  const StaticEquilibrium found = SolveInverseGeometricoStatic(five, {0.5, 0.3, 2});
  EXPECT_LT(RelativeResidual(five, found), 1e-12);
  EXPECT_GE(found.tension.minCoeff(), 0);
  EXPECT_LT(found.tension.norm(), SolveInverseGeometricoStatic(four, {0.5, 0.3, 2}).tension.norm());
}

TEST(InverseGeometricoStatic, SixAndEightCablesHoldAPrescribedAttitude) {
  for (CdprDescription robot : {test::SixCableRobot(), test::EightCableRobot()}) {
    SCOPED_TRACE(robot.name);
    StaticsOptions options;
    options.attitude = Vector3d(0.02, -0.03, 0.05);
    const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {0.1, 0.2, 2}, options);
    EXPECT_EQ(found.euler, *options.attitude);
    EXPECT_LT(RelativeResidual(robot, found), 1e-12);
    EXPECT_GE(found.tension.minCoeff(), 0);
    EXPECT_EQ(found.stiffness_min, kInfinity);

    options.attitude.reset();
    const StaticEquilibrium free = SolveInverseGeometricoStatic(robot, {0.1, 0.2, 2}, options);
    EXPECT_LT(RelativeResidual(robot, free), 1e-12);
    EXPECT_LT(free.tension.norm(), found.tension.norm());
  }
}

TEST(InverseGeometricoStatic, BoundsAreKept) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_min = 15;
  const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {3, 0.8, 2});
  EXPECT_EQ(found.tension.minCoeff(), 15);
  EXPECT_LT(RelativeResidual(robot, found), 1e-12);
}

TEST(InverseGeometricoStatic, RefusesAPlaceAboveTheAnchors) {
  const std::string refusal = Refusal(test::FourCableRobot(), {0.5, 0, 4.5});
  EXPECT_THAT(refusal, HasSubstr("Robot 'four' cannot rest with its CoM at (0.5, 0, 4.5) m: "));
  EXPECT_THAT(refusal, HasSubstr("not below the highest anchor, at z = 4 m"));
}

TEST(InverseGeometricoStatic, RefusesAPlaceBesideTheAnchorsAndNamesTheCable) {
  const CdprDescription robot = test::FourCableRobot();
  EXPECT_THAT(
      Refusal(robot, {3.5, 2, 2}),
      HasSubstr("at (3.5, 2, 2) m: cable 2 of 4 would need -16.95 N, outside its bounds [0, 800] N."));
  const std::string refusal = Refusal(robot, {4.5, 1, 2});
  EXPECT_THAT(refusal,
              HasSubstr("torques aside, no tensions within [0, 800] N balance the wrench: cable 2 of 4"));
}

TEST(InverseGeometricoStatic, RefusesPulleysThatReachThePlatform) {
  CdprDescription robot = test::FourCableRobot();
  robot.winch.pulley_radius = 4;
  EXPECT_THAT(
      Refusal(robot, {0.5, 0, 2}),
      ::testing::AllOf(HasSubstr("cannot rest with its CoM at (0.5, 0, 2) m: Cable 0 of 'four' would end"),
                       HasSubstr("or give a smaller pulley_radius_m")));
  robot = test::SixCableRobot();
  robot.winch.pulley_radius = 4;
  EXPECT_THAT(Refusal(robot, {0.5, 0, 2}, {.attitude = Vector3d::Zero()}), HasSubstr("would end"));
}

TEST(InverseGeometricoStatic, RefusesTensionsAboveTheMaximum) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_max = 100;
  EXPECT_THAT(Refusal(robot, {0, 0, 2}),
              HasSubstr("of 4 would need 114.04 N, outside its bounds [0, 100] N"));
}

TEST(InverseGeometricoStatic, RefusesWhatWouldTipOver) {
  CdprDescription robot = test::FourCableRobot();
  for (CableDescription& cable : robot.cables) cable.attachment_B.z() = -0.3;
  EXPECT_THAT(Refusal(robot, {0, 0, 2}), HasSubstr("its equilibria are unstable, the least stiffness is -"));
}

// Attachments turned by a quarter against the anchors: the platform turns back, or on, beyond 80 deg.
TEST(InverseGeometricoStatic, RefusesWhereThereIsNoEquilibrium) {
  CdprDescription robot = test::FourCableRobot();
  const Matrix3d turn = RotationFromEuler({0, 0, 1.6});
  for (CableDescription& cable : robot.cables) cable.attachment_B = turn * cable.attachment_B;
  EXPECT_THAT(Refusal(robot, {0, 0, 2}),
              HasSubstr("there is no equilibrium with roll, pitch and yaw within 80 deg"));
}

TEST(InverseGeometricoStatic, RefusesAnAttachmentInItsAnchor) {
  const CdprDescription robot = test::FourCableRobot();
  EXPECT_THAT(Refusal(robot, robot.cables[0].anchor_W - robot.cables[0].attachment_B),
              HasSubstr("Robot 'four' cannot rest with its CoM at (3.425, 4.425, 3.907) m: "));
}

TEST(InverseGeometricoStatic, RefusesAPrescribedAttitudeThatCannotBeHeld) {
  StaticsOptions options;
  options.attitude = Vector3d::Zero();
  EXPECT_THAT(Refusal(test::FourCableRobot(), {0, 0, 2}, options),
              HasSubstr("an attitude is prescribed, which takes 6 cables, and it has 4"));
  EXPECT_THAT(
      Refusal(test::SixCableRobot(), {-3, 0, 2}, options),
      HasSubstr("at the prescribed attitude no tensions within [0, 800] N balance the wrench: cable "));
}

TEST(InverseGeometricoStatic, RefusesNonsense) {
  const CdprDescription robot = test::FourCableRobot();
  EXPECT_THAT(Refusal(robot, {0, kInfinity, 2}), HasSubstr("the position is not finite"));

  CdprDescription broken = robot;
  broken.cables.resize(3);
  EXPECT_THAT(Refusal(broken, {0, 0, 2}),
              HasSubstr("Robot 'four' has no statics: it has 3 cables, fewer than 4"));
  broken = robot;
  broken.mass = 0;
  EXPECT_THAT(Refusal(broken, {0, 0, 2}), HasSubstr("its mass is 0 kg"));
  broken = robot;
  broken.inertia_B.setZero();
  EXPECT_THAT(Refusal(broken, {0, 0, 2}), HasSubstr("its inertia is not positive definite"));
  broken = robot;
  broken.cable.tension_min = 900;
  EXPECT_THAT(Refusal(broken, {0, 0, 2}), HasSubstr("the tension bounds [900, 800] N"));

  StaticsOptions options;
  options.warm_start = SolveInverseGeometricoStatic(test::FiveCableRobot(), {0, 0, 2});
  EXPECT_THAT(Refusal(robot, {0, 0, 2}, options), HasSubstr("the warm start has 5 tensions for 4 cables"));
}

}  // namespace
}  // namespace tenon::inverse_geometrico_static_test
