#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/derivative_check.h>

#include <Eigen/Geometry>

#include <random>

namespace tenon::cdpr_kinematics_test {

using Eigen::AngleAxisd, Eigen::Matrix3d, Eigen::Vector3d;

const Vector3d kPosition(0.4, -0.3, 1.7);
const Vector3d kEuler(0.2, -0.3, 0.5);

Matrix3d Turn(const Vector3d& rotation) {
  return rotation.norm() > 0 ? AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix()
                             : Matrix3d(Matrix3d::Identity());
}

/// `robot` with pulleys whose effect is far above the tolerances.
CdprDescription WithPulleys(CdprDescription robot) {
  robot.winch.pulley_radius = 0.15;
  return robot;
}

/// `robot` with such pulleys on the platform.
CdprDescription WithWinchesOnBoard(CdprDescription robot) {
  robot.winch.pulleys_on_platform = true;
  return WithPulleys(robot);
}

TEST(Euler, IsYawThenPitchThenRoll) {
  const Matrix3d expected =
      (AngleAxisd(kEuler[2], Vector3d::UnitZ()) * AngleAxisd(kEuler[1], Vector3d::UnitY()) *
       AngleAxisd(kEuler[0], Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_LT((RotationFromEuler(kEuler) - expected).norm(), 1e-15);
}

TEST(Euler, ComesBackFromTheRotation) {
  for (const Vector3d& euler : {kEuler, Vector3d(-3, 1.5, 2), Vector3d(1, -1.2, -3), Vector3d(0, 0, 0)})
    EXPECT_LT((EulerFromRotation(RotationFromEuler(euler)) - euler).norm(), 1e-14);
}

TEST(Euler, RateMatrixGivesTheAngularVelocity) {
  const Vector3d rate(0.7, -1.1, 0.4);
  constexpr double kStep = 1e-6;
  const Matrix3d derivative =
      (RotationFromEuler(kEuler + kStep * rate) - RotationFromEuler(kEuler - kStep * rate)) / (2 * kStep);
  const Matrix3d cross = derivative * RotationFromEuler(kEuler).transpose();
  const Vector3d w_W(cross(2, 1), cross(0, 2), cross(1, 0));
  EXPECT_LT((EulerRateMatrix(kEuler) * rate - w_W).norm(), 1e-9);
}

TEST(CdprKinematics, FirstCableAtTheCentreByHand) {
  const CdprDescription robot = test::FourCableRobot();
  const CableKinematics cables = CalcCableKinematics(robot, {0, 0, 2}, Matrix3d::Identity());
  const Vector3d span(3.425, 4.425, 1.907);
  ASSERT_EQ(cables.num_cables(), 4);
  EXPECT_NEAR(cables.length[0], span.norm(), 1e-15);
  EXPECT_LT((cables.direction.col(0) - span.normalized()).norm(), 1e-15);
  EXPECT_LT((cables.structure.col(0).head<3>() - span.normalized()).norm(), 1e-15);
  EXPECT_LT((cables.structure.col(0).tail<3>() - Vector3d(.075, .075, .093).cross(span.normalized())).norm(),
            1e-15);
}

TEST(CdprKinematics, LengthRatesAreTheDerivativeOfTheLengths) {
  for (const CdprDescription& robot : {test::EightCableRobot(), WithPulleys(test::EightCableRobot()),
                                       WithWinchesOnBoard(test::EightCableRobot())}) {
    const Vector3d v_W(0.3, 0.8, -0.5), w_W(-0.6, 0.2, 0.9);
    const Matrix3d R_WB = RotationFromEuler(kEuler);
    constexpr double kStep = 1e-6;
    const CableVector ahead =
        CalcCableKinematics(robot, kPosition + kStep * v_W, Turn(kStep * w_W) * R_WB).length;
    const CableVector behind =
        CalcCableKinematics(robot, kPosition - kStep * v_W, Turn(-kStep * w_W) * R_WB).length;
    const Vector6d twist = (Vector6d() << v_W, w_W).finished();
    const CableVector rates = -CalcCableKinematics(robot, kPosition, R_WB).structure.transpose() * twist;
    EXPECT_LT((rates - (ahead - behind) / (2 * kStep)).norm(), 3e-9);
  }
}

TEST(CdprKinematics, WrenchJacobianIsTheDerivativeOfTheWrench) {
  for (const CdprDescription& robot : {test::FourCableRobot(), WithPulleys(test::FourCableRobot()),
                                       WithWinchesOnBoard(test::FourCableRobot())}) {
    const Matrix3d R_WB = RotationFromEuler(kEuler);
    CableVector tension(4);
    tension << 120, 30, 80, 200;
    const Matrix6d jacobian = CalcWrenchJacobian(CalcCableKinematics(robot, kPosition, R_WB), tension);
    constexpr double kStep = 1e-6;
    for (int j = 0; j < 6; ++j) {
      const Vector6d x = kStep * Vector6d::Unit(j);
      const auto wrench = [&](double sign) -> Vector6d {
        return CalcCableKinematics(robot, kPosition + sign * x.head<3>(), Turn(sign * x.tail<3>()) * R_WB)
                   .structure *
               tension;
      };
      EXPECT_LT((jacobian.col(j) - (wrench(1) - wrench(-1)) / (2 * kStep)).norm(), 1e-7) << "column " << j;
    }
  }
}

// By hand: with the attachment at the height of the pulley's top, the cable leaves it there, level.
TEST(CdprKinematics, CableLeavesItsPulleyTangentially) {
  CdprDescription robot = test::FourCableRobot();
  robot.winch.pulley_radius = 0.1;
  const CableDescription& cable = robot.cables[0];
  const Vector3d outwards = Vector3d(-3, -4, 0) / 5;
  const Vector3d attachment = cable.anchor_W + (0.1 + 2) * outwards + Vector3d(0, 0, 0.1);
  const CableLine line = CalcCableLine(robot, 0, attachment - cable.attachment_B, Matrix3d::Identity());
  EXPECT_LT((line.exit_W - cable.anchor_W - 0.1 * outwards - Vector3d(0, 0, 0.1)).norm(), 1e-14);
  EXPECT_LT((line.direction + outwards).norm(), 1e-14);
  EXPECT_NEAR(line.free_length, 2, 1e-14);
  EXPECT_NEAR(line.length, 2 + 0.1 * M_PI / 2, 1e-14);
  EXPECT_NEAR(line.swivel.squaredNorm(), 1 / 2.0 - 1 / 2.1, 1e-13);
}

// A fixed anchor with a pulley sees a platform as that platform with a pulley sees its anchor.
TEST(CdprKinematics, ThePulleyOnAPlatformIsThePulleyAtAnAnchorSeenFromTheOtherEnd) {
  CdprDescription carried = WithWinchesOnBoard(test::FourCableRobot()), seen = WithPulleys(carried);
  seen.winch.pulleys_on_platform = false;
  const Matrix3d R_WB = RotationFromEuler(kEuler);
  seen.cables[2].anchor_W = carried.cables[2].attachment_B;
  seen.cables[2].attachment_B.setZero();
  const Vector3d anchor_B = R_WB.transpose() * (carried.cables[2].anchor_W - kPosition);
  const CableLine here = CalcCableLine(carried, 2, kPosition, R_WB);
  const CableLine there = CalcCableLine(seen, 2, anchor_B, Matrix3d::Identity());
  EXPECT_NEAR(here.length, there.length, 1e-14);
  EXPECT_LT((here.arm_W - R_WB * there.exit_W).norm(), 1e-14);
  EXPECT_LT((here.direction + R_WB * there.direction).norm(), 1e-14);
}

TEST(CdprKinematics, NotANumberPropagates) {
  for (const CdprDescription& robot : {test::FourCableRobot(), WithPulleys(test::FourCableRobot())}) {
    const Vector3d nowhere(NAN, 0, 1);
    EXPECT_TRUE(std::isnan(CalcCableLine(robot, 0, nowhere, Matrix3d::Identity()).length));
  }
}

TEST(CdprKinematics, RefusesCablesThatEndOnTheirPulleyOrAnchor) {
  const auto refuses = [](const CdprDescription& robot, const Vector3d& from_anchor) {
    const Vector3d p = robot.cables[1].anchor_W - robot.cables[1].attachment_B + from_anchor;
    return Throws<RunError>([&] { CalcCableKinematics(robot, p, Matrix3d::Identity()); }, "Cable 1",
                            "'four'");
  };
  EXPECT_TRUE(refuses(WithPulleys(test::FourCableRobot()), {0.1, 0, 0.05}));
  EXPECT_TRUE(refuses(test::FourCableRobot(), {0, 0, 0}));
}

TEST(CdprKinematics, GravityPullsDown) {
  EXPECT_EQ(GravityWrench(test::FourCableRobot()), 15 * -9.81 * Vector6d::Unit(2));
}

TEST(CdprKinematics, SpringsPullByTheGradientOfTheirEnergy) {
  const CdprDescription robot = test::WithSprings(test::FourCableRobot());
  const Matrix3d R_WB = RotationFromEuler(kEuler);
  const auto at = [&](const Vector6d& x) -> Matrix3d { return Turn(x.tail<3>()) * R_WB; };
  const auto energy = [&](const Vector6d& x) -> Eigen::VectorXd {
    const double joules = CalcSpringEnergy(robot.springs, kPosition + x.head<3>(), at(x));
    return Eigen::VectorXd::Constant(1, joules + robot.mass * 9.81 * x[2]);
  };
  const auto wrench = [&](const Vector6d& x) -> Eigen::VectorXd {
    return PassiveWrench(robot, kPosition + x.head<3>(), at(x));
  };
  const Vector6d here = Vector6d::Zero();
  EXPECT_TRUE(IsJacobian(-wrench(here).transpose(), energy, here, 1e-8));
  Matrix6d jacobian;
  PassiveWrench(robot, kPosition, R_WB, &jacobian);
  EXPECT_TRUE(IsJacobian(jacobian, wrench, here, 1e-7));
}

TEST(CdprKinematics, ASpringPushesIfItIsShortAndHasNoDirectionWithoutLength) {
  std::vector<SpringDescription> springs{{{0, 0, 1}, {0, 0, 0}, 50, 1.5}};
  EXPECT_THAT(CalcSpringWrench(springs, {0, 0, 0}, Matrix3d::Identity()),
              IsNear(Vector6d(-25 * Vector6d::Unit(2)), 1e-12));
  EXPECT_TRUE(Throws<RunError>(
      [&] {
        CalcSpringWrench(springs, {0, 0, 1}, Matrix3d::Identity());
      },
      "springs.0", "rest_length_m"));
  springs[0].rest_length = 0;
  EXPECT_EQ(CalcSpringWrench(springs, {0, 0, 1}, Matrix3d::Identity()), Vector6d::Zero());
}

TEST(CdprKinematics, CableAtItsRestLengthAndTensionHasItsLength) {
  const CdprDescription robot = test::FourCableRobot();
  CableVector length(4), tension(4);
  length << 5, 6, 7, 8;
  tension << 0, 100, 270, 800;
  const CableVector rest = CalcRestLengths(robot.cable, length, tension);
  EXPECT_DOUBLE_EQ(rest[0], 5);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(robot.cable.axial_stiffness * (length[i] - rest[i]) / rest[i], tension[i], 1e-9);
}

// Four vertical cables of length l leave three motions: sideways, with stiffness m g / l, and the turn of a
// quadrifilar pendulum, m g r^2 / l about the vertical with r the distance of the cables from the axis.
TEST(CdprKinematics, LockedStiffnessOfAQuadrifilarPendulum) {
  CdprDescription robot = test::FourCableRobot();
  for (CableDescription& cable : robot.cables) cable.anchor_W = cable.attachment_B + Vector3d(0, 0, 4);
  const CableKinematics cables = CalcCableKinematics(robot, {0, 0, 0}, Matrix3d::Identity());
  const CableVector tension = CableVector::Constant(4, robot.mass * 9.81 / 4);
  const Vector3d origin(0, 0, 0);
  const double sideways = robot.mass * 9.81 / 4, turn = sideways * 2 * 0.075 * 0.075;

  robot.inertia_B(2, 2) = 0.21;
  EXPECT_NEAR(CalcLockedStiffness(robot, cables, origin, Matrix3d::Identity(), tension),
              turn * robot.mass / 0.21, 1e-10);
  robot.inertia_B(2, 2) = 0.1;
  EXPECT_NEAR(CalcLockedStiffness(robot, cables, origin, Matrix3d::Identity(), tension), sideways, 1e-10);
  robot.springs = {{{9, 0, 0}, {0, 0, 0}, 2, 0}, {{-9, 0, 0}, {0, 0, 0}, 3, 0}};
  EXPECT_NEAR(CalcLockedStiffness(robot, cables, origin, Matrix3d::Identity(), tension), sideways + 5, 1e-10);
}

TEST(CdprKinematics, NoMotionIsLeftBySixCables) {
  const CdprDescription robot = test::SixCableRobot();
  const CableKinematics cables = CalcCableKinematics(robot, {0, 0, 2}, Matrix3d::Identity());
  const auto stiffness = [&](double tension) {
    return CalcLockedStiffness(robot, cables, {0, 0, 2}, Matrix3d::Identity(),
                               CableVector::Constant(6, tension));
  };
  EXPECT_EQ(stiffness(50), INFINITY);
  EXPECT_EQ(stiffness(0), -INFINITY);
}

// K is the Hessian of the energy of elastic cables, springs and gravity, by second differences.
TEST(CdprKinematics, ElasticStiffnessIsTheHessianOfTheEnergy) {
  const CdprDescription robot = test::WithSprings(test::SixCableRobot());
  const Vector3d p(0.3, -0.2, 1.8);
  const CableKinematics cables = CalcCableKinematics(robot, p, Matrix3d::Identity());
  const Eigen::MatrixXd W = cables.structure;
  const CableVector tension = test::Solve(W, -PassiveWrench(robot, p, Matrix3d::Identity()));
  const CableVector rest = CalcRestLengths(robot.cable, cables.length, tension);
  const auto energy = [&](const Vector6d& x) {
    const CableVector length = CalcCableKinematics(robot, p + x.head<3>(), Turn(x.tail<3>())).length;
    double sum =
        robot.mass * 9.81 * x[2] + CalcSpringEnergy(robot.springs, p + x.head<3>(), Turn(x.tail<3>()));
    for (int i = 0; i < 6; ++i)
      sum += robot.cable.axial_stiffness * (length[i] - rest[i]) * (length[i] - rest[i]) / (2 * rest[i]);
    return sum;
  };
  const Matrix6d K = CalcElasticStiffness(robot, cables, p, Matrix3d::Identity(), tension);
  constexpr double kStep = 1e-3;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      const Vector6d a = kStep * Vector6d::Unit(i), b = kStep * Vector6d::Unit(j);
      const double second =
          (energy(a + b) - energy(a - b) - energy(b - a) + energy(-a - b)) / (4 * kStep * kStep);
      EXPECT_NEAR(K(i, j), second, 1e-5 * K.norm()) << i << ", " << j;
      EXPECT_EQ(K(i, j), K(j, i));
    }
  }
}

// Pushed at its CoM, the platform gives way by the compliance, and turns; least in the stiffest direction.
TEST(CdprKinematics, TranslationalStiffnessIsForceOverDisplacement) {
  const CdprDescription robot = test::SixCableRobot();
  const Vector3d p(0.3, -0.2, 1.8);
  const CableKinematics cables = CalcCableKinematics(robot, p, Matrix3d::Identity());
  const Matrix6d K =
      CalcElasticStiffness(robot, cables, p, Matrix3d::Identity(), CableVector::Constant(6, 40));
  const double least = CalcLeastTranslationalStiffness(K);
  double softest = INFINITY;
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j <= 30; ++j) {
      Vector6d force = Vector6d::Zero();
      const double a = 2 * M_PI * i / 60, b = M_PI * j / 30;
      force.head<3>() << std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b);
      softest = std::min(softest, 1 / test::Solve(K, force).topRows(3).norm());
    }
  }
  EXPECT_GE(softest, least * (1 - 1e-12));
  EXPECT_LT(softest, least * 1.01);
  EXPECT_EQ(CalcLeastTranslationalStiffness(K - 2 * K.norm() * Matrix6d::Identity()), 0);
}

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
    const double sine = direction.cwiseProduct(corner).maxCoeff();
    EXPECT_NEAR(CableInterference(robot).PlatformSine(i, cables, R), sine, 1e-12);
    least = std::min(least, sine);
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

}  // namespace tenon::cdpr_kinematics_test
