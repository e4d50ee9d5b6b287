#include <tenon/tests/controllers/legged/whole_body/full_whole_body_qp.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/LU>

#include <numbers>

namespace tenon::whole_body_qp_test {

using test::IsOptimal, test::RandomVector;

constexpr std::array<bool, kNumLegs> kAll{true, true, true, true}, kDiagonal{true, false, false, true},
    kThree{false, true, true, true}, kNone{};

/// Near the nominal stance, in motion as in a walk.
LeggedState RandomWalking(const QuadrupedDescription& robot, RandomStream& random) {
  LeggedState x = test::Standing(robot);
  x.q_WB = QuaternionFromRotationVector(RandomVector<3>(random, 0.2));
  x.q += RandomVector<12>(random, 0.3);
  x.v_W = RandomVector<3>(random, 0.3);
  x.w_W = RandomVector<3>(random, 0.5);
  x.qd = RandomVector<12>(random, 3);
  return x;
}

WholeBodyTask RandomTask(const QuadrupedModel& model, const std::array<bool, kNumLegs>& stance,
                         RandomStream& random) {
  WholeBodyTask task;
  task.stance = stance;
  task.wrench << RandomVector<3>(random, 60), RandomVector<3>(random, 20);
  task.wrench[2] += model.mass() * model.gravity();
  task.disturbance << RandomVector<3>(random, 20), RandomVector<3>(random, 5);
  task.joint_disturbance = RandomVector<12>(random, 5);
  for (Vec<3>& a : task.foot_acceleration) a = RandomVector<3>(random, 20);
  return task;
}

Vec<6> WrenchOf(const QuadrupedDynamics& dynamics, const FootForces& force) {
  Vec<6> wrench = Vec<6>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    wrench.head<3>() += force[leg];
    wrench.tail<3>() += (dynamics.feet[leg].p_W - dynamics.com_W).cross(force[leg]);
  }
  return wrench;
}

/// nu' of the model under torques, ground forces and further generalised forces.
Vec<18> ForwardDynamics(const QuadrupedDynamics& dynamics, const Vec<12>& torque, const FootForces& force,
                        const Vec<18>& other) {
  Vec<18> right = other - dynamics.bias();
  right.tail<12>() += torque;
  for (int leg = 0; leg < kNumLegs; ++leg) right += dynamics.FootJacobian(leg).transpose() * force[leg];
  return test::Solve(dynamics.M, right);
}

class WholeBodyQpTest : public ::testing::TestWithParam<std::array<bool, kNumLegs>> {
 protected:
  static Vec<12> Limits() { return Vec<12>::Constant(60); }

  const QuadrupedDescription robot_ = test::DogBot();
  const QuadrupedModel model_{robot_};
  QuadrupedDynamics dynamics_;
};
INSTANTIATE_TEST_SUITE_P(Stance, WholeBodyQpTest, ::testing::Values(kAll, kDiagonal, kThree, kNone),
                         [](const auto& info) {
                           std::string name = "feet_";
                           for (const bool stands : info.param) name += stands ? '1' : '0';
                           return name;
                         });

TEST_F(WholeBodyQpTest, StandsOnItsFeet) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyQp qp(Limits());
  WholeBodyTask task;
  task.wrench[2] = model_.mass() * model_.gravity();
  WholeBodySolution solution;
  ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
  // The weights of forces and accelerations cost 1e-5 of the wrench.
  EXPECT_THAT(WrenchOf(dynamics_, solution.force), IsNear(task.wrench, 5e-3));
  EXPECT_THAT(solution.acceleration, IsNear(Vec<18>::Zero(), 5e-3));
  const Vec<12> torque = JointTorque(dynamics_, solution, Vec<12>::Zero());
  EXPECT_THAT(ForwardDynamics(dynamics_, torque, solution.force, Vec<18>::Zero()),
              IsNear(solution.acceleration, 1e-9));
}

// At rest the forces balance weight and moments: three conditions on f_z, of which four feet take the
// solution of least norm and three feet the only one. The torques are then those of statics.
TEST_F(WholeBodyQpTest, StandsOnFourAndOnThreeFeetAsStaticsSays) {
  LeggedState x = test::Standing(robot_);
  for (int leg = 0; leg < kNumLegs; ++leg) x.q[3 * leg + 1] += 0.15;  // the feet back, so that the CoM is
  model_.Calc(x, &dynamics_);                                         // inside the triangle of three
  for (const auto& stance : {kAll, std::array<bool, kNumLegs>{true, true, false, true}}) {
    Eigen::MatrixXd balance(3, 0);
    for (int leg = 0; leg < kNumLegs; ++leg) {
      if (!stance[leg]) continue;
      const Eigen::Vector3d r = dynamics_.feet[leg].p_W - dynamics_.com_W;
      balance.conservativeResize(3, balance.cols() + 1);
      balance.rightCols<1>() << 1, r[1], -r[0];
    }
    const double weight = model_.mass() * 9.81;
    const Eigen::VectorXd expected =
        balance.transpose() * test::Solve(balance * balance.transpose(), Eigen::Vector3d(weight, 0, 0));
    ASSERT_GT(expected.minCoeff(), 1);

    WholeBodyTask task;
    task.stance = stance;
    task.wrench[2] = weight;
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
    Vec<12> torque = dynamics_.gravity.tail<12>();
    for (int leg = 0, k = 0; leg < kNumLegs; ++leg) {
      const Vec<3> force(0, 0, stance[leg] ? expected[k++] : 0);
      EXPECT_THAT(solution.force[leg], IsNear(force, 0.02)) << kLegNames[leg];
      torque.segment<3>(3 * leg) -= dynamics_.feet[leg].J_leg.transpose() * force;
    }
    EXPECT_THAT(JointTorque(dynamics_, solution, Vec<12>::Zero()), IsNear(torque, 0.02));
  }
}

// A pull w_x that exceeds friction, without a wanted torque: of the forces with F_x <= mu F_z the nearest to
// (w_x, m g), the projection onto the cone's edge, on which every foot then is.
TEST_F(WholeBodyQpTest, APullBeyondFrictionIsProjectedOntoTheCone) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  const double mu = 0.3, weight = model_.mass() * 9.81, pull = 90;
  ASSERT_GT(pull, mu * weight);
  WholeBodyTask task;
  task.wrench << pull, 0, weight, 0, 0, 0;
  WholeBodyQp qp(Limits());
  WholeBodySolution solution;
  ASSERT_TRUE(qp.Solve(dynamics_, task, {.friction = mu}, &solution).ok());
  const Vec<6> wrench = WrenchOf(dynamics_, solution.force);
  const double normal = (weight + mu * pull) / (1 + mu * mu);
  Vec<6> expected;
  expected << mu * normal, 0, normal, 0, 0, 0;
  EXPECT_THAT(wrench, IsNear(expected, 0.02));
  for (int leg = 0; leg < kNumLegs; ++leg) {
    EXPECT_NEAR(solution.force[leg][0], mu * solution.force[leg][2], 1e-6);
    EXPECT_GT(solution.force[leg][2], 1);
  }
}

// The circumscribed pyramid lets a diagonal pull through that the cone does not hold; the others keep within
// the cone and reach it in the direction of the pull.
TEST_F(WholeBodyQpTest, InscribedPyramidsStayInTheCone) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  const double mu = 0.3, weight = model_.mass() * 9.81;
  for (const double angle : {0.0, 0.4, std::numbers::pi / 4, 2.0}) {
    const Vec<3> direction(std::cos(angle), std::sin(angle), 0);
    WholeBodyTask task;
    task.wrench << 90 * direction[0], 90 * direction[1], weight, 0, 0, 0;
    WholeBodySolution outside;
    WholeBodyQp qp(Limits());
    for (const FrictionPyramid pyramid : {FrictionPyramid::kInscribed, FrictionPyramid::kOctagonal}) {
      WholeBodySolution inside;
      ASSERT_TRUE(qp.Solve(dynamics_, task, {.friction = mu, .friction_pyramid = pyramid}, &inside).ok());
      for (int leg = 0; leg < kNumLegs; ++leg) {
        const Vec<3>& f = inside.force[leg];
        EXPECT_LE(f.head<2>().norm(), mu * f[2] + 1e-6) << angle;
        EXPECT_GE(f.dot(direction), 0.99 * mu * f[2]) << angle;
      }
    }
    ASSERT_TRUE(qp.Solve(dynamics_, task, {.friction = mu}, &outside).ok());
    if (angle == std::numbers::pi / 4) {
      EXPECT_GT(outside.force[0].head<2>().norm(), 1.3 * mu * outside.force[0][2]);
    }
  }
}

// The feet turn the trunk by forces in different directions, of which eight sides leave more than four.
TEST_F(WholeBodyQpTest, TheOctagonalPyramidHoldsMoreAcrossTheWantedForce) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyTask task;
  task.wrench << 0, 0, model_.mass() * 9.81, 0, 0, 40;
  const auto turn = [&](FrictionPyramid pyramid) {
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    EXPECT_TRUE(qp.Solve(dynamics_, task, {.friction = 0.3, .friction_pyramid = pyramid}, &solution).ok());
    for (int leg = 0; leg < kNumLegs; ++leg)
      EXPECT_LE(solution.force[leg].head<2>().norm(), 0.3 * solution.force[leg][2] + 1e-6);
    return WrenchOf(dynamics_, solution.force)[5];
  };
  EXPECT_GT(turn(FrictionPyramid::kOctagonal), 1.05 * turn(FrictionPyramid::kInscribed));
}

// A bounded foot reaches its bound and the others carry the rest of the weight.
TEST_F(WholeBodyQpTest, ALoadIsBounded) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyTask task;
  task.wrench[2] = model_.mass() * 9.81;
  task.largest_load[kFrontLeft] = 10;
  WholeBodyQp qp(Limits());
  WholeBodySolution solution;
  ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
  EXPECT_NEAR(solution.force[kFrontLeft][2], 10, 1e-6);
  EXPECT_NEAR(WrenchOf(dynamics_, solution.force)[2], task.wrench[2], 0.5);
  task.largest_load[kFrontLeft] = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
  EXPECT_GT(solution.force[kFrontLeft][2], 20);
}

// On a slope the cone stands along its normal: the weight alone takes tan of it in friction, and what exceeds
// mu is projected.
TEST_F(WholeBodyQpTest, TheConeStandsAlongTheNormal) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  const double mu = 0.3, weight = model_.mass() * 9.81;
  for (const double slope : {0.25, 0.4}) {
    WholeBodyTask task;
    task.wrench << 0, 0, weight, 0, 0, 0;
    task.normal_W = Vec<3>(-slope, 0, 1).normalized();
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    ASSERT_TRUE(qp.Solve(dynamics_, task, {.friction = mu}, &solution).ok());
    const Vec<3> force = WrenchOf(dynamics_, solution.force).head<3>();
    if (slope < mu) {
      EXPECT_THAT(force, IsNear(Vec<3>(0, 0, weight), 0.02));
      continue;
    }
    const Vec<3> edge = (task.normal_W + mu * Vec<3>(1, 0, slope).normalized()).normalized();
    EXPECT_THAT(force, IsNear(edge * edge[2] * weight, 0.05));
  }
}

// On two feet a force from the side rolls the trunk. The weight of the moment grows with the tilt.
TEST_F(WholeBodyQpTest, ATiltedTrunkCountsMoreThanTheCoM) {
  const WholeBodyQpParams params{.moment_weight = 30, .tilt_weight = 500, .free_tilt = 0.3};
  EXPECT_EQ(params.MomentWeight(0), 30);
  EXPECT_EQ(params.MomentWeight(0.3), 30);
  EXPECT_DOUBLE_EQ(params.MomentWeight(0.7), 30 + 500 * 0.16);

  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyQp qp(Limits());
  WholeBodyTask task;
  task.stance = kDiagonal;
  task.wrench << 0, 50, model_.mass() * model_.gravity(), 0, 0, 0;
  double force_error = 0, torque_error = 0;
  for (const double tilt : {0.0, 0.3, 0.8, 2.0}) {
    task.tilt = tilt;
    WholeBodySolution solution;
    ASSERT_TRUE(qp.Solve(dynamics_, task, params, &solution).ok());
    const Vec<6> error = WrenchOf(dynamics_, solution.force) - task.wrench;
    if (tilt == 0.3) {
      EXPECT_NEAR(error.tail<3>().norm(), torque_error, 1e-9);
    } else if (tilt > 0) {
      EXPECT_LT(error.tail<3>().norm(), torque_error - 0.5);
      EXPECT_GT(error.head<3>().norm(), force_error + 0.5);
    }
    force_error = error.head<3>().norm();
    torque_error = error.tail<3>().norm();
  }
}

// On slippery ground a wrench is asked for that takes more friction than there is.
TEST_F(WholeBodyQpTest, ALightYawTorqueIsGivenUpBeforeTheOthersUnlessTheRobotTurns) {
  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyTask task;
  task.wrench << 30, 20, model_.mass() * model_.gravity(), 10, 0, 30;
  const auto error = [&](double yaw_weight, double turn) {
    task.turn = turn;
    const WholeBodyQpParams params{.moment_weight = 30,
                                   .yaw_weight = yaw_weight,
                                   .turn_weight = 1000,
                                   .free_turn = 0.2,
                                   .friction = 0.3};
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    EXPECT_TRUE(qp.Solve(dynamics_, task, params, &solution).ok());
    return Vec<6>(WrenchOf(dynamics_, solution.force) - task.wrench);
  };
  const Vec<6> heavy = error(30, 0), light = error(0.3, 0.2), turning = error(0.3, 0.2 + std::sqrt(0.0297));
  EXPECT_GT(std::abs(light[5]), std::abs(heavy[5]) + 1);
  EXPECT_LT(light.segment<2>(3).norm(), heavy.segment<2>(3).norm() / 2);
  EXPECT_LT(light.head<3>().norm(), heavy.head<3>().norm());
  EXPECT_THAT(turning, IsNear(heavy, 1e-9));
  EXPECT_THAT(error(0.3, 2), IsNear(heavy, 1e-9));
}

TEST_P(WholeBodyQpTest, ItsMotionIsTheDynamicsWithDisturbances) {
  RandomStream random(1);
  int limited = 0, on_the_pyramid = 0;
  for (int i = 0; i < 60; ++i) {
    model_.Calc(RandomWalking(robot_, random), &dynamics_);
    const WholeBodyTask task = RandomTask(model_, GetParam(), random);
    const double limit = i % 2 == 0 ? 60 : 22;
    const WholeBodyQpParams params{.friction = 0.7};
    WholeBodyQp qp(Vec<12>::Constant(limit));
    WholeBodySolution solution;
    const QpReport report = qp.Solve(dynamics_, task, params, &solution);
    if (report.status == QpStatus::kInfeasible) continue;  // some need more torque than there is
    ASSERT_TRUE(report.ok()) << report.Message();
    EXPECT_TRUE(IsOptimal(qp.problem(), qp.solver())) << i;

    const Vec<12> torque = JointTorque(dynamics_, solution, task.joint_disturbance);
    Vec<18> other;
    other << AboutBase(dynamics_, task.disturbance), task.joint_disturbance;
    EXPECT_THAT(ForwardDynamics(dynamics_, torque, solution.force, other),
                IsNear(solution.acceleration, 1e-6 * (1 + solution.acceleration.norm())));
    EXPECT_LE(torque.cwiseAbs().maxCoeff(), limit + 1e-6);
    limited += torque.cwiseAbs().maxCoeff() > limit - 1e-6;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Vec<3> f = solution.force[leg];
      if (!task.stance[leg]) {
        EXPECT_EQ(f, Vec<3>(Vec<3>::Zero()));
        continue;
      }
      EXPECT_LE(f.head<2>().cwiseAbs().maxCoeff(), params.friction * f[2] + 1e-6);
      on_the_pyramid += f.head<2>().cwiseAbs().maxCoeff() > params.friction * f[2] - 1e-6;
      const Vec<3> a = dynamics_.FootJacobian(leg) * solution.acceleration + dynamics_.feet[leg].bias;
      EXPECT_THAT(a, IsNear(task.foot_acceleration[leg], 1e-7));
    }
  }
  if (GetParam() != kNone) {
    EXPECT_GT(limited, 0);
    EXPECT_GT(on_the_pyramid, 0);
  }
}

TEST_P(WholeBodyQpTest, EliminationKeepsTheSolution) {
  RandomStream random(2);
  int compared = 0;
  DualActiveSet solver = test::FullWholeBodySolver();
  for (int i = 0; i < 60; ++i) {
    model_.Calc(RandomWalking(robot_, random), &dynamics_);
    const WholeBodyTask task = RandomTask(model_, GetParam(), random);
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    const QpReport report = qp.Solve(dynamics_, task, {}, &solution);
    ASSERT_EQ(report.status,
              solver.Solve(test::FullWholeBodyQp(dynamics_, task, {}, Limits()).view()).status);
    if (!report.ok()) continue;
    ++compared;
    const Vec<18> acceleration = solver.x().head<18>();
    EXPECT_THAT(solution.acceleration, IsNear(acceleration, 1e-8 * (1 + acceleration.norm())));
    for (int leg = 0; leg < kNumLegs; ++leg) {
      if (!task.stance[leg]) continue;
      EXPECT_THAT(solution.force[leg], IsNear(Vec<3>(solver.x().segment<3>(18 + 3 * leg)), 1e-8 * 200));
    }
  }
  EXPECT_GT(compared, 45);
}

TEST_F(WholeBodyQpTest, SwingFeetGetTheAccelerationsThatAreAskedFor) {
  RandomStream random(3);
  for (const auto& stance : {kDiagonal, kThree}) {
    model_.Calc(RandomWalking(robot_, random), &dynamics_);
    WholeBodyTask task = RandomTask(model_, stance, random);
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
    for (int leg = 0; leg < kNumLegs; ++leg) {
      if (stance[leg]) continue;
      const Vec<3> a = dynamics_.FootJacobian(leg) * solution.acceleration + dynamics_.feet[leg].bias;
      EXPECT_THAT(a, IsNear(task.foot_acceleration[leg], 1e-3));
    }
  }
}

TEST_F(WholeBodyQpTest, AFeasibleWrenchIsRealised) {
  RandomStream random(4);
  model_.Calc(test::Standing(robot_), &dynamics_);
  WholeBodyTask task;
  task.wrench << 20, -15, model_.mass() * model_.gravity() + 30, 4, -5, 3;
  WholeBodyQp qp(Limits());
  WholeBodySolution solution;
  ASSERT_TRUE(qp.Solve(dynamics_, task, {}, &solution).ok());
  EXPECT_THAT(WrenchOf(dynamics_, solution.force), IsNear(task.wrench, 0.02));
  // Newton and Euler about the CoM, from the model's own centroidal quantities.
  const Vec<3> a = dynamics_.M.topRows<3>() * solution.acceleration / model_.mass() + dynamics_.com_bias_W;
  EXPECT_THAT((model_.mass() * (a + Vec<3>(0, 0, 9.81))).eval(), IsNear(task.wrench.head<3>(), 0.02));
  const Vec<3> rate = dynamics_.angular_map * solution.acceleration + dynamics_.angular_momentum_bias_W;
  EXPECT_THAT(rate, IsNear(task.wrench.tail<3>(), 0.02));
}

TEST_F(WholeBodyQpTest, AStraightKneeHardlyChangesTheSolution) {
  LeggedState x = test::Standing(robot_);
  // The front right knee where the determinant of J_leg changes its sign: hip, knee and foot on a line.
  double bent = -0.5, beyond = 0.5;
  const auto determinant = [&](double knee) {
    x.q[5] = knee;
    model_.Calc(x, &dynamics_);
    return dynamics_.feet[kFrontRight].J_leg.determinant();
  };
  ASSERT_LT(determinant(bent) * determinant(beyond), 0);
  for (int i = 0; i < 60; ++i) {
    const double middle = (bent + beyond) / 2;
    (determinant(middle) * determinant(bent) > 0 ? bent : beyond) = middle;
  }
  for (const auto& stance : {kAll, kDiagonal}) {
    WholeBodyTask task;
    task.stance = stance;
    task.wrench[2] = model_.mass() * model_.gravity();
    WholeBodyQp qp(Limits());
    WholeBodySolution solution;
    const QpReport report = qp.Solve(dynamics_, task, {}, &solution);
    ASSERT_TRUE(report.ok()) << report.Message();
    EXPECT_TRUE(IsOptimal(qp.problem(), qp.solver()));
    DualActiveSet solver = test::FullWholeBodySolver();
    ASSERT_TRUE(solver.Solve(test::FullWholeBodyQp(dynamics_, task, {}, Limits()).view()).ok());
    for (int leg = 0; leg < kNumLegs; ++leg) {
      if (!stance[leg]) continue;
      EXPECT_THAT(solution.force[leg], IsNear(Vec<3>(solver.x().segment<3>(18 + 3 * leg)), 1));
    }
    EXPECT_LE(JointTorque(dynamics_, solution, Vec<12>::Zero()).cwiseAbs().maxCoeff(), 60 + 1e-6);
  }
}

TEST_F(WholeBodyQpTest, TheLastSolutionStartsTheNextAndAFailureLeavesIt) {
  RandomStream random(5);
  const LeggedState x = RandomWalking(robot_, random);
  model_.Calc(x, &dynamics_);
  WholeBodyTask task;
  task.stance = kDiagonal;
  task.wrench << 250, 0, model_.mass() * model_.gravity(), 0, 0, 0;  // more than friction gives
  WholeBodyQp qp(Limits());
  WholeBodySolution solution;
  const QpReport cold = qp.Solve(dynamics_, task, {}, &solution);
  ASSERT_TRUE(cold.ok()) << cold.Message();
  EXPECT_GT(cold.iterations, 0);
  EXPECT_GT(solution.num_active, 0);
  EXPECT_EQ(qp.Solve(dynamics_, task, {}, &solution).iterations, 0);

  const WholeBodySolution before = solution;
  task.joint_disturbance.setConstant(1e4);  // needs torques that nobody has
  const QpReport report = qp.Solve(dynamics_, task, {}, &solution);
  EXPECT_EQ(report.status, QpStatus::kInfeasible);
  EXPECT_EQ(solution.acceleration, before.acceleration);
  EXPECT_TRUE(solution.valid);
}

TEST_P(WholeBodyQpTest, DoesNotAllocate) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  RandomStream random(6);
  model_.Calc(RandomWalking(robot_, random), &dynamics_);
  const WholeBodyTask task = RandomTask(model_, GetParam(), random);
  WholeBodyQp qp(Limits());
  WholeBodySolution solution;
  const AllocationGuard guard;
  qp.Solve(dynamics_, task, {}, &solution);
  SwingFootAcceleration(dynamics_, task.stance, solution.force);
  EXPECT_EQ(guard.count(), 0);
}

// The projector of (2.36), formed as printed.
TEST_P(WholeBodyQpTest, SwingFootAccelerationIsThatOfTheProjector) {
  RandomStream random(7);
  const auto& stance = GetParam();
  model_.Calc(RandomWalking(robot_, random), &dynamics_);
  FootForces force;
  for (int leg = 0; leg < kNumLegs; ++leg) force[leg] = RandomVector<3>(random, 50);
  Eigen::MatrixXd J_st(0, 18);
  Eigen::VectorXd push = Eigen::VectorXd::Zero(18);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (stance[leg]) {
      J_st.conservativeResize(J_st.rows() + 3, 18);
      J_st.bottomRows(3) = dynamics_.FootJacobian(leg);
    } else {
      push += dynamics_.FootJacobian(leg).transpose() * force[leg];
    }
  }
  Eigen::MatrixXd P = Eigen::MatrixXd::Identity(18, 18);
  if (J_st.rows() > 0) P -= J_st.completeOrthogonalDecomposition().pseudoInverse() * J_st;
  const Eigen::MatrixXd M_c = P * dynamics_.M + Eigen::MatrixXd::Identity(18, 18) - P;
  const Eigen::VectorXd acceleration = test::Solve(M_c, P * push);
  const auto pushed = SwingFootAcceleration(dynamics_, stance, force);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Vec<3> expected =
        stance[leg] ? Vec<3>(Vec<3>::Zero()) : Vec<3>(dynamics_.FootJacobian(leg) * acceleration);
    EXPECT_THAT(pushed[leg], IsNear(expected, 1e-7 * (1 + expected.norm())));
  }
}

TEST(WholeBodyQp, RefusesLimitsOfNothing) {
  EXPECT_TRUE(Throws<ParameterError>([] { WholeBodyQp{Vec<12>::Zero()}; }, "torque limits"));
}

}  // namespace tenon::whole_body_qp_test
