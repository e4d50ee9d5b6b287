#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Dense>

namespace tenon::inverse_geometrico_static_test {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr double kInfinity = INFINITY;

CableKinematics Cables(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  return CalcCableKinematics(robot, equilibrium.p_WB, equilibrium.R_WB);
}

double RelativeResidual(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  const Vector6d gravity = GravityWrench(robot);
  return (Cables(robot, equilibrium).structure * equilibrium.tension + gravity).norm() / gravity.norm();
}

template <class... Keys>
::testing::AssertionResult RefusesPlace(const CdprDescription& robot, const Vector3d& p_WB,
                                        const StaticsOptions& options, const Keys&... keys) {
  return Throws<ParameterError>([&] { SolveInverseGeometricoStatic(robot, p_WB, options); }, keys...);
}

// Solves six equations for roll, pitch and the tensions of four cables at a given yaw by Newton's method from
// `x` = (roll, pitch, u). Returns false if it does not converge.
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
        if (!(CalcLockedStiffness(robot, cables, p, R_WB, tension) > 0)) continue;
        least = std::min(least, tension.norm());
        ++members;
      }
    }
    EXPECT_GT(members, 3);
    EXPECT_LE(found.tension.norm(), least + 1e-9);
    EXPECT_GE(found.tension.norm(), least - 1e-2);
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
    StaticsOptions options{.attitude = Vector3d(0.02, -0.03, 0.05)};
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

TEST(InverseGeometricoStatic, ThreeCablesHoldThePlatformAtOneAttitude) {
  const CdprDescription robot = test::ThreeCableRobot();
  for (const Vector3d& p : {Vector3d(0, 0, 2), Vector3d(0.6, -0.4, 1.5)}) {
    const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
    EXPECT_LT(RelativeResidual(robot, found), 1e-12);
    EXPECT_GT(found.stiffness_min, 0);
  }
}

// The lines of two cables and that of the weight meet in one point.
TEST(InverseGeometricoStatic, TwoCablesHoldThePlatformInTheirPlane) {
  for (const int normal : {1, 0}) {
    CdprDescription robot = test::PlanarRobot(2);
    Vector3d p(0.8, 0, 2.3);
    if (normal == 0) {
      for (CableDescription& cable : robot.cables) {
        std::swap(cable.anchor_W[0], cable.anchor_W[1]);
        std::swap(cable.attachment_B[0], cable.attachment_B[1]);
      }
      std::swap(p[0], p[1]);
    }
    const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
    EXPECT_LT(RelativeResidual(robot, found), 1e-12);
    EXPECT_GT(found.stiffness_min, 0);
    EXPECT_EQ(found.euler[1 - normal], 0);
    EXPECT_EQ(found.euler[2], 0);
    const CableKinematics cables = Cables(robot, found);
    double height[2];
    for (const int i : {0, 1}) {
      const Vector3d arm = cables.arm_W.col(i), along = cables.direction.col(i);
      height[i] = arm[2] - arm[1 - normal] / along[1 - normal] * along[2];  // of the line, above the CoM
    }
    EXPECT_NEAR(height[0], height[1], 1e-9);
    EXPECT_GT(std::abs(found.euler[normal]), 0.01);
  }
}

// No angle in the plane has smaller tensions.
TEST(InverseGeometricoStatic, FourCablesOfAPlanarRobotHaveTheLeastTensions) {
  CdprDescription robot = test::PlanarRobot(4);
  robot.cable.tension_min = 10;
  const Vector3d p(0.8, 0, 2.3);
  const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, p);
  EXPECT_LT(RelativeResidual(robot, found), 1e-12);
  EXPECT_GE(found.tension.minCoeff(), 10);
  int feasible = 0;
  for (double pitch = -1; pitch < 1; pitch += 0.002) {
    const CableKinematics cables = CalcCableKinematics(robot, p, RotationFromEuler({0, pitch, 0}));
    const TensionDistribution other =
        DistributeTension(cables.structure, -GravityWrench(robot), robot.tension_min(), robot.tension_max());
    if (!other.feasible) continue;
    ++feasible;
    EXPECT_GE(other.tension.norm(), found.tension.norm() - 1e-9) << pitch;
  }
  EXPECT_GT(feasible, 20);

  StaticsOptions options{.attitude = Vector3d(0, found.euler[1] + 0.01, 0), .tension_aim = 100};
  const StaticEquilibrium turned = SolveInverseGeometricoStatic(robot, p, options);
  EXPECT_LT(RelativeResidual(robot, turned), 1e-12);
}

// The platform hangs upright below the point, and the forces at the point balance.
TEST(InverseGeometricoStatic, CablesInOnePointHoldTheCom) {
  for (const int cables : {3, 4})
    for (const double above : {0.0, 0.1}) {
      SCOPED_TRACE(std::to_string(cables) + " cables, above by " + std::to_string(above));
      CdprDescription robot = test::OnePointRobot(cables, above);
      robot.cable.tension_min = 1;
      const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {1, 0.5, 2});
      EXPECT_THAT(found.euler, IsNear(Vector3d::Zero(), 1e-9));
      Vector3d force(0, 0, -9.81 * robot.mass);
      for (int i = 0; i < cables; ++i)
        force +=
            found.tension[i] *
            (robot.cables[static_cast<std::size_t>(i)].anchor_W - Vector3d(1, 0.5, 2 + above)).normalized();
      EXPECT_THAT(force, IsNear(Vector3d::Zero(), 1e-9));
      EXPECT_GE(found.tension.minCoeff(), 1 - 1e-9);
    }
}

// A spring without rest length that carries half of the weight halves the tensions; on several springs the
// platform is in balance everywhere, also above the anchors.
TEST(InverseGeometricoStatic, SpringsCarryTheirShare) {
  CdprDescription robot = test::FourCableRobot();
  const StaticEquilibrium without = SolveInverseGeometricoStatic(robot, {0, 0, 2});
  robot.springs = {{{0, 0, 5}, {0, 0, 0}, robot.mass * 9.81 / 2 / 3, 0}};
  const StaticEquilibrium half = SolveInverseGeometricoStatic(robot, {0, 0, 2});
  EXPECT_THAT(half.tension, IsNear(without.tension / 2, 1e-8));
  EXPECT_LT(half.euler.norm(), 1e-9);

  robot.springs[0].stiffness = 200;
  EXPECT_NO_THROW(SolveInverseGeometricoStatic(robot, {0, 0, 4.2}));
  EXPECT_TRUE(RefusesPlace(test::FourCableRobot(), {0, 0, 4.2}, {}, "not below the highest anchor"));
  for (const bool six : {false, true}) {
    const CdprDescription sprung = test::WithSprings(six ? test::SixCableRobot() : test::FourCableRobot());
    StaticsOptions options;
    if (six) options.attitude = Vector3d(0.05, -0.02, 0.1);
    const StaticEquilibrium found = SolveInverseGeometricoStatic(sprung, {0.4, -0.3, 1.7}, options);
    const Vector6d passive = PassiveWrench(sprung, found.p_WB, found.R_WB);
    EXPECT_THAT(Cables(sprung, found).structure * found.tension, IsNear(-passive, 1e-9));
    EXPECT_GT((passive - GravityWrench(sprung)).norm(), 20);
  }
}

// The table carries the weight: tensions are as low as their bound permits, and balance in the plane.
TEST(InverseGeometricoStatic, ATableCarriesTheWeight) {
  CdprDescription robot = test::TableRobot();
  const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {0.3, 0.2, 1});
  EXPECT_LT((CalcCableKinematics(robot, found.p_WB, found.R_WB).structure * found.tension).norm(), 1e-9);
  EXPECT_NEAR(found.tension.minCoeff(), 30, 1e-9);
  EXPECT_EQ(found.euler.head<2>(), Eigen::Vector2d::Zero());
  robot.on_table = false;
  EXPECT_TRUE(RefusesPlace(robot, {0.3, 0.2, 1}, {}, "set on_table"));
}

TEST(InverseGeometricoStatic, RefusesPlacesOutOfThePlane) {
  const CdprDescription planar = test::PlanarRobot(4);
  EXPECT_TRUE(RefusesPlace(planar, {0, 0.1, 2}, {}, "'planar'", "in the plane y = 0 m only"));
  EXPECT_TRUE(RefusesPlace(planar, {0, 0, 2}, {.attitude = Vector3d(0.1, 0, 0)}, "turn it about y only"));
  EXPECT_TRUE(
      RefusesPlace(test::PlanarRobot(2), {0, 0, 2}, {.attitude = Vector3d::Zero()}, "takes 3 cables"));
  CdprDescription oblique = test::PlanarRobot(2);
  oblique.cables[0].anchor_W[1] = 1;
  EXPECT_TRUE(RefusesPlace(test::TableRobot(), {0, 0, 2}, {}, "in the plane z = 1 m only"));
  EXPECT_TRUE(RefusesPlace(test::OnePointRobot(4, -0.1), {0.5, 0, 2}, {}, "attach the cables above the CoM"));
  EXPECT_TRUE(RefusesPlace(test::OnePointRobot(4, 0.1), {0, 0, 2}, {.attitude = Vector3d::Zero()},
                           "cables that do not all end in one point"));
  EXPECT_TRUE(RefusesPlace(oblique, {0, 0, 2}, {}, "the vertical plane of their anchors"));
}

TEST(InverseGeometricoStatic, BoundsAreKept) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_min = 15;
  const StaticEquilibrium found = SolveInverseGeometricoStatic(robot, {3, 0.8, 2});
  EXPECT_EQ(found.tension.minCoeff(), 15);
  EXPECT_LT(RelativeResidual(robot, found), 1e-12);

  const double highest = found.tension.maxCoeff();
  int cable = 0;
  found.tension.maxCoeff(&cable);
  robot.cables[static_cast<std::size_t>(cable)].tension_max = highest - 2;
  const StaticEquilibrium relieved = SolveInverseGeometricoStatic(robot, {3, 0.8, 2});
  EXPECT_DOUBLE_EQ(relieved.tension[cable], highest - 2);
  EXPECT_LT(RelativeResidual(robot, relieved), 1e-12);
}

TEST(InverseGeometricoStatic, RefusesPlacesWhereItCannotRest) {
  struct Case {
    Vector3d p_WB;
    std::function<void(CdprDescription&)> change;
    const char *place, *reason;
  };
  const Case cases[] = {
      // Above the anchors, beside them, in an anchor, and beyond the largest tension.
      {{0.5, 0, 4.5}, [](auto&) {}, "(0.5, 0, 4.5) m", "z = 4 m"},
      {{3.5, 2, 2}, [](auto&) {}, "(3.5, 2, 2) m", "cable 2 of 4"},
      {{4.5, 1, 2}, [](auto&) {}, "(4.5, 1, 2) m", "cable 2 of 4"},
      {{3.425, 4.425, 3.907}, [](auto&) {}, "(3.425, 4.425, 3.907) m", "'four'"},
      {{0, 0, 2}, [](auto& robot) { robot.cable.tension_max = 100; }, "(0, 0, 2) m", "114.04 N"},
      // The platform reaches its pulleys, or tips over.
      {{0.5, 0, 2}, [](auto& robot) { robot.winch.pulley_radius = 4; }, "(0.5, 0, 2) m", "pulley_radius_m"},
      {{0, 0, 2},
       [](auto& robot) {
         for (CableDescription& cable : robot.cables) cable.attachment_B.z() = -0.3;
       },
       "(0, 0, 2) m",
       "unstable"},
      // Attachments turned by a quarter turn against the anchors: the platform turns by more than 80 deg.
      {{0, 0, 2},
       [](auto& robot) {
         const Matrix3d turn = RotationFromEuler({0, 0, 1.6});
         for (CableDescription& cable : robot.cables) cable.attachment_B = turn * cable.attachment_B;
       },
       "(0, 0, 2) m",
       "80 deg"}};
  for (const Case& c : cases) {
    CdprDescription robot = test::FourCableRobot();
    c.change(robot);
    EXPECT_TRUE(RefusesPlace(robot, c.p_WB, {}, c.place, c.reason));
  }
}

TEST(InverseGeometricoStatic, RefusesAPrescribedAttitudeThatCannotBeHeld) {
  const StaticsOptions level{.attitude = Vector3d::Zero()};
  EXPECT_TRUE(RefusesPlace(test::FourCableRobot(), {0, 0, 2}, level, "attitude", "6 cables"));
  EXPECT_TRUE(RefusesPlace(test::SixCableRobot(), {-3, 0, 2}, level, "attitude", "cable "));
  CdprDescription robot = test::SixCableRobot();
  robot.winch.pulley_radius = 4;
  EXPECT_TRUE(RefusesPlace(robot, {0.5, 0, 2}, level, "pulley_radius_m"));
}

TEST(InverseGeometricoStatic, RefusesNonsense) {
  const auto refuses = [](const auto& change, const char* key) {
    CdprDescription robot = test::FourCableRobot();
    change(robot);
    return RefusesPlace(robot, {0, 0, 2}, {}, "'four'", key);
  };
  EXPECT_TRUE(refuses([](auto& robot) { robot.cables.resize(1); }, "1 cables"));
  EXPECT_TRUE(refuses([](auto& robot) { robot.mass = 0; }, "mass"));
  EXPECT_TRUE(refuses([](auto& robot) { robot.inertia_B.setZero(); }, "inertia"));
  EXPECT_TRUE(refuses([](auto& robot) { robot.cable.tension_min = 900; }, "[900, 800] N"));
  EXPECT_TRUE(RefusesPlace(test::FourCableRobot(), {0, INFINITY, 2}, {}, "position"));
  const StaticsOptions options{.warm_start = SolveInverseGeometricoStatic(test::FiveCableRobot(), {0, 0, 2})};
  EXPECT_TRUE(RefusesPlace(test::FourCableRobot(), {0, 0, 2}, options, "warm start", "5", "4 cables"));
}

}  // namespace tenon::inverse_geometrico_static_test
